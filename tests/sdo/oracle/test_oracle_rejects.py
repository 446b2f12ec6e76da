"""For every faulty server there is a script in which the oracle rejects it."""

import pytest
from support.oracle_lockstep import of_the_protocol
from support.oracle_rejections import all_scripts, minded, rejected, remembered, search

from conformance.faults.catalogue import faults

NOT_JUDGED = {
    "read-only-refused-and-begun": "no script sends segments behind the refusal of an initiate",
    "download-short-segments-padded": "it is right to look at n in the last segment only",
    "unsized-download-empties-string": "a string may hold anything behind an aborted download",
    "download-too-few-refused-and-stored": "a string may keep what came of a refused download",
    "stray-segment-stored-by-next-block-upload": "a client of the protocol sends no such segment",
}
NAMES = [name for name in of_the_protocol(faults()) if name not in NOT_JUDGED]


@pytest.mark.parametrize("name", NAMES)
def test_fault_is_rejected(name: str) -> None:
    number = remembered().get(name, 0)
    # Where it was found the last time, or else anywhere.
    if number >= len(all_scripts()) or rejected(name, number) is None:
        assert search(name) is not None


@pytest.mark.parametrize(
    "number", sorted({at for at in remembered().values() if at < len(all_scripts())})
)
def test_the_right_server_is_not_rejected_there(number: int) -> None:
    assert minded(None, number) == []
