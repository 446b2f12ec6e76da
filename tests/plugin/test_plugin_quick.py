"""--sdo-quick: few cases that show nearly all, and what it leaves out is said."""

import re
from itertools import groupby

import pytest
from plugin_runs import QUICK as PLAIN
from plugin_runs import case_ids, parsed, reports, run, self_test, the_report

from conformance.device.effort import REQUESTS_IN_HASTE, REQUESTS_OF_SMALL_CASE
from conformance.plugin.case_order import table
from conformance.reporting.workload import service_of

pytest_plugins = ["pytester"]

SAID = re.compile(r"^quick: (\d+) of (\d+) cases; left out: (.*)$")


def requests(pytester: pytest.Pytester) -> int:
    """Return how many requests of a run were answered."""
    log = (the_report(pytester) / "bus.log").read_text("utf-8").splitlines()
    return sum(received for received, _ in groupby(log, lambda line: line.endswith(" R")))


def test_a_quick_run(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-simulated", "--sdo-quick")
    assert result.ret == pytest.ExitCode.OK
    assert requests(pytester) <= REQUESTS_IN_HASTE
    (said,) = [found for line in result.outlines if (found := SAID.match(line))]
    ids = case_ids(the_report(pytester) / "junit.xml")
    assert len(ids) == int(said[1]) > 100
    assert int(said[2]) == len(ids) + result.parseoutcomes()["deselected"]
    assert "matrix" in said[3]
    assert "random" in said[3]
    properties = parsed(the_report(pytester) / "junit.xml").iter("property")
    assert f"quick: {said[1]} of" in said[0]
    assert said[0].removeprefix("quick: ") in {each.attrib["value"] for each in properties}


def test_each_service_has_a_case(pytester: pytest.Pytester) -> None:
    listed = self_test(pytester, "--sdo-quick", "--collect-only", "-q").outlines
    chosen = [line for line in listed if line.startswith("cases/")]
    everything = self_test(pytester, "--collect-only", "-q").outlines
    few = {
        case_id for case_id, worth in table().items() if worth.requests <= REQUESTS_OF_SMALL_CASE
    }
    known = {line for line in everything if line.partition("::")[2] in few}
    assert {service_of(line) for line in known} <= {service_of(line) for line in chosen}
    assert "whole_run" in {service_of(line) for line in chosen}


@pytest.mark.parametrize(
    ("fault", "rule"),
    [
        ("upload-toggle-ignored", "segmented-upload.toggle"),
        ("download-toggle-ignored", "segmented-download.toggle"),
    ],
)
def test_an_ignored_toggle_is_named_as_that(
    pytester: pytest.Pytester, fault: str, rule: str
) -> None:
    result = self_test(pytester, "--sdo-simulated", "--sdo-quick", f"--sdo-fault={fault}")
    named = [line for line in result.outlines if line.startswith("fix this first: ")]
    assert [line.removeprefix("fix this first: ").partition(":")[0] for line in named] == [rule]


@pytest.mark.parametrize(
    "fault", ["upload-toggle-ignored", "every-abort-answered", "block-uploads-endless"]
)
def test_a_wrong_device_is_told(pytester: pytest.Pytester, fault: str) -> None:
    result = self_test(pytester, "--sdo-simulated", "--sdo-quick", f"--sdo-fault={fault}")
    assert result.ret == pytest.ExitCode.TESTS_FAILED


def test_each_device_has_its_own_choice(pytester: pytest.Pytester) -> None:
    arguments = ("--node-id=5,9", "-k", "abort")
    result = self_test(pytester, "--sdo-simulated", "--sdo-quick", *arguments)
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["node 5: quick: *of*", "node 9: quick: *of*"])


def test_workers_share_it(pytester: pytest.Pytester) -> None:
    folder = f"--sdo-report-dir={reports(pytester)}"
    arguments = ("--self-test", "--sdo-quick", "-k", "abort or test_whole_run", "-n", "2")
    result = pytester.runpytest_subprocess(*PLAIN, folder, *arguments)
    assert result.ret == pytest.ExitCode.OK
    assert len([line for line in result.outlines if SAID.match(line)]) == 1
    alone = pytester.runpytest_inprocess(*PLAIN, *arguments[:-2], "--collect-only", "-q").outlines
    names = {line.partition("::")[2] for line in alone if "::" in line}
    assert set(case_ids(the_report(pytester) / "junit.xml")) == names


def test_tests_of_the_user_stay(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine="def test_mine(sdo):\n    assert sdo.fence() == []\n")
    result = self_test(pytester, "--sdo-simulated", "--sdo-quick", "test_mine.py")
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(passed=1)


def test_it_does_not_go_with_its_contrary(pytester: pytest.Pytester) -> None:
    result = run(pytester, "--self-test", "--sdo-quick", "--sdo-thorough")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*--sdo-quick runs few cases and --sdo-thorough more than usual*"])
