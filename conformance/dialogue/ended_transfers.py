"""Whether the server has aborted the transfer, before it gets a request of that transfer.

To an idle server that would be another request. These functions look at what has arrived, and wait
for nothing.
"""

from conformance.dialogue.server_aborts import is_early
from conformance.dialogue.wire import Wire
from conformance.sdo.decoding import is_abort
from conformance.sdo.frames import BlockAck
from conformance.sdo.rules import NOT_REFUSED, Violation
from conformance.sdo.seen import Received

SEGMENTS_PER_LOOK = 4
_ACKNOWLEDGES = BlockAck(0, 0).encode()[:1]


def look_for_abort(wire: Wire, data: bytes) -> None:
    """Raise Violation where the server has ended the transfer before the next request, ``data``."""
    # An abort of the client is behind all segments: no look of ``has_left`` comes any more.
    if leaves_unasked(wire, within_burst=not is_abort(data)):
        seen = Received(wire.receive())
        raise Violation(
            NOT_REFUSED, expected="the transfer to go on", actual=seen, asked=wire.last_sent
        )


def leaves_unasked(wire: Wire, *, within_burst: bool = False) -> bool:
    """Say whether the server has ended the transfer though it owes no answer.

    ``within_burst`` leaves segments of a block to ``has_left``.
    """
    if not wire.looks_for_aborts:
        return False
    running = wire.line.open
    owed = wire.line.owed and (within_burst or not wire.line.unacknowledged)
    if running is None or owed or wire.fencing:
        return False
    waiting = wire.channel.waiting()
    return bool(waiting) and is_early(wire.line.peek(waiting[0].data), running)


def has_left(wire: Wire) -> bool:
    """Say whether the server has said something else than that it takes segments.

    What follows an abort within a sub-block would be requests to an idle server. This looks only
    now and then: before an answer to a segment could be here, some more are on their way.
    """
    if wire.line.unacknowledged % SEGMENTS_PER_LOOK:
        return False
    return any(frame.data[:1] != _ACKNOWLEDGES for frame in wire.channel.waiting())
