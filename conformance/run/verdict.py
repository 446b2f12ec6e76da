"""Results of cases: verdicts, the second axis, and results as the reports take them."""

from dataclasses import asdict, dataclass, field, fields
from enum import Enum, StrEnum
from typing import Any, Self

from conformance.device.not_testable import Lack, Missing
from conformance.run.trace import TraceLine
from conformance.sdo.rules import Cause


class Verdict(StrEnum):
    """The outcome of a case."""

    PASS = "pass"  # noqa: S105
    NON_STRICT = "non-strict"
    INFO = "info"
    UNIMPLEMENTED = "unimplemented"
    NOT_TESTABLE = "not testable"
    FAIL = "fail"
    KNOWN_DEVIATION = "known deviation"
    STALE = "stale deviation"
    BENCH_ERROR = "bench error"
    NOT_RUN = "not run"


FAILED = (Verdict.FAIL, Verdict.BENCH_ERROR)
BREACHES = (Verdict.FAIL, Verdict.NON_STRICT)
# They say nothing of the device.
NOT_TESTED = (Verdict.NOT_TESTABLE, Verdict.UNIMPLEMENTED, Verdict.NOT_RUN)


class Afterwards(StrEnum):
    """How a case left the server."""

    IDLE = "idle"
    NEEDED_ABORT = "needed an abort"
    ANSWERS_WRONGLY = "answers, but wrongly"
    LOST = "lost"
    UNKNOWN = "not looked at"


@dataclass(slots=True)
class CaseResult:
    """One case on one device: what was required, what happened, and the frames.

    ``name`` is the id of the case without the value in which it varies; a case of the matrix has
    the ``state`` of the server and the ``stimulus`` that it sends there. ``level`` is that of the
    case, or of the breach that made the verdict. ``rules`` are the ids of the rules that the case
    tests. ``broken_rule`` is an id as well, and ``broken_sentence`` what that rule asks for; both
    are empty for an own test that failed by itself. Times are in seconds: ``duration`` of the case,
    the longest ``latency`` of an answer, what was ``waited`` for answers that did not come, and the
    time ``answering`` of all ``answers`` that did. ``trace`` holds the decoded frames, ``decisive``
    is the index of the frame that made the verdict, and ``reproduce`` has the commands that send
    the requests again, if the bus has any. ``reason`` is why a known deviation may be one,
    ``output`` what a device that was lost has written last; ``progress`` says how many of its
    examples a random case has tried. ``cause`` is what is wrong with the device, the same for all
    cases that it fails, or keeps from their point; ``met`` are causes that the case has stepped
    round. ``missing`` is what the user may add to have a case tested that was not.
    """

    case_id: str
    service: str
    node_id: int
    level: str
    clause: str
    requirement: str
    verdict: Verdict = Verdict.PASS
    broken_rule: str = ""
    broken_sentence: str = ""
    expected: str = ""
    actual: str = ""
    afterwards: Afterwards = Afterwards.UNKNOWN
    rules: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    trace: list[TraceLine] = field(default_factory=list)
    decisive: int | None = None
    reproduce: list[str] = field(default_factory=list)
    duration: float = 0.0
    latency: float = 0.0
    waited: float = 0.0
    answers: int = 0
    answering: float = 0.0
    reason: str = ""
    output: list[str] = field(default_factory=list)
    progress: str = ""
    cause: Cause | None = None
    met: list[Cause] = field(default_factory=list)
    name: str = ""
    state: str = ""
    stimulus: str = ""
    missing: Missing | None = None

    def __post_init__(self) -> None:
        """A case that does not vary has no other name than its id."""
        self.name = self.name or self.case_id

    @property
    def broken(self) -> str:
        """The broken rule in words; empty for none."""
        return f"{self.broken_rule}: {self.broken_sentence}" if self.broken_rule else ""

    @property
    def rule_of_cause(self) -> str:
        """The id of the rule of its cause; empty for none."""
        return self.cause.rule_id if self.cause is not None else ""

    @property
    def broken_rules(self) -> set[str]:
        """The ids of the broken rule and of the rule of its cause, as far as there are any."""
        return {self.broken_rule, self.rule_of_cause} - {""}

    @property
    def tested_rules(self) -> set[str]:
        """The ids of the rules that the case tests, its own among them."""
        return {self.name, *self.rules}

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values that JSON can hold."""
        return {name: plain(getattr(self, name)) for name in _FIELDS}

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """Read the result of ``as_dict``."""
        result = cls(**values)
        result.verdict = Verdict(result.verdict)
        result.afterwards = Afterwards(result.afterwards)
        result.cause = Cause(**values["cause"]) if values.get("cause") else None
        result.met = [Cause(**cause) for cause in values.get("met", ())]
        if missing := values.get("missing"):
            result.missing = Missing(Lack(missing["kind"]), missing["name"])
        result.trace = [TraceLine(**line) for line in values.get("trace", ())]
        return result


_FIELDS = tuple(each.name for each in fields(CaseResult))


def plain(value: Any) -> Any:
    """Return a value as JSON and other processes take it: an object by the names of its fields."""
    match value:
        case Enum():
            return value.value
        case list():
            return [plain(each) for each in value]
        case Cause():
            return {name: plain(each) for name, each in asdict(value).items()}
        case Missing() | TraceLine():
            return {name: plain(each) for name, each in value._asdict().items()}
    return value
