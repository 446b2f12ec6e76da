"""The measure itself, and a small part of it."""

import random

import pytest
from measure import (
    GUARDED,
    KINDS,
    SEED,
    Outcome,
    changes,
    judged,
    kind_of,
    measure,
    scores,
    servers,
    wilson,
)
from transitions import BEFORE, IDLE, Misled, all_misled

from conformance.faults.catalogue import build_node, find_deviation
from conformance.reference.segmented_server import SegmentedServer
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.layout import Multiplexer

TEXT = Multiplexer(0x1008)
SOME = 1


@pytest.mark.parametrize(
    ("caught", "of", "low", "high"),
    [(9, 10, 0.596, 0.982), (0, 10, 0.0, 0.278), (10, 10, 0.722, 1.0), (90, 100, 0.826, 0.945)],
)
def test_the_interval(caught: int, of: int, low: float, high: float) -> None:
    assert list(wilson(caught, of)) == pytest.approx([low, high], abs=1e-3)


def test_the_scores() -> None:
    outcomes = [Outcome(GUARDED, "a", quick=True, whole=True)] * 3
    outcomes += [Outcome(GUARDED, "b", quick=False, whole=number > 0) for number in range(2)]
    quick, whole = scores(outcomes)
    assert quick.split()[:6] == ["guarded", "quick", "3", "of", "5:", "60.0%"]
    assert whole.split()[:6] == ["guarded", "whole", "4", "of", "5:", "80.0%"]


def test_a_wrong_next_state() -> None:
    server = build_node(None, 5).server
    reading = UploadInitiate(TEXT).encode()
    right = server.receive(reading)
    server.transfer = None
    with Misled(IDLE, "UploadInitiate", "Upload", BEFORE).installed():
        assert server.receive(reading) == right
        assert server.transfer is None
    assert server.receive(reading) == right
    assert server.transfer is not None


def test_each_transition_has_another_next_state() -> None:
    found = all_misled()
    assert len(found) > 80
    assert not any(each.wrong == IDLE == each.next for each in found)
    assert SegmentedServer.receive.__name__ == "receive"


def test_what_was_judged_is_there_and_has_a_reason() -> None:
    for judgement in ("equivalent", "lives"):
        for name, reason in judged()[judgement].items():
            assert name in changes() or find_deviation(name)
            assert len(reason.split()) > 5


@pytest.mark.parametrize("kind", KINDS)
def test_some_are_caught(kind: str) -> None:
    for name in random.Random(SEED).sample(servers(kind), SOME):
        assert kind_of(name) == kind
        assert measure(name).whole or name in judged()["lives"], name
