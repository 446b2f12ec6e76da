"""--sdo-thorough: what a run over night tries more of."""

import pytest
from plugin_runs import self_test

pytest_plugins = ["pytester"]


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let few examples stand for many, and a search that is not thorough have no time at all."""
    monkeypatch.setattr("conformance.plugin.options.THOROUGH_EXAMPLES", 3)
    monkeypatch.setattr("conformance.plugin.options.SEARCH_SECONDS", 0.0)


RANDOM = ("--sdo-simulated", "-k", "random.interrupted")


def test_each_random_case_tries_all_of_its_examples(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *RANDOM, "--sdo-thorough")
    result.stdout.fnmatch_lines(["random.interrupted: 3 of 3 examples in *"])


def test_another_number_of_examples(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *RANDOM, "--sdo-thorough", "--sdo-examples=2")
    result.stdout.fnmatch_lines(["random.interrupted: 2 of 2 examples in *"])


def test_otherwise_a_search_ends_in_time(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *RANDOM)
    result.stdout.fnmatch_lines(["info: random.interrupted: 0 of 20 examples in *"])
