"""-n: several devices at once, each on a worker of its own, and one report of all."""

import re
from collections import defaultdict

import pytest
from plugin_runs import QUICK, parsed, reports, self_test, the_report

from conformance.running import ExitCode

pytest_plugins = ["pytester"]

CHOSEN = ("-k", "abort or specifier.block-upload or upload.identity or test_whole_run")
TWO = ("--self-test", "--node-id=5,9", "--fault=identity-count-wrong", *CHOSEN)


def run_workers(pytester: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    """Run the suite with workers, which are processes."""
    folder = f"--report-dir={reports(pytester)}"
    return pytester.runpytest_subprocess(*QUICK, folder, *arguments)


def cases(pytester: pytest.Pytester) -> dict[tuple[str, str], str]:
    """Return what became of each case, by device, and forget the report."""
    found = {
        (case.attrib["classname"], case.attrib["name"]): " ".join(
            child.tag for child in case if child.tag != "system-out"
        )
        for case in parsed(the_report(pytester) / "junit.xml").iter("testcase")
    }
    assert found
    return found


def properties(pytester: pytest.Pytester) -> dict[str, str]:
    """Return what a report says of the run and its devices."""
    root = parsed(the_report(pytester) / "junit.xml")
    found = {p.attrib["name"]: p.attrib["value"] for p in root.iter("property")}
    found["bus"] = re.sub(r"conformance-\S+", "CHANNEL", found["bus"])
    return found


def ids(result: pytest.RunResult) -> set[str]:
    """Return the outcome and the node-ID of each case that the summary lists."""
    lines = (line for line in result.outlines if line.startswith(("PASSED ", "FAILED ")))
    return {line.partition(" - ")[0] for line in lines}


def asked(pytester: pytest.Pytester) -> list[list[str]]:
    """Return, for each worker that sent requests, the identifiers on which it did."""
    logs = [log.read_text(encoding="utf-8") for log in the_report(pytester).glob("bus*.log")]
    sent = (set(re.findall(r" (6[0-9A-F]{2})#\S* T$", log, re.MULTILINE)) for log in logs)
    return sorted(sorted(identifiers) for identifiers in sent if identifiers)


def test_two_devices_at_once(pytester: pytest.Pytester) -> None:
    result = run_workers(pytester, *TWO, "-n", "2", "-v", "-rA")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert len(list(reports(pytester).iterdir())) == 1, "one run, one report"

    workers: dict[str, set[str]] = defaultdict(set)
    for worker, node in re.findall(r"^\[(gw\d)\] .*@(\d+)", result.stdout.str(), re.MULTILINE):
        workers[node].add(worker)
    assert sorted(map(sorted, workers.values())) == [["gw0"], ["gw1"]]
    assert asked(pytester) == [["605"], ["609"]], "no worker disturbs another's device"

    at_once, described = cases(pytester), properties(pytester)
    the_report(pytester).rename(pytester.path / "at once")
    in_turn = self_test(pytester, *TWO, "-rA")
    assert at_once == cases(pytester)
    assert described == properties(pytester)
    assert ids(result) == ids(in_turn)
    expected = in_turn.parseoutcomes()
    expected.pop("deselected")
    assert result.parseoutcomes() == expected


@pytest.mark.parametrize("own", [False, True], ids=["cases", "own-tests"])
def test_one_device_is_left_to_one_worker(pytester: pytest.Pytester, own: bool) -> None:
    """Two at once would take each other for a second client."""
    pytester.makepyfile(
        test_mine="""
        import pytest

        @pytest.mark.parametrize("number", range(10))
        def test_mine(sdo, number):
            assert sdo.fence() == []
        """
    )
    chosen = ("test_mine.py",) if own else ("-k", "abort.")
    result = run_workers(pytester, "--self-test", *chosen, "-n", "2")
    assert result.ret == pytest.ExitCode.OK
    assert asked(pytester) == [["605"]]


BROKEN = {
    "late-answer": (("--self-test", "--fault=answers-late", "-k", "abort.not"), 1),
    "unknown-fault": (("--self-test", "--fault=answer-late"), pytest.ExitCode.USAGE_ERROR),
    "silent-node": (
        ("--node-id=5", "--can-interface=virtual", "--response-timeout=0.1"),
        ExitCode.SILENT_NODE,
    ),
    "no-interface": (
        ("--node-id=5", "--can-interface=socketcan", "--can-channel=no-such-can0"),
        ExitCode.BENCH_ERROR,
    ),
    "lost-device": (
        (
            *("--self-test", "--fault=unknown-specifier-halts", "--response-timeout=0.1"),
            *("-k", "specifier.unknown and FFh"),
        ),
        ExitCode.DEVICE_LOST,
    ),
}
SAID = {
    "late-answer": "came too late, after abort.not-answered*",
    "unknown-fault": "*Did you mean 'answers-late'?*",
    "silent-node": "Node 5 does not answer.",
    "no-interface": "socketcan no-such-can0 cannot be opened: *",
    "lost-device": "Node 5 answered before and does not any more*",
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_is_wrong_is_told_as_without_workers(pytester: pytest.Pytester, what: str) -> None:
    arguments, status = BROKEN[what]
    result = run_workers(pytester, *arguments, "-n", "1")
    assert result.ret == status
    text = result.stdout.str() + result.stderr.str()
    assert "INTERNALERROR" not in text
    assert text.count("ERROR cases/") <= 1, "the first one ends the run"
    pytest.LineMatcher(text.splitlines()).fnmatch_lines([SAID[what]])
