"""A case's result as text: the requirement, the response, the frames, and commands for them."""

from collections.abc import Iterator, Sequence
from enum import Enum, auto
from typing import NamedTuple

from conformance.bus.link import Captured, Direction
from conformance.run.recording import LeftOut
from conformance.run.trace import FIRST_LINES, LAST_LINES, TraceLine, left_out
from conformance.run.verdict import CaseResult
from conformance.sdo.rules import cited

# The kind of bus, by its name in python-can, to which can-utils can send.
CANSEND_KNOWS = "socketcan"
DECISIVE = "*"
# Where the words of a frame begin in the text of a failure.
WORDS_AT = 38


def cansend_lines(
    frames: Sequence[Captured], channel: str, *, gap: LeftOut | None = None
) -> list[str]:
    """Return the commands that send the suite's frames; the middle of many is left out."""
    sent = [captured.frame for captured in frames if captured.direction is Direction.SENT]
    lines = [f"cansend {channel} {frame}" for frame in sent]
    total = len(lines) + (gap.sent if gap else 0)
    if total <= FIRST_LINES + LAST_LINES:
        return lines
    return [*lines[:FIRST_LINES], f"# {left_out(total)}", *lines[-LAST_LINES:]]


def _broken_rule(result: CaseResult) -> str:
    """Return the rule that was broken; its sentence stands once, if it is that of the case."""
    same = result.broken_sentence == result.requirement
    return result.broken_rule if same else result.broken


def trace_texts(result: CaseResult) -> list[str]:
    """Return the trace as text: milliseconds since the first frame, direction, bytes, and words."""
    return [
        line_text(line, decisive=position == result.decisive)
        for position, line in enumerate(result.trace)
    ]


def line_text(line: TraceLine, *, decisive: bool = False) -> str:
    """Return a line of a trace as text."""
    if not line.frame:
        return line.words
    mark, arrow = DECISIVE if decisive else " ", ">" if line.sent else "<"
    return f"{mark}{line.elapsed * 1000:8.1f} ms {arrow} {line.frame:<20} {line.words}"


class Part(Enum):
    """What a line of the text of a failure is, as far as it is shown in another way."""

    TITLE = auto()
    EXPECTED = auto()
    ACTUAL = auto()
    DECISIVE = auto()
    FRAME = auto()
    OTHER = auto()


class EvidenceLine(NamedTuple):
    """A line of the text of a failure; what came from elsewhere may have several."""

    text: str
    part: Part = Part.OTHER


def evidence_text(result: CaseResult) -> str:
    """Return everything that a failure has to show."""
    return "\n".join(line.text for line in evidence_lines(result))


def evidence_lines(result: CaseResult) -> Iterator[EvidenceLine]:
    """Yield everything that a failure has to show, line by line."""
    about = f"{result.level}, {cited(result.clause)}, node {result.node_id}"
    yield EvidenceLine(f"{result.case_id}: {result.verdict.upper()} ({about})", Part.TITLE)
    for name, value, part in (
        ("requirement", result.requirement, Part.OTHER),
        ("broken rule", _broken_rule(result), Part.OTHER),
        ("cause", result.cause and str(result.cause), Part.OTHER),
        ("expected", result.expected, Part.EXPECTED),
        ("actual", result.actual, Part.ACTUAL),
        ("afterwards", result.afterwards, Part.OTHER),
        *(("note", note, Part.OTHER) for note in result.notes),
    ):
        if value:
            yield EvidenceLine(f"  {name}: {value}", part)
    if result.output:
        yield EvidenceLine("  the device's own output, its last lines:")
        yield from (EvidenceLine(f"    {line}") for line in result.output)
    if result.trace:
        marked = "" if result.decisive is None else f", {DECISIVE} decisive"
        yield EvidenceLine(f"  frames (> sent, < received{marked}):")
        for position, text in enumerate(trace_texts(result)):
            part = Part.DECISIVE if position == result.decisive else Part.FRAME
            yield EvidenceLine(f"  {text}", part)
    if result.reproduce:
        yield EvidenceLine("  to repeat what was sent:")
        yield from (EvidenceLine(f"    {line}") for line in result.reproduce)
