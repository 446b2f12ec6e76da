"""For every faulty server there is a conversation in which the oracle rejects it."""

import pytest
from oracle_bench import of_the_protocol
from oracle_rejections import all_conversations, rejected, remembered, search

from conformance.faults.catalogue import faults

NAMES = of_the_protocol(faults())


@pytest.mark.parametrize("name", NAMES)
def test_fault_is_rejected(name: str) -> None:
    number = remembered().get(name, 0)
    # Where it was found the last time, or else anywhere.
    if number >= len(all_conversations()) or rejected(name, number) is None:
        assert search(name) is not None
