"""The oracle accepts whatever the reference server and all unusual servers answer."""

import pytest
from hypothesis import given, note, settings
from oracle_strategies import SCRIPTS
from support.oracle_lockstep import (
    Lockstep,
    known_entries,
    of_the_protocol,
    reference_node,
    started,
)
from support.oracle_objects import NODE_ID
from support.oracle_rejections import all_scripts
from support.oracle_sequences import Script
from support.sdo_strategies import UNHURRIED

from conformance.faults.catalogue import build_node, find_deviation, unusual
from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import About
from conformance.sdo.objects import AS_WRITTEN, Habits
from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import Level, Violation

# What aborts its transfers now and then is told apart by trying again, which an oracle cannot.
ABORTS_NOW_AND_THEN = "seventh-transfer-aborted"
VARIANTS = [
    name
    for name in of_the_protocol(unusual(), (About.TRANSFERS, About.LENGTHS))
    if not name.startswith(ABORTS_NOW_AND_THEN)
]
# What a run finds out of strings before its cases begin (beginning/survey.py).
HABITS = {
    "strings-cut-to-20-bytes": Habits(cut=20),
    "one-string-padded-with-blanks-and-cut": Habits(filled=20, padding=b" ", cut=20),
    "one-string-cut-and-empty-as-00h": Habits(cut=20),
}
# One in 361 of the generated scripts is played with each variant, one in 11 with the reference.
STRIDE, REFERENCE_STRIDE = 361, 11


def with_variant(name: str) -> Lockstep:
    """How much a variant's strings hold is not known, or longer ones would have to be taken."""
    node = started(build_node(name, NODE_ID))
    knowledge = known_entries(node, roomy=False, habits=HABITS.get(name, AS_WRITTEN))
    return Lockstep(node, Oracle(knowledge, NODE_ID))


def too_grave(found: list[Violation], name: str) -> list[Violation]:
    deviation = find_deviation(name)
    assert deviation is not None
    return [one for one in found if one.rule.level is Level.MUST or not deviation.soft]


@pytest.mark.parametrize("name", VARIANTS)
def test_unusual_server_answers_at_once(name: str) -> None:
    """Nothing here lets time pass: an answer that is held back would be none."""
    assert not isinstance(build_node(name, NODE_ID), AnswersLater)


@settings(UNHURRIED, max_examples=100)
@given(SCRIPTS)
def test_reference_server_is_accepted(script: Script) -> None:
    lockstep = Lockstep(reference_node())
    found = lockstep.play(script)
    note("\n".join(lockstep.log))
    assert found == []


@pytest.mark.parametrize("name", VARIANTS)
@settings(UNHURRIED, max_examples=10)
@given(SCRIPTS)
def test_unusual_server_is_accepted(name: str, script: Script) -> None:
    lockstep = with_variant(name)
    found = lockstep.play(script)
    note("\n".join(lockstep.log))
    assert too_grave(found, name) == []


def test_reference_server_is_accepted_in_generated_scripts() -> None:
    for script in all_scripts()[::REFERENCE_STRIDE]:
        lockstep = Lockstep(reference_node())
        assert lockstep.play(script) == [], "\n".join(lockstep.log)


@pytest.mark.parametrize("name", VARIANTS)
def test_unusual_server_is_accepted_in_generated_scripts(name: str) -> None:
    for script in all_scripts()[VARIANTS.index(name) % STRIDE :: STRIDE]:
        lockstep = with_variant(name)
        found = lockstep.play(script)
        assert too_grave(found, name) == [], "\n".join(lockstep.log)


@given(SCRIPTS)
@settings(UNHURRIED, max_examples=50)
def test_what_the_oracle_says_of_values_is_true(script: Script) -> None:
    lockstep = Lockstep(reference_node())
    lockstep.play(script)
    for mux, values in lockstep.oracle.values.items():
        held = lockstep.node.server.objects.find(mux).value
        assert values is None or held in values, f"{mux}: {held!r}"


def test_a_short_frame_may_cross_with_the_abort_of_a_sub_block() -> None:
    """The server is idle when it gets it, and may refuse it as a request."""
    oracle = Oracle(None, 5)
    oracle.request(bytes.fromhex("C610200014000000"))
    assert oracle.response(bytes.fromhex("A41020007F000000")) == []
    oracle.request(bytes.fromhex("D610200000000000"))
    oracle.request(b"")
    ended = oracle.response(bytes.fromhex("8010200003000405"))
    assert [found.level.value for found in ended] == ["SHOULD"]
    assert oracle.response(bytes.fromhex("8000000000000008")) == []
