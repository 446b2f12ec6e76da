"""A case's result as text: what was required, what came, the frames, and lines that repeat them."""

from collections.abc import Sequence

from conformance.bus.link import Captured, Direction
from conformance.run.verdict import CaseResult
from conformance.sdo.describe import Decoder, describe
from conformance.sdo.layout import FRAME_LENGTH

FIRST_LINES = 40
LAST_LINES = 60


def trace_lines(frames: Sequence[Captured], request_id: int, response_id: int) -> list[str]:
    """Return a line a frame: milliseconds since the first, direction, bytes, and words."""
    decoder = Decoder()
    begin = frames[0].timestamp if frames else 0.0
    lines = []
    for captured in frames:
        frame = captured.frame
        plain = frame.dlc == FRAME_LENGTH and not frame.remote and not frame.extended
        words = "not an SDO frame of this channel"
        if plain and frame.can_id == request_id:
            words = describe(decoder.request(frame.data))
        elif plain and frame.can_id == response_id:
            words = describe(decoder.response(frame.data))
        elif frame.can_id in (request_id, response_id):
            words = f"DLC {frame.dlc}, not a data frame of 8 bytes with an 11-bit identifier"
        arrow = ">" if captured.direction is Direction.SENT else "<"
        elapsed = (captured.timestamp - begin) * 1000
        lines.append(f"{elapsed:9.1f} ms {arrow} {frame!s:<20} {words}")
    return lines


def cansend_lines(frames: Sequence[Captured], channel: str) -> list[str]:
    """Return the commands that send what the suite sent."""
    return [
        f"cansend {channel} {captured.frame}"
        for captured in frames
        if captured.direction is Direction.SENT
    ]


def shortened(lines: Sequence[str]) -> list[str]:
    """Leave out the middle of a long list, and say so."""
    if len(lines) <= FIRST_LINES + LAST_LINES:
        return list(lines)
    left_out = len(lines) - FIRST_LINES - LAST_LINES
    note = f"          … {left_out} lines left out; bus.log has them all"
    return [*lines[:FIRST_LINES], note, *lines[-LAST_LINES:]]


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
    lines.append("  frames (> sent, < received):")
    lines += [f"  {line}" for line in shortened(result.trace)]
    lines.append("  to repeat what was sent:")
    lines += [f"    {line}" for line in shortened(result.reproduce)]
    return "\n".join(lines)
