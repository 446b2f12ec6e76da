"""Several devices of one worker: tested in turn, and reported as in a run without workers."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from plugin_runs import QUICK, hosted_on, reports, self_test, the_report
from socketcand_bus import socketcand
from support.selected_files import other_files

from conformance.plugin.exit_code import ExitCode
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.run.verdict import Verdict
from conformance.sdo.can_frame import CanFrame

pytest_plugins = ["pytester"]

NODES = (5, 9, 12)
TWO = "--node-id=5,9"
CHOSEN = ("-k", "abort or specifier.block-upload or upload.identity or test_whole_run")
WRONG = "--sdo-fault=identity-count-wrong"
# Only a program that hangs takes this time, in seconds, on any machine.
HANGS = 600.0


def one_worker(pytester: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    """Run the suite with one worker for all devices."""
    folder = f"--sdo-report-dir={reports(pytester)}"
    return pytester.runpytest_subprocess(
        *QUICK, folder, "-n", "1", *arguments, *other_files(arguments)
    )


def results(folder: Path) -> dict[int, list[dict[str, Any]]]:
    """Return what a run has recorded of each device, in this order."""
    found = defaultdict(list)
    for line in (folder / "results.jsonl").read_text(encoding="utf-8").splitlines():
        if (record := json.loads(line))["record"] == "case":
            found[record["result"]["node_id"]].append(record["result"])
    return dict(found)


def verdicts(folder: Path) -> dict[int, list[tuple[str, str, str]]]:
    """Return the cases of each device, with their verdicts and causes."""
    return {
        node_id: [(case["case_id"], case["verdict"], case["cause"]) for case in cases]
        for node_id, cases in results(folder).items()
    }


def nodes_in_order(folder: Path) -> list[int]:
    """Return the node-IDs of the cases, in the order in which they were run."""
    lines = (folder / "results.jsonl").read_text(encoding="utf-8").splitlines()
    records = [json.loads(line) for line in lines]
    return [each["result"]["node_id"] for each in records if each["record"] == "case"]


def test_a_worker_tests_its_devices_in_turn(pytester: pytest.Pytester) -> None:
    chosen = ("--self-test", "--node-id=5,9,12", WRONG, *CHOSEN)
    result = one_worker(pytester, *chosen, "-v")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    folder = the_report(pytester)
    assert not list(folder.glob("not-restored*"))
    assert [log.name for log in folder.glob("bus*")] == ["bus.log"]
    nodes = nodes_in_order(folder)
    assert nodes == sorted(nodes)
    by_worker = verdicts(folder)
    folder.rename(pytester.path / "one worker")
    in_turn = self_test(pytester, *chosen)
    assert by_worker == verdicts(the_report(pytester))
    expected = in_turn.parseoutcomes()
    expected.pop("deselected")
    assert result.parseoutcomes() == expected


KEPT_AWAY = {
    "hook": """
        import pytest
        def pytest_runtest_setup(item):
            if "specifier" in item.name:
                pytest.skip("not on my bench")
        """,
    "protocol": """
        def pytest_runtest_protocol(item):
            return True if "specifier" in item.name else None
        """,
    "function": """
        import pytest
        def pytest_pyfunc_call(pyfuncitem):
            if "specifier" in pyfuncitem.name:
                pytest.skip("not on my bench")
        """,
    "mark": """
        import pytest
        def pytest_collection_modifyitems(items):
            for item in items:
                if "specifier" in item.name:
                    item.add_marker(pytest.mark.skip("not on my bench"))
        """,
    "fixture": """
        import pytest
        @pytest.fixture(autouse=True)
        def careful(request):
            if "specifier" in request.node.name:
                pytest.skip("not on my bench")
        """,
}


@pytest.mark.parametrize("way", KEPT_AWAY)
@pytest.mark.parametrize("workers", [(), ("-n", "1")], ids=["in-turn", "one-worker"])
def test_what_a_project_keeps_from_being_run_is_not_run(
    pytester: pytest.Pytester, way: str, workers: tuple[str, ...]
) -> None:
    pytester.makeconftest(KEPT_AWAY[way])
    chosen = ("-k", "abort.not-answered or specifier.unknown and FFh")
    folder = f"--sdo-report-dir={reports(pytester)}"
    arguments = ("--self-test", TWO, *chosen, f"--rootdir={pytester.path}", "--confcutdir=/")
    result = pytester.runpytest_subprocess(
        *QUICK, folder, *workers, "-p", "conftest", *arguments, *other_files(arguments)
    )
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes()["passed"]
    log = (the_report(pytester) / "bus.log").read_text(encoding="utf-8")
    assert not re.search(r" 60\d#FF\S* T$", log, re.MULTILINE)


def test_the_first_failure_ends_a_worker(pytester: pytest.Pytester) -> None:
    """Nothing more is sent to any of its devices."""
    chosen = ("--self-test", TWO, WRONG, "-x", "-k", "abort or upload.identity")
    assert one_worker(pytester, *chosen).ret == pytest.ExitCode.INTERRUPTED, "as by pytest-xdist"
    found = verdicts(the_report(pytester))
    assert [verdict for _, verdict, _ in found[5]].count(Verdict.FAIL) == 1
    assert {verdict for _, verdict, _ in found[9]} == {Verdict.NOT_RUN}


def test_nothing_is_run_that_is_only_shown(pytester: pytest.Pytester) -> None:
    chosen = ("--self-test", TWO, "-k", "specifier.unknown and FFh", "--setup-plan")
    assert one_worker(pytester, *chosen).ret == pytest.ExitCode.NO_TESTS_COLLECTED
    log = (the_report(pytester) / "bus.log").read_text(encoding="utf-8")
    assert not re.search(r" 60\d#FF\S* T$", log, re.MULTILINE)


def test_the_time_that_there_is_is_that_of_each(pytester: pytest.Pytester) -> None:
    chosen = ("--self-test", TWO, "-k", "abort. or upload.identity")
    assert one_worker(pytester, *chosen, "--sdo-budget=100").ret == pytest.ExitCode.OK
    the_report(pytester).rename(pytester.path / "enough")
    result = one_worker(pytester, *chosen, "--sdo-budget=0.000001")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
    found = verdicts(the_report(pytester))
    assert {node_id: len(cases) for node_id, cases in found.items()} == {
        node_id: len(cases) for node_id, cases in verdicts(pytester.path / "enough").items()
    }
    assert {verdict for cases in found.values() for _, verdict, _ in cases} == {Verdict.NOT_RUN}


def test_a_device_that_is_lost_leaves_the_others_alone(pytester: pytest.Pytester) -> None:
    halts = ("--self-test", TWO, "--sdo-fault=unknown-specifier-halts")
    chosen = ("--sdo-response-timeout=0.1", "-k", "specifier.unknown and FFh or abort.frame")
    result = one_worker(pytester, *halts, *chosen)
    assert result.ret == ExitCode.DEVICE_LOST
    assert "INTERNALERROR" not in result.stdout.str()
    for node_id in (5, 9):
        result.stdout.fnmatch_lines([f"Node {node_id} answered before, but does not answer any*"])


def test_a_silent_device_leaves_the_others_alone(pytester: pytest.Pytester) -> None:
    with socketcand() as bus, hosted_on(bus, Node(9, Server(reference_device(9)))):
        options = (*bus, "--sdo-response-timeout=0.5", "-k", "upload.identity")
        result = one_worker(pytester, TWO, *options)
    assert result.ret == ExitCode.SILENT_NODE
    result.stdout.fnmatch_lines(["Node 5 does not answer.*"])
    found = verdicts(the_report(pytester))
    assert [verdict for _, verdict, _ in found[5]] == [Verdict.NOT_RUN]
    assert [verdict for _, verdict, _ in found[9]] == [Verdict.PASS]


class Remembering(Node):
    """Says when an object holds another value than before."""

    def __init__(self, node_id: int) -> None:
        self.objects = reference_device(node_id)
        super().__init__(node_id, Server(self.objects))
        self.before = self.values()
        self.written = threading.Event()

    def values(self) -> dict[str, bytes]:
        return {str(mux): entry.value for mux, entry in self.objects.items()}

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        if self.values() != self.before:
            self.written.set()
        return answers


@contextmanager
def stopped(
    pytester: pytest.Pytester, nodes: Sequence[Remembering], *how: str
) -> Iterator[tuple[subprocess.Popen[bytes], list[str]]]:
    """Run cases that write on these nodes, by one worker; yields the run, then what it has said."""
    said: list[str] = []
    with socketcand() as bus, hosted_on(bus, *nodes):
        devices = ",".join(str(node.node_id) for node in nodes)
        named = ("2004=unsigned32", "2010=visible_string", "2001=unsigned8")
        arguments = (
            *(f"--node-id={devices}", "-n", "1", "-v", "--sdo-response-timeout=60", *bus),
            *("-k", "download.stored or segmented-download.size", *how),
            *(f"--sdo-object={each}" for each in named),
            f"--sdo-report-dir={reports(pytester)}",
        )
        process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-m", "pytest", *QUICK, *arguments, *other_files(arguments)],
            cwd=pytester.path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        yield process, said
        output, _ = process.communicate(timeout=HANGS)
    said += output.decode().splitlines()
    assert [node.values() for node in nodes] == [node.before for node in nodes]
    assert process.returncode == pytest.ExitCode.INTERRUPTED, output.decode()
    assert not list(the_report(pytester).glob("not-restored*")), "all is back"


def told(said: Sequence[str]) -> set[tuple[int, str]]:
    """Return the node-IDs and cases that a run has said to have passed."""
    found = (re.search(r"PASSED cases/\S+::(\S+)@(\d+)(\S*)", line) for line in said)
    return {(int(match[2]), match[1] + match[3]) for match in found if match}


def passed(folder: Path) -> set[tuple[int, str]]:
    """Return those that it has recorded; each case stands there once."""
    cases = [(node_id, *case) for node_id, found in verdicts(folder).items() for case in found]
    assert len(cases) == len({(node_id, case_id) for node_id, case_id, *_ in cases})
    return {(node_id, case_id) for node_id, case_id, how, _ in cases if how == Verdict.PASS}


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT], ids=["sigterm", "ctrl-c"])
def test_a_run_that_is_stopped_puts_back_what_each_has_changed(
    pytester: pytest.Pytester, by: signal.Signals
) -> None:
    nodes = [Remembering(node_id) for node_id in NODES]
    with stopped(pytester, nodes) as (process, said):
        assert nodes[0].written.wait(HANGS)
        os.killpg(process.pid, by)
    assert told(said) <= passed(the_report(pytester))
