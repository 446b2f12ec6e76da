"""The trace of a case: its frames as values, each with its words for people."""

from collections.abc import Collection, Sequence
from typing import NamedTuple

from conformance.bus.link import Captured, Direction
from conformance.run.recording import ChannelDecoder, LeftOut
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.nmt import describe_nmt

FIRST_LINES = 40
LAST_LINES = 60
# What the suite sends behind a request that stays unanswered: an abort, reads, a last abort.
MOST_UNANSWERED = 4
ASIDE = "          -- the case ends here; is the server idle, are the values as before? --"


class TraceLine(NamedTuple):
    """A frame of a case; or, without one, a remark between the frames, which has words only.

    ``time`` is that of the frame in bus.log, in seconds since 1970, ``elapsed`` the time since the
    first frame. ``kind`` is the name of the SDO message, empty for any other frame. ``own``: the
    case was not over yet.
    """

    words: str
    frame: str = ""
    sent: bool = False
    time: float = 0.0
    elapsed: float = 0.0
    kind: str = ""
    own: bool = True


class Trace(NamedTuple):
    """The lines of a trace, and the index of the decisive one."""

    lines: list[TraceLine]
    decisive: int | None = None


def trace_of(
    frames: Sequence[Captured],
    channels: Sequence[ChannelIds],
    *,
    own: int | None = None,
    gap: LeftOut | None = None,
    aside: bool = True,
    decisive: bool = False,
    shown: Collection[bytes] = (),
) -> Trace:
    """Return a line for each frame.

    ``channels`` are those whose frames are SDO; ``own`` is the number of frames after which the
    case was over and the suite looked after the device, which is shown if ``aside``. The last
    response with the bytes of one ``shown`` is decisive; else, if any frame is ``decisive``, the
    first request without an answer, or the last frame.
    The middle of a long trace is left out; ``gap`` says what was not even kept of it.
    """
    decoders = {ids: ChannelDecoder(ids) for ids in channels}
    begin = frames[0].timestamp if frames else 0.0
    total = len(frames) + (gap.frames if gap else 0)
    end = aside_at = total if own is None else own
    marked = _shown(frames, end, gap, shown)
    if marked is None and decisive:
        marked = _unanswered(frames, end, gap)
    if not aside:
        frames = frames[: len(frames) - (total - end)]
        total = end
    trace = Trace([])
    for position, captured in enumerate(frames):
        number = position
        if gap is not None and position >= gap.at:
            number += gap.frames
            if position == gap.at:
                decoders |= gap.decoders
        frame = captured.frame
        read = next(filter(None, (decoder.read(frame) for decoder in decoders.values())), None)
        if number >= aside_at:
            trace.lines.append(TraceLine(ASIDE))
            aside_at = total
        if FIRST_LINES <= number < total - LAST_LINES:
            if position == FIRST_LINES:
                trace.lines.append(TraceLine(left_out(total)))
            continue
        if number == marked:
            trace = trace._replace(decisive=len(trace.lines))
        kind, words = read or ("", describe_nmt(frame) or "not an SDO frame of this channel")
        time = captured.timestamp
        trace.lines.append(
            TraceLine(
                words,
                str(frame),
                captured.direction is Direction.SENT,
                round(time, 6),
                round(time - begin, 6),
                kind,
                number < end,
            )
        )
    return trace


def left_out(number: int) -> str:
    """Say how many frames, or commands, are left out of a number of them."""
    return f"… {number - FIRST_LINES - LAST_LINES} frames left out; bus.log has them all"


def _shown(
    frames: Sequence[Captured], end: int, gap: LeftOut | None, shown: Collection[bytes]
) -> int | None:
    """Return the number of the last response before ``end`` that is ``shown``."""
    for position in reversed(range(len(frames))):
        number = position
        if gap is not None and position >= gap.at:
            number += gap.frames
        captured = frames[position]
        received = number < end and captured.direction is Direction.RECEIVED
        if received and captured.frame.data in shown:
            return number
    return None


def _unanswered(frames: Sequence[Captured], end: int, gap: LeftOut | None) -> int:
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
