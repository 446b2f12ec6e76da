"""A case's result as text: what was required, what came, the frames, and lines that repeat them."""

from collections.abc import Iterator, Sequence
from enum import Enum, auto
from typing import NamedTuple

from conformance.bus.link import Captured, Direction
from conformance.run.recording import ChannelDecoder, Gap
from conformance.run.verdict import CaseResult
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.describe import hex_bytes
from conformance.sdo.nmt import describe_nmt
from conformance.sdo.rules import cited

# The kind of bus, by its name in python-can, to which can-utils can send.
CANSEND_KNOWS = "socketcan"
FIRST_LINES = 40
LAST_LINES = 60
# What the suite sends behind a request that stays unanswered: an abort, reads, a last abort.
MOST_UNANSWERED = 4
DECISIVE = "*"
# Where the words of a frame begin in the text of a failure.
WORDS_AT = 38
ASIDE = "          -- the case ends here; is the server idle, are the values as before? --"


def trace_lines(
    frames: Sequence[Captured],
    channels: Sequence[ChannelIds],
    *,
    own: int | None = None,
    gap: Gap | None = None,
    aside: bool = True,
    decisive: bool = False,
    actual: str = "",
) -> list[str]:
    """Return a line a frame: milliseconds since the first, direction, bytes, and words.

    ``channels`` are those whose frames are SDO; ``own`` is the number of frames after which the
    case was over and the suite looked after the device, which is shown if ``aside``. The last
    response that ``actual`` shows is marked; else, if any frame is ``decisive``, the first request
    without an answer, or the last frame.
    The middle of a long trace is left out; ``gap`` says what was not even kept of it.
    """
    decoders = {ids: ChannelDecoder(ids) for ids in channels}
    begin = frames[0].timestamp if frames else 0.0
    total = len(frames) + (gap.frames if gap else 0)
    aside_at = total if own is None else own
    marked = _shown(frames, aside_at, gap, actual)
    if marked is None and decisive:
        marked = _unanswered(frames, aside_at, gap)
    if not aside:
        frames = frames[: len(frames) - (total - aside_at)]
        total = aside_at
    lines = []
    for position, captured in enumerate(frames):
        number = position
        if gap is not None and position >= gap.at:
            number += gap.frames
            if position == gap.at:
                decoders |= gap.decoders
        frame = captured.frame
        words = next(filter(None, (decoder.words(frame) for decoder in decoders.values())), "")
        if number >= aside_at:
            lines.append(ASIDE)
            aside_at = total
        if FIRST_LINES <= number < total - LAST_LINES:
            if position == FIRST_LINES:
                lines.append(_left_out(total))
            continue
        words = words or describe_nmt(frame) or "not an SDO frame of this channel"
        arrow = ">" if captured.direction is Direction.SENT else "<"
        elapsed = (captured.timestamp - begin) * 1000
        mark = DECISIVE if number == marked else " "
        lines.append(f"{mark}{elapsed:8.1f} ms {arrow} {frame!s:<20} {words}")
    return lines


def _shown(frames: Sequence[Captured], end: int, gap: Gap | None, actual: str) -> int | None:
    """Return the number of the last response before ``end`` that stands in ``actual``."""
    for position in reversed(range(len(frames))):
        number = position
        if gap is not None and position >= gap.at:
            number += gap.frames
        captured = frames[position]
        received = number < end and captured.direction is Direction.RECEIVED
        if received and f"[{hex_bytes(captured.frame.data)}]" in actual:
            return number
    return None


def _unanswered(frames: Sequence[Captured], end: int, gap: Gap | None) -> int:
    """Return the number of the first request before ``end`` that has no answer.

    In a burst, a server has to answer the last frame alone.
    """
    first = end
    for position in reversed(range(len(frames))):
        number = position + (gap.frames if gap is not None and position >= gap.at else 0)
        if number >= end:
            continue
        if frames[position].direction is Direction.RECEIVED:
            break
        first = number
    return first if first < end <= first + MOST_UNANSWERED else end - 1


def cansend_lines(frames: Sequence[Captured], channel: str, *, gap: Gap | None = None) -> list[str]:
    """Return the commands that send what the suite sent; the middle of many is left out."""
    sent = [captured.frame for captured in frames if captured.direction is Direction.SENT]
    lines = [f"cansend {channel} {frame}" for frame in sent]
    total = len(lines) + (gap.sent if gap else 0)
    if total <= FIRST_LINES + LAST_LINES:
        return lines
    return [*lines[:FIRST_LINES], f"# {_left_out(total)}", *lines[-LAST_LINES:]]


def _broken_rule(result: CaseResult) -> str:
    """Return the rule that was broken; its sentence stands once, if it is that of the case."""
    same = result.broken_sentence == result.requirement
    return result.broken_rule if same else result.broken


def _left_out(number: int) -> str:
    return f"… {number - FIRST_LINES - LAST_LINES} frames left out; bus.log has them all"


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
    decisive = any(line.startswith(DECISIVE) for line in result.trace)
    if result.trace:
        yield EvidenceLine(f"  frames (> sent, < received{', * decisive' if decisive else ''}):")
        for line in result.trace:
            yield EvidenceLine(
                f"  {line}", Part.DECISIVE if line.startswith(DECISIVE) else Part.FRAME
            )
    if result.reproduce:
        yield EvidenceLine("  to repeat what was sent:")
        yield from (EvidenceLine(f"    {line}") for line in result.reproduce)
