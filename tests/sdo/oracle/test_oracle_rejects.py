"""For every faulty server there is a conversation in which the oracle rejects it."""

import pytest
from oracle_rejections import all_conversations, rejected, remembered, search

from conformance.faults.catalogue import faults

NAMES = [fault.name for fault in faults()]
# What the oracle alone does not see in the generated conversations, and why.
UNSEEN: dict[str, str] = {}
# Every so many conversations are held to prove that a fault is not seen.
STRIDE = 20


@pytest.mark.parametrize("name", [name for name in NAMES if name not in UNSEEN])
def test_fault_is_rejected(name: str) -> None:
    number = remembered().get(name, 0)
    # Where it was found the last time, or else anywhere.
    if number >= len(all_conversations()) or rejected(name, number) is None:
        assert search(name) is not None


@pytest.mark.parametrize("name", UNSEEN)
def test_fault_is_not_seen(name: str) -> None:
    assert name in NAMES
    numbers = range(0, len(all_conversations()), STRIDE)
    assert not any(rejected(name, number) for number in numbers)
