"""-n: several devices at once, each left to one worker, and one report of all."""

import re
from collections import defaultdict

import pytest
from plugin_runs import QUICK, parsed, reports, self_test, the_report
from support.selected_files import other_files

from conformance.plugin.exit_code import ExitCode
from conformance.plugin.workers import shares_of

pytest_plugins = ["pytester"]

CHOSEN = ("-k", "abort or specifier.block-upload or upload.identity or test_whole_run")
WRONG = "--sdo-fault=identity-count-wrong"
THREE = ("--self-test", "--node-id=5,9,12", WRONG, *CHOSEN)


def run_workers(pytester: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    """Run the suite with workers, which are processes."""
    folder = f"--sdo-report-dir={reports(pytester)}"
    return pytester.runpytest_subprocess(*QUICK, folder, *arguments, *other_files(arguments))


def cases(pytester: pytest.Pytester) -> list[tuple[str, str, str]]:
    """Return what became of each case, in the order of the report."""
    found = [
        (
            case.attrib["classname"],
            case.attrib["name"],
            " ".join(child.tag for child in case if child.tag != "system-out"),
        )
        for case in parsed(the_report(pytester) / "junit.xml").iter("testcase")
    ]
    assert found
    return found


def properties(pytester: pytest.Pytester) -> dict[str, str]:
    """Return what a report says of the run and its devices."""
    root = parsed(the_report(pytester) / "junit.xml")
    found = {p.attrib["name"]: p.attrib["value"] for p in root.iter("property")}
    found["bus"] = re.sub(r"conformance-\S+", "CHANNEL", found["bus"])
    return found


def rows(result: pytest.RunResult) -> list[str]:
    """Return the rows of the devices and the lines below them."""
    return [line for line in result.outlines if re.match(r"( \d\. )?node \d+: |\d+ pass", line)]


def log_lines(pytester: pytest.Pytester) -> list[str]:
    """Return the one log of the run."""
    (log,) = the_report(pytester).glob("bus*.log")
    return log.read_text(encoding="utf-8").splitlines()


def test_three_devices_on_two_workers(pytester: pytest.Pytester) -> None:
    result = run_workers(pytester, *THREE, "-n", "2", "-v")
    assert result.ret == pytest.ExitCode.TESTS_FAILED

    workers = defaultdict(set)
    for worker, node in re.findall(r"^\[(gw\d)\].*@(\d+)", result.stdout.str(), re.MULTILINE):
        workers[worker].add(node)
    assert dict(workers) == {"gw0": {"5", "12"}, "gw1": {"9"}}

    at_once, described, told = cases(pytester), properties(pytester), rows(result)
    log = log_lines(pytester)
    assert [line[1:18] for line in log] == sorted(line[1:18] for line in log)
    asked = {match[1] for line in log if (match := re.search(r" (60\w)#\S* T$", line))}
    assert asked == {"605", "609", "60C"}
    the_report(pytester).rename(pytester.path / "at once")
    in_turn = self_test(pytester, *THREE)
    assert at_once == cases(pytester)
    assert described == properties(pytester)
    assert told == rows(in_turn)
    assert len(told) == 3 + 1 + 3, "a row for each device, one for all, and a cause of each device"
    assert len(log) == len(log_lines(pytester)), "each frame stands once in the log"
    expected = in_turn.parseoutcomes()
    expected.pop("deselected")
    assert result.parseoutcomes() == expected


def test_the_evidence_is_that_of_one_process(pytester: pytest.Pytester) -> None:
    result = run_workers(pytester, "--self-test", WRONG, "-k", "upload.identity", "-n", "2")
    result.stdout.fnmatch_lines(
        [
            "upload.identity: FAIL (MUST, CiA 301 clause *, node 5)",
            "  to repeat what was sent:",
            "FAILED cases/*::upload.identity - expected*",
        ]
    )


def test_a_device_keeps_the_order_of_its_cases(pytester: pytest.Pytester) -> None:
    result = run_workers(pytester, "--self-test", "--node-id=5,9", *CHOSEN, "-n", "2", "-v")
    found = re.findall(r"^\[gw1\].*::(\S+)@9(\S*)", result.stdout.str(), re.MULTILINE)
    began = [name + variation for name, variation in found]
    behind = ["run.reserved", "run.filler", "run.no-late-response", "run.outside-the-cases"]
    assert began[-4:] == behind
    alone = self_test(pytester, "--node-id=9", *CHOSEN, "-v")
    assert began == re.findall(r"::(\S+) +(?:PASSED|INFO|NON)", alone.stdout.str())


def test_devices_are_tested_side_by_side(pytester: pytest.Pytester) -> None:
    """While one takes its time for an answer, the others are asked."""
    slow = (
        "--node-id=5,9,12",
        "-n",
        "3",
        "--sdo-answer-delay=0.02",
        "-k",
        "frame.one or frame.mirror",
    )
    assert run_workers(pytester, "--self-test", *slow).ret == pytest.ExitCode.OK
    times = defaultdict(list)
    for line in log_lines(pytester):
        match = re.match(r"\((\d+\.\d+)\) \S+ (6\w\w)#", line)
        if match:
            times[match[2]].append(float(match[1]))
    assert set(times) >= {"605", "609", "60C"}
    under_test = [times[identifier] for identifier in ("605", "609", "60C")]
    assert max(map(min, under_test)) < min(map(max, under_test))


OWN = """
    import pytest

    @pytest.mark.parametrize("number", range(6))
    def test_mine(sdo, number):
        assert sdo.fence() == []

    @pytest.mark.parametrize("node_id", [5, 9])
    def test_each(sdo_device, node_id):
        assert sdo_device.node_id == node_id

    def test_without_a_device():
        pass
"""


@pytest.mark.parametrize("nodes", ["5", "5,9"], ids=["one-device", "two"])
def test_tests_of_the_users_own(pytester: pytest.Pytester, nodes: str) -> None:
    """Each is run once; in a self-test with fewer devices than workers they share the tests."""
    pytester.makepyfile(test_mine=OWN)
    chosen = ("test_mine.py", "-k", "not 9" if nodes == "5" else "test")
    result = run_workers(pytester, "--self-test", f"--node-id={nodes}", *chosen, "-n", "2", "-v")
    assert result.ret == pytest.ExitCode.OK
    ran = re.findall(r"^\[(gw\d)\].*::(\S+)", result.stdout.str(), re.MULTILINE)
    assert len(ran) == len({name for _, name in ran}) == (8 if nodes == "5" else 9)
    sharing = {"gw0", "gw1"} if nodes == "5" else {"gw0"}
    assert {worker for worker, name in ran if name.startswith("test_mine")} == sharing
    assert {worker for worker, name in ran if name == "test_without_a_device"} == {"gw0"}


def test_a_self_test_is_shared(pytester: pytest.Pytester) -> None:
    """Each worker has a server of its own, so they need not leave a device to one of them."""
    result = run_workers(pytester, "--self-test", WRONG, *CHOSEN, "-n", "2", "-v")
    ran = defaultdict(set)
    for worker, name in re.findall(r"^\[(gw\d)\].*::(\S+)", result.stdout.str(), re.MULTILINE):
        ran[worker].add(name)
    assert set(ran) == {"gw0", "gw1"}
    assert not ran["gw0"] & ran["gw1"]
    at_once, described, told = cases(pytester), properties(pytester), rows(result)
    assert len({line.split()[1] for line in log_lines(pytester)}) == 2, "each bus has its name"
    the_report(pytester).rename(pytester.path / "at once")
    in_turn = self_test(pytester, WRONG, *CHOSEN)
    assert sorted(at_once) == sorted(cases(pytester))
    assert described == properties(pytester)
    assert told == rows(in_turn)


def test_a_device_is_never_shared() -> None:
    """Two workers on one bus would take each other for a second client."""
    for workers in range(1, 5):
        shares = shares_of([5, 9], workers, divisible=False)
        assert sorted(node_id for share in shares for node_id in share.node_ids) == [5, 9]
        assert all(share.parts == 1 for share in shares)
    assert len(shares_of([5, 9], 5, divisible=True)) == 5


def test_nothing_selected(pytester: pytest.Pytester) -> None:
    assert run_workers(pytester, "--self-test", "-k", "no_such_case", "-n", "1").ret == 5


def test_nothing_selected_on_one_of_the_workers(pytester: pytest.Pytester) -> None:
    chosen = ("-k", "upload.identity and 5", "--node-id=5,9", "-n", "2")
    result = run_workers(pytester, "--self-test", *chosen)
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(passed=1)


def test_a_worker_for_each_device(pytester: pytest.Pytester) -> None:
    chosen = ("-k", "upload.identity", "--node-id=5,9,12", "-n", "auto", "-v")
    result = run_workers(pytester, "--self-test", *chosen)
    assert result.ret == pytest.ExitCode.OK
    found = re.findall(r"^\[(gw\d)\]", result.stdout.str(), re.MULTILINE)
    assert sorted(found) == ["gw0", "gw1", "gw2"]


HALTS = (
    *("--self-test", "--sdo-fault=unknown-specifier-halts", "--sdo-response-timeout=0.1"),
    *("-k", "specifier.unknown and FFh"),
)
FEW = ("-k", "abort.frame")
BROKEN = {
    "late-answer": (("--self-test", "--sdo-fault=answers-late", "-k", "abort.not"), 1),
    "unknown-fault": (("--self-test", "--sdo-fault=answer-late"), pytest.ExitCode.USAGE_ERROR),
    "silent-node": (
        ("--node-id=5", "--can-interface=virtual", "--sdo-response-timeout=0.1", *FEW),
        ExitCode.SILENT_NODE,
    ),
    "no-interface": (
        ("--node-id=5", "--can-interface=socketcan", "--can-channel=no-such-can0", *FEW),
        ExitCode.BENCH_ERROR,
    ),
    "lost-device": (HALTS, ExitCode.DEVICE_LOST),
    "lost-devices": ((*HALTS, "--node-id=5,9"), ExitCode.DEVICE_LOST),
}
SAID = {
    "late-answer": "late response after abort.not-answered*",
    "unknown-fault": "*Did you mean 'answers-late'?*",
    "silent-node": "Node 5 does not answer.",
    "no-interface": "socketcan no-such-can0 cannot be opened: *",
    "lost-device": "Node 5 answered before, but does not answer any more*",
    "lost-devices": "Node 9 answered before, but does not answer any more*",
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_is_wrong_is_told_as_without_workers(pytester: pytest.Pytester, what: str) -> None:
    arguments, status = BROKEN[what]
    result = run_workers(pytester, *arguments, "-n", "2")
    text = result.stdout.str() + result.stderr.str()
    assert result.ret == status
    assert "INTERNALERROR" not in text
    pytest.LineMatcher(text.splitlines()).fnmatch_lines([SAID[what]])


CRASHES = """
    import os

    def test_first(sdo):
        assert sdo.fence() == []

    def test_crash(sdo_device):
        os._exit(3)

    def test_last(sdo):
        assert sdo.fence() == []
"""


def test_a_worker_that_crashes(pytester: pytest.Pytester) -> None:
    """The run is no success, no worker takes over, and the other device is tested to the end."""
    pytester.makepyfile(test_crash=CRASHES)
    pytester.makepyfile(
        test_other="""
        import pytest

        @pytest.mark.parametrize("node_id", [9])
        @pytest.mark.parametrize("number", range(20))
        def test_each(sdo, sdo_device, node_id, number):
            assert sdo_device.node_id == 9
        """
    )
    chosen = ("test_crash.py", "test_other.py")
    result = run_workers(pytester, "--self-test", "--node-id=5,9", *chosen, "-n", "2", "-v")
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["*= the bench =*", "The process gw0 ended early*: 5.*"])
    assert len(re.findall(r"PASSED.*test_each", result.stdout.str())) == 20
    assert not re.search(r"PASSED.*test_last", result.stdout.str())


def test_several_devices_in_turn(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--node-id=5,9", "-v", "-k", "upload.identity")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["*::upload.identity@5 PASSED*", "*::upload.identity@9 PASSED*"])
    assert (the_report(pytester) / "junit.xml").is_file()
