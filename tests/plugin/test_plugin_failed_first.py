"""--lf, --ff and --sw: what failed in one run comes again in the next, whatever its id."""

import pytest
from plugin_runs import NO_HYPOTHESIS, reports
from support.selected_files import other_files

pytest_plugins = ["pytester"]

# Remote frames are in the first of the files that are chosen here, and always come last.
CHOSEN = ("-k", "frame.remote or segmented-upload.toggle or abort.frame")
FAULT = "--sdo-fault=answers-remote"
FAILING = ["frame.remote[0]", "frame.remote[8]"]


def cases_run(pytester: pytest.Pytester, *arguments: str) -> list[str]:
    """Return the ids of the cases of a run that remembers the one before, in their order."""
    result = pytester.runpytest_inprocess(
        *NO_HYPOTHESIS,
        f"--sdo-report-dir={reports(pytester)}",
        "--self-test",
        "--sdo-simulated",
        "-v",
        *CHOSEN,
        *other_files(CHOSEN),
        *arguments,
    )
    return [
        line.partition("::")[2].partition(" ")[0]
        for line in result.outlines
        if line.startswith("cases/") and line.split()[1:3] != ["NOT", "RUN"]
    ]


def test_lf_runs_what_failed_and_nothing_else(pytester: pytest.Pytester) -> None:
    assert set(FAILING) < set(cases_run(pytester, FAULT))
    assert cases_run(pytester, FAULT, "--lf") == FAILING
    assert cases_run(pytester, "--lf") == FAILING, "they pass"
    assert len(cases_run(pytester, "--lf")) > len(FAILING), "nothing had failed"


def test_ff_runs_all_and_first_what_failed(pytester: pytest.Pytester) -> None:
    before = cases_run(pytester, FAULT)
    assert before[:2] != FAILING
    again = cases_run(pytester, FAULT, "--ff")
    assert again == FAILING + [case for case in before if case not in FAILING]


def test_sw_goes_on_from_the_case_that_failed(pytester: pytest.Pytester) -> None:
    """In the order of the run, which is not that of the files."""
    in_order = cases_run(pytester)
    places = [in_order.index(case) for case in FAILING]
    assert 0 < places[0] < places[1]
    assert cases_run(pytester, FAULT, "--sw") == in_order[: places[0] + 1]
    assert cases_run(pytester, FAULT, "--sw") == in_order[places[0] : places[0] + 1]
    assert cases_run(pytester, FAULT, "--sw-skip") == in_order[places[0] : places[1] + 1]
    assert cases_run(pytester, "--sw") == in_order[places[1] :]


def test_with_several_devices_the_node_id_stands_before_the_brackets(
    pytester: pytest.Pytester,
) -> None:
    """Brackets at the end are parameters to pytest, anything else is a part of the name."""
    again = (FAULT, "--node-id=5,9")
    failed = [
        f"{name}@{node_id}{bracket}{label}"
        for node_id in (5, 9)
        for name, bracket, label in (case.partition("[") for case in FAILING)
    ]
    assert set(failed) < set(cases_run(pytester, *again))
    assert cases_run(pytester, *again, "--lf") == failed
