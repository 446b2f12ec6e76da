"""How a function becomes a case: its id, level, rules, sentence, and the values it is run for."""

import pytest

from conformance.run.case import CaseInfo, case_info, may, must, should
from conformance.sdo.rules import Level, Rule, UnknownRule, rule_of

CLAUSE = "7.2.4.3.6"
TOGGLE = rule_of("segmented-upload.toggle")


def info(function: object) -> CaseInfo:
    found = case_info(function)
    assert found is not None
    return found


@must("upload.a", clause=CLAUSE)
def of_a_must() -> None:
    """One sentence
    over two lines.
    """


@should("upload.b", clause=CLAUSE)
def of_a_should() -> None:
    """A sentence."""


@may("upload.c", clause="")
def of_a_may() -> None:
    pass


@pytest.mark.parametrize(
    ("function", "rule"),
    [
        (of_a_must, Rule("upload.a", CLAUSE, Level.MUST, "One sentence over two lines.")),
        (of_a_should, Rule("upload.b", CLAUSE, Level.SHOULD, "A sentence.")),
        (of_a_may, Rule("upload.c", "", Level.MAY, "")),
    ],
)
def test_the_decorator_says_what_reports_need(function: object, rule: Rule) -> None:
    assert info(function).rule == rule
    assert info(function).variations() == [(rule.id, {})]


def test_a_case_names_rules_by_their_ids() -> None:
    @must("upload.x", "segmented-upload.toggle", "segmented-upload.restart")
    def case() -> None:
        """A sentence."""

    assert info(case).cites == (TOGGLE, rule_of("segmented-upload.restart"))
    assert info(case).rule == Rule("upload.x", "7.2.4.3.7", Level.MUST, "A sentence.")


def test_a_case_that_is_called_as_a_rule_tests_it_first() -> None:
    @must("segmented-upload.restart", "segmented-upload.toggle")
    def case() -> None:
        """A sentence."""

    assert info(case).cites == (rule_of("segmented-upload.restart"), TOGGLE)
    assert info(case).rule.clause == "7.2.4.3.5"


@pytest.mark.parametrize("id_", ["upload.x", TOGGLE.id])
def test_no_rule_is_named_twice(id_: str) -> None:
    with pytest.raises(ValueError, match=f"{id_} names a rule twice"):
        must(id_, TOGGLE.id, TOGGLE.id)


def test_a_narrower_clause_replaces_that_of_the_rule() -> None:
    @should("upload.x", TOGGLE.id, clause="7.5.2.1")
    def case() -> None:
        """A sentence."""

    assert info(case).rule.clause == "7.5.2.1"


def test_an_unknown_rule_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownRule, match=r"'upload\.sizes'; the nearest is 'upload\.size'"):
        must("upload.x", "upload.sizes")


def test_without_a_rule_there_is_a_clause() -> None:
    with pytest.raises(ValueError, match=r"upload\.x names neither a rule nor a clause"):
        must("upload.x")(of_a_must)


def test_each_value_of_a_sequence_is_a_case() -> None:
    @must("upload.size", clause=CLAUSE, size=(8, 14))
    def case(size: int) -> None:
        """A sentence."""

    assert info(case).variations() == [
        ("upload.size[8]", {"size": 8}),
        ("upload.size[14]", {"size": 14}),
    ]


def test_the_label_of_a_value_stands_in_the_id() -> None:
    @may("upload.size", clause=CLAUSE, size={"short": 8, "long": 14})
    def case(size: int) -> None:
        """A sentence."""

    assert info(case).variations() == [
        ("upload.size[short]", {"size": 8}),
        ("upload.size[long]", {"size": 14}),
    ]


def test_the_function_itself_is_left_as_it_was() -> None:
    given = []

    def case(size: int) -> None:
        given.append(size)

    assert must("upload.x", clause=CLAUSE, size=[1])(case) is case
    case(3)
    assert given == [3]


@pytest.mark.parametrize("thing", [None, 5, print, test_the_function_itself_is_left_as_it_was])
def test_other_things_are_no_cases(thing: object) -> None:
    assert case_info(thing) is None


def test_one_argument_at_most() -> None:
    """A second one would be dropped in silence."""
    with pytest.raises(ValueError, match="one"):
        must("upload.x", clause=CLAUSE, size=[1], toggle=[0])(of_a_must)
