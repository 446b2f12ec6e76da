"""``conformance eds``: descriptions of devices, checked; and a device held against its own."""

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from conformance.bus.opening import BusSettings
from conformance.commands.options import NODE_ID, add_bus_options, add_option, bus_settings
from conformance.commands.status import DONE, FAULTY, NOT_ALLOWED
from conformance.device.files import FileError
from conformance.eds import rules
from conformance.eds.findings import Finding, Place, Severity
from conformance.eds.reading import DeviceFile, commissioned_node_id, read_file
from conformance.reporting.junit.descriptions import FAILING, FAILING_IF_STRICT, whole_suite
from conformance.reporting.junit.tree import write_suites
from conformance.sdo.printable_text import inert

HELP = "check EDS, DCF, XDD or XDC files; exit status 1 for errors, 3 for warnings with --strict"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="an EDS, DCF, XDD or XDC file"
    )
    add_option(
        parser,
        NODE_ID,
        help="hold this device against the file, too: the cases on its object dictionary (od.…)",
    )
    parser.add_argument(
        "--strict", action="store_true", help="exit status 3 where there are warnings alone"
    )
    parser.add_argument(
        "--junitxml", type=Path, metavar="FILE", help="write the findings as a JUnit file as well"
    )
    parser.add_argument(
        "--json", action="store_true", help="print a JSON object a line, one for each finding"
    )
    add_bus_options(parser)


def run(options: argparse.Namespace) -> int:
    """Print the findings."""
    if options.node_id is not None and len(options.files) > 1:
        raise ValueError("--node-id goes with one file: that of this device")
    files = [_read(path, options.node_id) for path in options.files]
    for file in files:
        if options.json:
            for finding in file.findings:
                print(json.dumps(finding.record))
            continue
        for line in _lines(file):
            print(line)
    if options.junitxml:
        failing = FAILING_IF_STRICT if options.strict else FAILING
        suites = [whole_suite(file.path.name, file.records, failing) for file in files]
        write_suites(options.junitxml, suites, {}, timestamp=f"{datetime.now(UTC):%FT%T}")
    status = _status([finding.severity for file in files for finding in file.findings], options)
    if options.node_id is None:
        return status
    return _hold_against(options.files[0], options) or status


def _read(path: Path, node_id: int | None) -> DeviceFile:
    """Return a file for a node; what is no description is one with that finding."""
    try:
        file = read_file(path, node_id or 1)
        if node_id is None and (commissioned := commissioned_node_id(file.sections)):
            file = read_file(path, commissioned)
    except FileError as error:
        finding = Finding(rules.READABLE, path, Place(error.line), error.sentence.rstrip("."))
        return DeviceFile.unreadable(path, finding)
    return file


def _status(severities: Sequence[Severity], options: argparse.Namespace) -> int:
    if Severity.ERROR in severities:
        return FAULTY
    return NOT_ALLOWED if options.strict and Severity.WARNING in severities else DONE


def _lines(file: DeviceFile) -> Iterator[str]:
    for finding in file.findings:
        yield inert(str(finding))
    for rule_id, count in file.left_out:
        yield inert(f"{file.path}: {count} more findings of {rule_id}")
    counts = Counter(finding.severity for finding in file.findings)
    told = ", ".join(
        f"{counts[severity]} {severity}{'s' * (counts[severity] != 1)}" for severity in Severity
    )
    objects = sum(bool(listed.entries) for listed in file.listing.objects.values())
    yield inert(f"{file.path}: {told}; {objects} objects, {len(file.listing.entries)} entries")


def _hold_against(path: Path, options: argparse.Namespace) -> int:
    """Run the cases on the object dictionary against a device; returns pytest's exit status."""
    settings = bus_settings(options, BusSettings())
    given = [f"--can-option={name}={value}" for name, value in options.can_option]
    if options.can_bitrate:
        given.append(f"--can-bitrate={options.can_bitrate}")
    command = [
        *(sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-k", "od."),
        *(f"--sdo-eds={path}", f"--node-id={options.node_id}"),
        *(f"--can-interface={settings.interface}", f"--can-channel={settings.channel}", *given),
    ]
    sys.stdout.flush()
    return subprocess.run(command, check=False).returncode  # noqa: S603 - it is our own
