"""Two faults in one server: both act. The table of ``pairs`` is a program of its own."""

import pytest
from case_runs import Run
from pairs import HIDDEN, MOST_CASES, PERVASIVE, SPECIFIC, Pair, Table, problem_with_pervasive

from conformance.faults.catalogue import UnknownServer, build_node, find_deviation
from conformance.faults.registry import Defect, Deviation
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.run.verdict import Verdict
from conformance.sdo.can_frame import CanFrame

NODE_ID = 5
ABORT = "80 18 10 01 00 00 00 08"
ANSWERED = "80 00 00 00 01 00 04 05"
IDENTITY = "43 18 10 01 00 00 0C 5D"
UNKNOWN = "E0 00 00 00 00 00 00 00"
START_TEXT = "21 10 20 00 0E 00 00 00"
WRONG_TOGGLE = "10 41 42 43 44 45 46 47"


def known(name: str) -> Deviation:
    deviation = find_deviation(name)
    assert deviation is not None
    return deviation


def answers_of(name: str, *requests: str) -> list[tuple[int, str]]:
    """Return what a server answers to some requests: identifiers and data."""
    node = build_node(name, NODE_ID)
    node.start()
    return [
        (answer.can_id, answer.data.hex(" ").upper())
        for request in requests
        for answer in node.receive(CanFrame(0x600 + NODE_ID, bytes.fromhex(request)))
    ]


def test_two_servers_are_one() -> None:
    pair = known("every-abort-answered+unknown-specifier-ignored")
    assert issubclass(pair.kind, Server)
    assert answers_of(pair.name, ABORT) == [(0x585, ANSWERED)]
    assert answers_of(pair.name, UNKNOWN) == []


def test_two_nodes_are_one() -> None:
    pair = known("answer-as-long-as-request+response-copied-to-other-id")
    assert issubclass(pair.kind, Node)
    assert answers_of(pair.name, "40 18 10 01") == [(0x585, IDENTITY[:11]), (0x485, IDENTITY)]


@pytest.mark.parametrize("turned", [False, True])
def test_a_node_and_a_server_are_one(*, turned: bool) -> None:
    names = ["every-abort-answered", "response-copied-to-other-id"]
    pair = known("+".join(reversed(names) if turned else names))
    assert issubclass(pair.kind, Node)
    assert answers_of(pair.name, ABORT) == [(0x585, ANSWERED), (0x485, ANSWERED)]


def test_a_reaction_of_both_is_that_of_both() -> None:
    pair = "abort-in-transfer-unnamed+download-toggle-ignored"
    assert answers_of(pair, START_TEXT, WRONG_TOGGLE)[-1] == (0x585, "30" + " 00" * 7)
    unnamed = (0x585, ANSWERED)
    assert answers_of(pair, START_TEXT, UNKNOWN)[-1] == unnamed


def test_a_pair_of_an_unknown_one_is_unknown() -> None:
    with pytest.raises(UnknownServer, match="every-abort-answered"):
        find_deviation("every-abort-answerd+unknown-specifier-ignored")


def run_of(name: str, **rules: str) -> Run:
    """Return a run in which the named cases fail for these rules."""
    verdicts = dict.fromkeys(rules, Verdict.FAIL)
    return Run(name, verdicts=verdicts, rules=dict(rules), causes=dict(rules))


def test_a_pair_is_right_when_the_specific_rule_is_named_and_no_other() -> None:
    pervasive, specific = run_of("p", a="noise"), run_of("s", b="point")
    right = Pair(pervasive, specific, run_of("p+s", a="noise", b="point"))
    assert right.problem() == ""
    assert right.told() == ["b"]
    hidden = Pair(pervasive, specific, run_of("p+s", a="noise", b="noise"))
    assert "HIDDEN: none of point" in hidden.problem()
    strange = Pair(pervasive, specific, run_of("p+s", a="noise", b="point", c="other"))
    assert "UNEXPLAINED: 1: c (other)" in strange.problem()
    strange.both.causes["c"] = "noise"
    assert strange.problem() == "", "the first to meet a cause that is known"


def test_a_rule_that_both_break_tells_in_a_case_or_by_a_cause_of_the_specific_one_only() -> None:
    pervasive, specific = run_of("p", a="same"), run_of("s", b="same")
    assert Pair(pervasive, specific, run_of("p+s", a="same", b="same")).problem() == ""
    other = run_of("p+s", a="same", c="same")
    assert Pair(pervasive, specific, other).problem() != ""
    other.causes["c"] = "same: another answer"
    assert Pair(pervasive, specific, other).problem() == ""


def test_a_pair_that_is_called_hidden_without_need_is_a_problem() -> None:
    first, second = next(iter(HIDDEN))
    table = Table()
    pervasive, specific = run_of(first, a="noise"), run_of(second, b="point")
    table.take(Pair(pervasive, specific, run_of("both", a="noise")))
    assert not table.end()
    table.take(Pair(pervasive, specific, run_of("both", a="noise", b="point")))
    assert table.end()


def test_a_pervasive_fault_fails_few_cases_in_few_causes() -> None:
    def failing(cases: int, causes: int) -> Run:
        return run_of("p", **{f"case{number}": f"{number % causes}" for number in range(cases)})

    assert problem_with_pervasive(failing(MOST_CASES, 3)) == ""
    assert problem_with_pervasive(failing(MOST_CASES + 1, 3)) != ""
    assert problem_with_pervasive(failing(10, 4)) != ""
    assert problem_with_pervasive(Run("p")) != ""


def test_the_specific_faults_are_of_all_classes() -> None:
    assert (len(set(PERVASIVE)), len(set(SPECIFIC))) == (17, 24)
    assert {known(name).defect for name in SPECIFIC} == set(Defect)
    assert all(known(name).is_fault for name in PERVASIVE)


@pytest.mark.parametrize("pervasive", PERVASIVE)
def test_no_reaction_of_a_specific_fault_is_out_of_reach(pervasive: str) -> None:
    """Where both change one reaction, that of the pervasive fault goes on to the other one."""
    kind = known(pervasive).kind
    for specific in SPECIFIC:
        for name in vars(kind).keys() & vars(known(specific).kind).keys():
            reaction = getattr(kind, name)
            if callable(reaction) and not isinstance(reaction, type):
                assert "super" in reaction.__code__.co_names, (specific, name)
