"""The first request behind a boot-up message."""

from collections.abc import Iterable

import pytest
from support.run_bench import BASELINE, HASTY, READ, Scripted, undiscovered

from conformance.beginning.first_request import ask_first
from conformance.sdo.rules import FIRST_REQUEST

REFUSED = bytes.fromhex("8000100000000206")
STRAY = bytes.fromhex("6010170000000000")


@pytest.mark.parametrize(
    ("first", "wrong"),
    [
        ([BASELINE], ""),
        ([REFUSED], ""),
        ([], "nothing within 50 ms"),
        ([STRAY], "download initiate response 1710h:00"),
        ([STRAY, BASELINE], "download initiate response 1710h:00"),
    ],
)
def test_what_answers_it(first: list[bytes], wrong: str) -> None:
    def answer(data: bytes) -> Iterable[bytes]:
        return first if len(node.requests) == 1 else [BASELINE]

    node = Scripted(answer)
    with undiscovered(node, timeout=HASTY) as bench:
        found = ask_first(bench.channel)
    assert (found is not None) == bool(wrong)
    if found is not None:
        assert found.rule is FIRST_REQUEST
        assert found.actual.startswith(wrong)
        assert node.requests == [READ, READ]


def test_a_device_that_answers_nothing_at_all_is_for_others_to_judge() -> None:
    with undiscovered(Scripted(lambda data: []), timeout=HASTY) as bench:
        assert ask_first(bench.channel) is None
