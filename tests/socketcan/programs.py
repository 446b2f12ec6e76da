"""The programs of these tests, each a process of its own: devices, runs of the suite, and ip."""

import os
import queue
import runpy
import subprocess
import sys
import threading
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from conformance.device.known_objects import KnownObject

ROOT = Path(__file__).parents[2]
FLEET = ROOT / "tests" / "fleet"
CHANNEL = "vcan0"
NODE_ID = 5
REFERENCE = ("-m", "conformance", "serve")
# A program without output for this time, in seconds, hangs: how long it may take in all depends
# on the machine.
QUIET = 300
RESPONSE_TIMEOUT = 2
# What pytest itself writes, with the properties of each case.
PYTEST_REPORT = "pytest.xml"
SUITE = ("-m", "pytest", "-p", "no:cacheprovider", "-p", "no:hypothesispytest", "-v")


def start(*arguments: str, errors: IO[str] | int = subprocess.STDOUT) -> subprocess.Popen[str]:
    """Start Python in the project's folder with a pipe for what it prints."""
    return subprocess.Popen(  # noqa: S603 - it is our own
        [sys.executable, *arguments],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
        cwd=ROOT,
    )


def lines(process: subprocess.Popen[str]) -> IO[str]:
    """Return what a process prints."""
    assert process.stdout is not None
    return process.stdout


def read_to_end(process: subprocess.Popen[str]) -> str:
    """Return what a process prints from now on until it ends; one that hangs is a failure."""
    printed: queue.SimpleQueue[str | None] = queue.SimpleQueue()

    def read() -> None:
        for line in lines(process):
            printed.put(line)
        printed.put(None)

    threading.Thread(target=read, daemon=True).start()
    text = []
    try:
        while (line := printed.get(timeout=QUIET)) is not None:
            text.append(line)
        process.wait(QUIET)
    except (queue.Empty, subprocess.TimeoutExpired):
        process.kill()
        raise AssertionError(f"nothing came for {QUIET} s behind:\n{''.join(text)}") from None
    return "".join(text)


@contextmanager
def serving(*program: str, errors: Path, node_id: int = NODE_ID) -> Iterator[subprocess.Popen[str]]:
    """Run a device until the end of the block; when that begins, it serves.

    ``errors`` is the file for its standard error.
    """
    bus = ("--can-interface=socketcan", f"--can-channel={CHANNEL}")
    with (
        errors.open("w") as written,
        start(*program, f"--node-id={node_id}", *bus, errors=written) as process,
    ):
        try:
            first = lines(process).readline()
            assert first == f"serving node {node_id} on socketcan {CHANNEL}\n", errors.read_text()
            yield process
        finally:
            process.terminate()
            process.wait(QUIET)


@dataclass(frozen=True, slots=True)
class Run:
    """A run of the suite that has ended, and the folder in which it leaves its reports."""

    status: int
    output: str
    folder: Path

    def report(self, name: str) -> Path:
        """Return one of the reports."""
        (found,) = self.folder.glob(f"*/{name}")
        return found

    def cases(self) -> dict[str, bool]:
        """Return the ids of the cases in junit.xml, and whether each of them failed."""
        cases = ElementTree.parse(self.report("junit.xml")).iter("testcase")  # noqa: S314
        return {case.attrib["name"]: case.find("failure") is not None for case in cases}

    def failed(self) -> list[str]:
        """Return the ids of the cases that failed."""
        return [case for case, failed in self.cases().items() if failed]

    def told(self) -> set[str]:
        """Return the ids of the cases that failed, or that a cause kept from their point."""
        described = ElementTree.parse(self.folder / PYTEST_REPORT).iter("properties")  # noqa: S314
        cases = [{each.attrib["name"]: each.attrib["value"] for each in case} for case in described]
        return {case["id"] for case in cases if "cause" in case}


def start_suite(
    folder: Path, *options: str, node_id: int = NODE_ID, channel: str = CHANNEL
) -> subprocess.Popen[str]:
    """Start a run of the suite."""
    return start(
        *SUITE,
        f"--node-id={node_id}",
        "--can-interface=socketcan",
        f"--can-channel={channel}",
        f"--sdo-response-timeout={RESPONSE_TIMEOUT}",
        f"--sdo-report-dir={folder}",
        "--sdo-no-page",
        f"--junitxml={folder / PYTEST_REPORT}",
        *options,
    )


def suite(folder: Path, *options: str, node_id: int = NODE_ID, channel: str = CHANNEL) -> Run:
    """Run the suite."""
    with start_suite(folder, *options, node_id=node_id, channel=channel) as process:
        output = read_to_end(process)
        return Run(process.returncode, output, folder)


def named(objects: Iterable[KnownObject]) -> tuple[str, ...]:
    """Write objects as --sdo-object takes them."""
    return tuple(
        f"--sdo-object={known.mux.index:04X}:{known.mux.sub_index:02X}="
        f"{known.data_type.name.lower()},{known.access}"
        for known in objects
        if known.data_type is not None
    )


def findings(server: str) -> list[set[str]]:
    """Return what is wrong with a foreign server, from the table of the fleet: cases of each."""
    table = runpy.run_path(str(FLEET / "findings.py"))
    return [set(finding.cases) for finding in table[server]]


def set_interface(state: str) -> None:
    """Set vcan0 up or down."""
    privilege = [] if os.geteuid() == 0 else ["sudo", "--non-interactive"]
    subprocess.run(  # noqa: S603 - nothing but "up" and "down" comes from outside
        [*privilege, "ip", "link", "set", "dev", CHANNEL, state], check=True, timeout=QUIET
    )
