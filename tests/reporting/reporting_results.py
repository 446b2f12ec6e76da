"""Results of cases as the reports take them, and readers of what was written."""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, settings

from conformance.reporting.junit.cases import write_junit
from conformance.run.trace import TraceLine
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import Cause

# A busy machine is no failure.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
TIMESTAMP = "2024-05-06T07:08:09"
PASSED = CaseResult(
    case_id="upload.device-type",
    service="expedited-upload",
    node_id=5,
    level="MUST",
    clause="7.5.2.1",
    requirement="The device type (1000h), which every device has, reads as 4 bytes.",
    trace=[TraceLine("upload initiate 1000h:00", "605#4000100000000000", sent=True)],
    reproduce=["cansend can0 605#4000100000000000"],
    duration=0.25,
)

# The lines of a record beside those of its cases.
ABOUT: dict[str, Any] = {
    "all_rw": False,
    "begun": "2026-05-06T09:08:09.000+02:00",
    "begun_utc": "2026-05-06T07:08:09",
    "channel": "can0",
    "command": ["pytest", "--node-id=5,9"],
    "eds": {"name": "drive.eds", "sha256": "00" * 32, "revision": "1.4"},
    "host": "bench-3",
    "interface": "socketcan",
    "node_ids": [5, 9],
    "packages": {"pytest": "9.2.0"},
    "permissions": ["nmt"],
    "platform": "Linux",
    "properties": {
        "suite-version": "1",
        "bus": "socketcan can0",
        "bit-rate": "125000",
        "response-timeout-ms": "1000",
    },
    "python": "3.11.7",
    "self_test": False,
    "strict": False,
    "suite": "1",
    "writable": ["2001h:00"],
}
DEVICE: dict[str, Any] = {
    "node_id": 5,
    "sdo_channel": "605:585",
    "identity": {"vendor-id": "0x0000012E"},
    "texts": {"1008h:00": "Drive"},
    "properties": {"vendor-id": "0x0000012E"},
}
END: dict[str, Any] = {
    "how": "complete",
    "exit_status": 1,
    "properties": {"not-restored": "x"},
    "bench_errors": [],
    "unrestored": [],
}


def cause_of(text: str) -> Cause | None:
    """Return a cause that is written as reports show it."""
    rule, _, answer = text.partition(": ")
    return Cause(rule, answer) if rule else None


def result(verdict: Verdict = Verdict.PASS, *, cause: str = "", **changes: Any) -> CaseResult:
    """Return a result that differs from ``PASSED``; what its id says, its fields say as well."""
    name, _, label = changes.get("case_id", PASSED.case_id).partition("[")
    if name.startswith("matrix."):
        changes |= {"state": name.removeprefix("matrix."), "stimulus": label.removesuffix("]")}
    return replace(PASSED, verdict=verdict, cause=cause_of(cause), name=name, **changes)


def written(
    path: Path,
    results: Sequence[CaseResult],
    properties: Mapping[str, str] | None = None,
    *,
    strict: bool = False,
) -> ElementTree.Element:
    """Write junit.xml and parse it back."""
    write_junit(path, results, properties or {}, timestamp=TIMESTAMP, strict=strict)
    return ElementTree.parse(path).getroot()  # noqa: S314 - it is our own file


def found(element: ElementTree.Element, path: str) -> ElementTree.Element:
    match = element.find(path)
    assert match is not None, f"{path} is missing"
    return match


_ESCAPES = re.compile(r"\\x([0-9a-f]{2})|\\u([0-9a-f]{4})|\\U([0-9a-f]{8})|\\(r)")


def original(text: str) -> str:
    r"""Turn ``\xNN`` and ``\uNNNN`` back into the characters for which they stand."""

    def character(match: re.Match[str]) -> str:
        return "\r" if match[4] else chr(int(match[1] or match[2] or match[3], 16))

    return _ESCAPES.sub(character, text)
