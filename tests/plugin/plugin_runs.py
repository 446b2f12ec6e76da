"""Runs of the suite within a test, in this process and in a folder of their own, and their reports.

Hypothesis's plugin would cost each of them a second; the cache of one must not reach another.
"""

import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
from socketcand_bus import settings_of
from support.selected_files import other_files
from support.spared_tests import spare_tests

from conformance.bus.opening import BusSettings, open_bus
from conformance.faults.catalogue import build_node
from conformance.reference.host import HostedNode, NodeHost
from conformance.reference.node import Node
from conformance.run.bench import private_channel
from conformance.sdo.can_frame import CanFrame

# pytest-xdist tells its workers how wide its terminal is; lines stay whole where there is none.
os.environ.pop("COLUMNS", None)

NO_HYPOTHESIS = ("-p", "no:hypothesispytest")
QUICK = (*NO_HYPOTHESIS, "-p", "no:cacheprovider")
NODE_ID = 5


def reports(pytester: pytest.Pytester) -> Path:
    """Return the folder into which the runs of a test write."""
    return pytester.path / "left behind"


def run(
    pytester: pytest.Pytester, *arguments: str, plugins: Sequence[object] = ()
) -> pytest.RunResult:
    """Run pytest with these arguments in the empty folder of the test."""
    spare_tests()
    folder = f"--sdo-report-dir={reports(pytester)}"
    given = (*QUICK, folder, *arguments, *other_files(arguments))
    return pytester.runpytest_inprocess(*given, plugins=plugins)


def self_test(
    pytester: pytest.Pytester, *arguments: str, plugins: Sequence[object] = ()
) -> pytest.RunResult:
    """Run cases on the built-in server."""
    return run(pytester, "--self-test", *arguments, plugins=plugins)


class Watched:
    """A node, and the frames that came to it or to others."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.frames: list[CanFrame] = []

    def start(self) -> list[CanFrame]:
        return self.node.start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        self.frames.append(frame)
        return self.node.receive(frame)

    def advance(self, now: float) -> list[CanFrame]:
        return self.node.advance(now)

    @property
    def wake_at(self) -> float | None:
        return self.node.wake_at


@contextmanager
def hosted(*nodes: HostedNode) -> Iterator[tuple[str, ...]]:
    """Host nodes on a virtual bus; yields the options that lead a run there."""
    channel = private_channel()
    with ExitStack() as stack:
        for node in nodes:
            bus = open_bus(BusSettings("virtual", channel))
            stack.enter_context(NodeHost(bus, node))
        yield "--can-interface=virtual", f"--can-channel={channel}"


@contextmanager
def hosted_on(bus: tuple[str, ...], *nodes: HostedNode) -> Iterator[None]:
    """Host nodes on the socketcand bus to which these options lead."""
    with ExitStack() as stack:
        for node in nodes:
            stack.enter_context(NodeHost(open_bus(settings_of(bus)), node))
        yield


@contextmanager
def reference() -> Iterator[tuple[str, ...]]:
    """Host the reference server; yields the options of a run that tests it like any device."""
    with hosted(build_node(None, NODE_ID)) as bus:
        yield f"--node-id={NODE_ID}", *bus


def the_report(pytester: pytest.Pytester) -> Path:
    """Return the report folder of the only run so far."""
    (folder,) = reports(pytester).iterdir()
    return folder


def parsed(path: Path) -> ElementTree.Element:
    """Read an XML file that a run has written."""
    return ElementTree.parse(path).getroot()  # noqa: S314 - it is our own file


def case_ids(path: Path) -> list[str]:
    """Return the ids of the cases in a JUnit file, in order, without the rules on descriptions."""
    return [
        case.attrib["name"]
        for case in parsed(path).iter("testcase")
        if case.attrib["classname"] != "description"
    ]


def printed(result: pytest.RunResult) -> str:
    """Return all that a run printed, with what differs between runs made the same."""
    text = result.stdout.str() + result.stderr.str()
    text = re.sub(r" *\d+\.\d ms ", " T ms ", text)
    text = re.sub(r"conformance-\d+-[0-9a-f]{8}", "CHANNEL", text)
    text = re.sub(r"reports: .*", "reports: FOLDER", text)
    text = re.sub(r"\d{8}-\d{6}-\d{6}-node-\d+", "RUN", text)
    return re.sub(r"in \d+\.\d\ds", "in N s", text)


def between(text: str, first: str, last: str) -> str:
    """Return the lines from the one that begins with ``first`` to that before ``last``."""
    lines = text.splitlines()
    begin = next(number for number, line in enumerate(lines) if line.startswith(first))
    ends = (number for number in range(begin + 1, len(lines)) if lines[number].startswith(last))
    return "\n".join(lines[begin : next(ends)])
