"""How cases are chosen by what they catch and what they cost."""

from random import Random

from catches import OWN
from cover import Choice, Costs, by_worth


def chosen(caught: dict[str, set[str]], costs: Costs, budget: int) -> list[str]:
    return sorted(Choice(caught, costs, budget, Random(1)).best())


def test_the_best_comes_first() -> None:
    catches = {"a": {"dear": 1.0, "cheap": 1.0}, "b": {"dear": 1.0}, "c": {"other": 1.0}}
    assert by_worth(catches, {"dear": 10, "cheap": 2, "other": 5}) == ["cheap", "other", "dear"]


def test_of_equals_the_one_whose_own_rule_is_broken_comes_first() -> None:
    assert by_worth({"a": {"one": 1.0, "two": OWN}}, {"one": 3, "two": 3}) == ["two", "one"]


def test_a_second_case_for_each_fault_comes_behind_the_first() -> None:
    catches = {name: {"all": 1.0, name: 1.0} for name in "abc"}
    assert by_worth(catches, {"all": 6, "a": 4, "b": 4, "c": 4})[0] == "all"


# Within a budget


def test_as_many_faults_as_the_budget_allows() -> None:
    """What catches most per request leaves no room for two others, which catch more together."""
    caught = {"greedy": {"a", "b", "c"}, "one": {"a", "b"}, "two": {"c", "d"}}
    costs = Costs({"greedy": 6, "one": 5, "two": 5})
    assert chosen(caught, costs, 10) == ["one", "two"]
    assert chosen(caught, costs, 9) == ["greedy"]
    assert chosen(caught, costs, 4) == []


def test_what_others_catch_as_well_is_not_chosen() -> None:
    caught = {"all": {"a", "b", "c"}, "some": {"a", "b"}, "cheap": {"a"}}
    assert chosen(caught, Costs({"all": 9, "some": 3, "cheap": 1}), 100) == ["all"]


def test_what_is_prepared_for_one_is_there_for_all_of_a_family() -> None:
    caught = {"set.up[1]": {"a"}, "set.up[2]": {"b"}, "plain": {"c"}}
    costs = Costs({"set.up[1]": 1, "set.up[2]": 1, "plain": 10}, {"set.up": 20})
    assert chosen(caught, costs, 22) == ["set.up[1]", "set.up[2]"]
    assert chosen(caught, costs, 21) == ["plain"]


def test_a_choice_that_costs_too_much_is_begun_from_all_the_same() -> None:
    caught = {"dear": {"a"}, "cheap": {"b"}, "cheaper": {"c"}}
    choice = Choice(caught, Costs({"dear": 9, "cheap": 2, "cheaper": 1}), 4, Random(1))
    assert sorted(choice.best(["dear", "cheap", "cheaper"])) == ["cheap", "cheaper"]


# What cases cost


def test_a_case_costs_what_it_does_in_the_dearer_order() -> None:
    """One has written before what the other reads."""
    costs = Costs.by({"read[1]": 80, "write": 40}, {"read[1]": 1, "write": 41, "lacking": 0})
    assert costs == Costs({"read[1]": 80, "write": 41})


def test_what_another_one_does_in_each_order_is_done_for_all_of_a_family() -> None:
    costs = Costs.by({"load[1]": 150, "load[2]": 2}, {"load[1]": 1, "load[2]": 150})
    assert costs == Costs({"load[1]": 1, "load[2]": 2}, {"load": 148})
    assert costs.of(["load[1]", "load[2]"]) == 151
    assert costs.shared() == {"load[1]": 75, "load[2]": 76}


def test_what_a_run_has_shown_corrects_what_was_thought() -> None:
    costs = Costs({"a": 5, "b": 5, "load[1]": 1}, {"load": 90})
    costs.correct({"a": 7, "b": 4, "load[1]": 91, "unknown": 3})
    assert costs == Costs({"a": 7, "b": 4, "load[1]": 1}, {"load": 90})
