"""The worked exchanges are accepted; those that are irregular are flagged for just that."""

import pytest
from support.sdo_vectors import Vector, load

from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import Violation

VECTORS = load()
# Responses that break a rule.
VIOLATIONS = {
    "V60": ["response.reserved", "response.reserved"],
    "V65": ["upload.size"],
}
# Odd requests, and aborts that answer them: what the oracle records of them.
FREEDOMS = {
    "V15": ("multiplexer of an abort without a transfer", "another"),
    "V44": ("reserved bytes in a request", "ignored"),
    "V55": ("n = 0 in a short last segment", "not stated"),
    "V84": ("abort by block-download.crc", "05040004h (CRC error)"),
    "V97": ("abort by segmented-download.too-many", "06070012h (length too high)"),
}


def judged(vector: Vector) -> tuple[Oracle, list[Violation]]:
    """Follow an exchange of a server of which nothing is known."""
    oracle = Oracle()
    found: list[Violation] = []
    before = ""
    for step in vector.steps:
        if step.direction == "response":
            found += oracle.response(step.frame)
        elif step.direction == "silence":
            found += oracle.silence()
        else:
            # In the block downloads of these exchanges, segments follow each other unanswered.
            found += oracle.settled() if before == "response" else []
            oracle.request(step.frame)
        before = step.direction
    return oracle, found + oracle.settled()


@pytest.mark.parametrize("vector_id", VECTORS)
def test_exchange_is_accepted_but_for_its_irregularity(vector_id: str) -> None:
    vector = VECTORS[vector_id]
    _, found = judged(vector)
    assert [violation.rule.id for violation in found] == VIOLATIONS.get(vector_id, []), found


def test_every_irregularity_is_flagged() -> None:
    irregular = {name for name, vector in VECTORS.items() if vector.irregularity}
    assert irregular == {*VIOLATIONS, *FREEDOMS}


@pytest.mark.parametrize("vector_id", FREEDOMS)
def test_odd_exchange_shows_in_the_profile(vector_id: str) -> None:
    oracle, _ = judged(VECTORS[vector_id])
    topic, choice = FREEDOMS[vector_id]
    assert choice in oracle.profile[topic]


@pytest.mark.parametrize("topic", sorted({topic for topic, _ in FREEDOMS.values()}))
def test_regular_exchange_does_not(topic: str) -> None:
    odd = {choice for found, choice in FREEDOMS.values() if found == topic}
    for vector in VECTORS.values():
        if not vector.irregularity:
            assert not odd & judged(vector)[0].profile[topic]
