"""For every faulty server there is a conversation in which the oracle rejects it."""

import pytest
from oracle_bench import of_the_protocol
from oracle_rejections import all_conversations, rejected, remembered, search

from conformance.faults.catalogue import faults

NAMES = of_the_protocol(faults())
# What the oracle alone does not see in the generated conversations, and why.
UNSEEN = {
    "answers-late": "the answer comes many transfers later",
    "abandoned-upload-deaf": "no generated upload follows the abort of one at once",
    "refusal-leaves-size": "needs a refusal of another kind than the generated ones",
    "transfers-run-out": "needs more aborted transfers than are generated in a row",
    "abort-undoes-last-download": "the generated value before is the same",
    "short-abort-served": "the generated short abort does not meet the upload where it is served",
    "block-download-crc-unused-checked": "the generated CRC fields are 0 where none is used",
}
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
