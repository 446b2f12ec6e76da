"""--sdo-thorough: what a run over night tries more of."""

from itertools import product

import pytest
from plugin_runs import case_ids, self_test, the_report

from conformance.model_cases.server_states import STATES

pytest_plugins = ["pytester"]


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let few examples stand for many, and a search that is not thorough have no time at all."""
    monkeypatch.setattr("conformance.device.effort.THOROUGH_EXAMPLES", 3)
    monkeypatch.setattr("conformance.device.effort.SEARCH_SECONDS", 0.0)


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


# Pairs of states


def test_every_pair_of_states(pytester: pytest.Pytester) -> None:
    chosen = ("-k", "pairs.behind-abort or pairs.superseded or pairs.on-two-channels")
    result = self_test(pytester, "--sdo-simulated", "--sdo-thorough", *chosen)
    assert result.ret == pytest.ExitCode.OK
    outcomes = result.parseoutcomes()
    assert set(outcomes) == {"passed"}
    open_ones = [name for name, state in STATES.items() if state.segment is None and name != "idle"]
    aborted, ended = product(STATES, STATES), product(open_ones, STATES)
    due = {f"pairs.behind-abort[{first}-then-{second}]" for first, second in aborted}
    due |= {f"pairs.superseded[{first}-then-{second}]" for first, second in ended}
    waiting = product((name for name in STATES if name != "idle"), STATES)
    due |= {f"pairs.on-two-channels[{first}-beside-{second}]" for first, second in waiting}
    assert set(case_ids(the_report(pytester) / "junit.xml")) == due
    assert outcomes["passed"] == len(due) == (15 + 11 + 14) * 15


def listed(pytester: pytest.Pytester, *arguments: str) -> list[str]:
    """Return the ids of the cases that a run would have."""
    lines = self_test(pytester, "--collect-only", "-q", *arguments).outlines
    return [line.partition("::")[2] for line in lines if line.startswith("cases/")]


def test_a_usual_run_has_no_pairs_of_states(pytester: pytest.Pytester) -> None:
    usual, thorough = listed(pytester), listed(pytester, "--sdo-thorough")
    assert len(usual) > 3000
    assert not [case for case in usual if case.startswith("pairs.")]
    assert {case for case in thorough if not case.startswith("pairs.")} == set(usual)
    assert listed(pytester, "-k", "pairs.superseded") == []


def test_what_k_chooses_of_a_thorough_run_is_told(pytester: pytest.Pytester) -> None:
    said = "conformance: only --sdo-thorough, or an argument, runs *"
    result = self_test(pytester, "-k", "pairs.superseded and idle")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    result.stdout.fnmatch_lines([said.replace("*", "pairs.superseded")])
    for others in ("no_such_case", "upload.device-type"):
        self_test(pytester, "-k", others).stdout.no_fnmatch_line(said)


@pytest.mark.parametrize("options", [(), ("--sdo-thorough",)])
def test_what_is_named_is_run(pytester: pytest.Pytester, options: tuple[str, ...]) -> None:
    one = "pairs.superseded[block-upload-end-then-idle]"
    assert listed(pytester, one, *options) == [one]
    assert len(listed(pytester, "pairs.superseded", *options)) == 11 * 15


def test_known_deviations_may_name_what_a_usual_run_has_not(pytester: pytest.Pytester) -> None:
    """One file is for both: such an entry is neither mistyped nor stale."""
    entries = (
        "case = 'pairs.superseded[block-upload-end-then-idle]'",
        "case = 'pairs.behind-abort[*'",
        "rule = 'server.idle-afterwards'",
    )
    text = "\n".join(f"[[deviations]]\nreason = 'ticket 1'\n{entry}" for entry in entries)
    (pytester.path / "known.toml").write_text(text, encoding="utf-8")
    usual = ("--sdo-simulated", "-k", "sequence.uploads", "--sdo-deviations=known.toml")
    assert self_test(pytester, *usual).ret == pytest.ExitCode.OK
    result = self_test(pytester, *usual, "pairs.superseded", "-k", "block-upload-end-then-idle")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*block-upload-end-then-idle*: STALE DEVIATION *"])
