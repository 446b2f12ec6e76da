"""A case's result as text: what was required, what came, the frames, and lines that repeat them."""

from collections.abc import Sequence

from conformance.bus.link import Captured, Direction
from conformance.run.verdict import CaseResult
from conformance.sdo.describe import Decoder, describe
from conformance.sdo.frames import Request, Response
from conformance.sdo.layout import FRAME_LENGTH

FIRST_LINES = 40
LAST_LINES = 60
ASIDE = "          -- the case ends here; is the server idle, are the values as before? --"


def trace_lines(
    frames: Sequence[Captured], request_id: int, response_id: int, *, own: int | None = None
) -> list[str]:
    """Return a line a frame: milliseconds since the first, direction, bytes, and words.

    ``own`` is the number of frames after which the case was over and the suite looked after the
    device. The middle of a long trace is left out.
    """
    decoder = Decoder()
    begin = frames[0].timestamp if frames else 0.0
    lines = []
    for number, captured in enumerate(frames):
        frame = captured.frame
        plain = frame.dlc == FRAME_LENGTH and not frame.remote and not frame.extended
        message: Request | Response | None = None
        if plain and frame.can_id == request_id:
            message = decoder.request(frame.data)
        elif plain and frame.can_id == response_id:
            message = decoder.response(frame.data)
        if number == own:
            lines.append(ASIDE)
        if FIRST_LINES <= number < len(frames) - LAST_LINES:
            if number == FIRST_LINES:
                lines.append(_left_out(len(frames)))
            continue
        words = "not an SDO frame of this channel"
        if message is not None:
            words = describe(message)
        elif frame.can_id in (request_id, response_id):
            words = f"DLC {frame.dlc}, not a data frame of 8 bytes with an 11-bit identifier"
        arrow = ">" if captured.direction is Direction.SENT else "<"
        elapsed = (captured.timestamp - begin) * 1000
        lines.append(f"{elapsed:9.1f} ms {arrow} {frame!s:<20} {words}")
    return lines


def cansend_lines(frames: Sequence[Captured], channel: str) -> list[str]:
    """Return the commands that send what the suite sent; the middle of many is left out."""
    sent = [captured.frame for captured in frames if captured.direction is Direction.SENT]
    lines = [f"cansend {channel} {frame}" for frame in sent]
    if len(lines) <= FIRST_LINES + LAST_LINES:
        return lines
    return [*lines[:FIRST_LINES], f"# {_left_out(len(lines))}", *lines[-LAST_LINES:]]


def _left_out(number: int) -> str:
    return f"… {number - FIRST_LINES - LAST_LINES} frames left out; bus.log has them all"


def evidence_text(result: CaseResult) -> str:
    """Return everything that a failure has to show."""
    lines = [
        f"{result.case_id}: {result.verdict.upper()} "
        f"({result.level}, CiA 301 clause {result.clause}, node {result.node_id})",
        f"  requirement: {result.requirement}",
    ]
    for name, value in (
        ("broken rule", result.broken_rule),
        ("expected", result.expected),
        ("actual", result.actual),
        ("afterwards", result.afterwards),
    ):
        if value:
            lines.append(f"  {name}: {value}")
    lines += [f"  note: {note}" for note in result.notes]
    if result.output:
        lines.append("  the device's own output, its last lines:")
        lines += [f"    {line}" for line in result.output]
    lines.append("  frames (> sent, < received):")
    lines += [f"  {line}" for line in result.trace]
    lines.append("  to repeat what was sent:")
    lines += [f"    {line}" for line in result.reproduce]
    return "\n".join(lines)
