"""A very long value is written in segments once in a run, by whatever object shows that it goes."""

import pytest
from support.run_bench import DOMAIN, TEXT, discovered, recording

from conformance.dialogue.object_expectations import is_known_to_go


@pytest.mark.parametrize(
    ("whole", "size", "known"),
    [
        (4097, 4096, True),
        (4097, 4098, False),
        (65_544, 4096, True),
        (65_544, 200_000, True),  # no counter of 16 bits is in the way any more
        (65_535, 65_536, False),
        (4097, 1000, False),  # is not very long
    ],
)
def test_what_counts_as_far_is_known_to_go(whole: int, size: int, known: bool) -> None:
    with discovered(recording()) as bench:
        assert not is_known_to_go(bench.device, bytes(size))
        bench.device.learned.lengths[TEXT.mux].whole |= {257, whole}
        bench.device.learned.lengths[DOMAIN.mux].whole.add(20)
        assert is_known_to_go(bench.device, bytes(size)) is known
