"""What a case found: verdicts, the second axis, and results as the reports take them."""

from dataclasses import dataclass, field
from enum import StrEnum

from conformance.bus.link import Captured
from conformance.sdo.rules import Rule


class Verdict(StrEnum):
    """The outcome of a case."""

    PASS = "pass"  # noqa: S105
    NON_STRICT = "non-strict"
    INFO = "info"
    UNIMPLEMENTED = "unimplemented"
    NOT_TESTABLE = "not testable"
    FAIL = "fail"
    BENCH_ERROR = "bench error"


class Afterwards(StrEnum):
    """How the case left the server."""

    IDLE = "idle"
    NEEDED_ABORT = "needed an abort"
    LOST = "lost"
    UNKNOWN = "not looked at"


class Unimplemented(Exception):
    """An optional service was properly refused; the text holds the refusal."""


@dataclass(slots=True)
class CaseResult:
    """One case on one device: what was required, what happened, and the frames."""

    case_id: str
    service: str
    rule: Rule
    node_id: int
    verdict: Verdict = Verdict.PASS
    expected: str = ""
    actual: str = ""
    broken_rule: str = ""
    notes: list[str] = field(default_factory=list)
    afterwards: Afterwards = Afterwards.UNKNOWN
    frames: list[Captured] = field(default_factory=list)
    duration: float = 0.0
    latency: float = 0.0
    waited: float = 0.0
    text: str = ""
