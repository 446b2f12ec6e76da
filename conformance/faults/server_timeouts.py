"""Servers that give up a silent client, wrongly and in unusual ways.

Without a time-out (``--server-timeout``) they do as the reference server does.
"""

from conformance.faults.registry import DefectClass, fault, variant
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, BlockSegment, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.node import Node
from conformance.sdo.segmented_server import SegmentedServer
from conformance.sdo.server import BlockDownload, BlockUpload, Server

TIMING = DefectClass.TIMING
GIVES_UP = "server-timeout.gives-up"


class OwnClock(Node):
    """Gives up, or does something else, at a time of its own choice."""

    own_due: float | None = None

    @property
    def wake_at(self) -> float | None:
        """Also look at the own time."""
        due = [time for time in (super().wake_at, self.own_due) if time is not None]
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Do it when its time has come."""
        frames = super().advance(now)
        if self.own_due is not None and now >= self.own_due:
            self.own_due = None
            frames += [self.respond(data) for data in self.when_due()]
        return frames

    def when_due(self) -> list[bytes]:
        """Give up."""
        return self.server.expire()


@fault("server-timeout-from-the-first-frame", TIMING, "server-timeout.slow-client")
class FromTheFirstFrame(OwnClock):
    """Counts its time-out from the beginning of a transfer."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Start the clock with a transfer, and not again."""
        before = self.server.transfer
        frames = super().receive(frame)
        if self.server.transfer is None or self.server_timeout is None:
            self.own_due = None
        elif self.server.transfer is not before:
            self.own_due = self.now + self.server_timeout
        return frames


@fault("server-timeout-too-early", TIMING, GIVES_UP)
class TooEarly(OwnClock):
    """Gives up after a fifth of the time that it declares."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Be impatient."""
        frames = super().receive(frame)
        running = self.server.transfer is not None and self.server_timeout is not None
        self.own_due = self.now + (self.server_timeout or 0) / 5 if running else None
        return frames


@fault("server-timeout-not-in-block-download", TIMING, f"{GIVES_UP}[block-download")
class NotInBlockDownload(Server):
    """Waits for the segments of a block download for ever."""

    def expire(self) -> list[bytes]:
        """Wait."""
        return [] if isinstance(self.transfer, BlockDownload) else super().expire()


@fault("server-timeout-not-at-end-of-block-upload", TIMING, f"{GIVES_UP}[block-upload-end-sent]")
class NotAtEnd(Server):
    """Waits for the confirmation of a block upload for ever."""

    def expire(self) -> list[bytes]:
        """Wait."""
        at_end = isinstance(self.transfer, BlockUpload) and self.transfer.ended
        return [] if at_end else super().expire()


@fault("server-timeout-unsaid", TIMING, GIVES_UP)
class Unsaid(Server):
    """Gives up a silent client without a word."""

    def expire(self) -> list[bytes]:
        """Be idle."""
        self.transfer = None
        return []


@fault("server-timeout-goes-on", TIMING, GIVES_UP)
class GoesOn(Server):
    """Says that it gives up, and takes what the client sends after all."""

    def expire(self) -> list[bytes]:
        """Keep the transfer."""
        transfer = self.transfer
        responses = super().expire()
        self.transfer = transfer
        return responses


class _OtherAbort(Server):
    """Gives up with another abort."""

    def expire(self) -> list[bytes]:
        """Abort otherwise."""
        if self.transfer is None:
            return []
        mux = self.transfer.mux
        self.transfer = None
        return [abort.encode() for abort in self.aborts(mux)]

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        """Return what is sent."""
        return [Abort(mux, AbortCode.TIMED_OUT)]


@fault("server-timeout-code-wrong", TIMING, GIVES_UP)
class CodeWrong(_OtherAbort):
    """Gives up with a general error."""

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        """Choose the wrong code."""
        return [Abort(mux, AbortCode.GENERAL_ERROR)]


@fault("server-timeout-multiplexer-missing", TIMING, GIVES_UP)
class MultiplexerMissing(_OtherAbort):
    """Gives up without saying what."""

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        """Forget the object."""
        return [Abort(Multiplexer(0), AbortCode.TIMED_OUT)]


@fault("server-timeout-said-twice", TIMING, "server-timeout.once")
class SaidTwice(_OtherAbort):
    """Says twice that it gives up."""

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        """Repeat it."""
        return super().aborts(mux) * 2


@fault(
    "server-timeout-stores-what-came",
    TIMING,
    f"{GIVES_UP}[segmented-download-in-the-middle]",
    soft=True,
)
class StoresWhatCame(Server):
    """Writes what came of a segmented download that it gives up."""

    def expire(self) -> list[bytes]:
        """Save what there is."""
        transfer = self.transfer
        data = getattr(transfer, "data", b"")
        if transfer is not None and isinstance(data, bytearray) and data:
            self.objects.find(transfer.mux).value = bytes(data)
        return super().expire()


@fault("block-download-lost-first-forgotten", TIMING, "block-download.lost[first]")
class LostFirstForgotten(Server):
    """Waits for ever for the first segment of a sub-block, and never says so."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Have nothing to acknowledge."""
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.due == 1 != request.sequence:
            return []
        return super().on_block_segment(request)

    def expire(self) -> list[bytes]:
        """Wait."""
        waits = isinstance(self.transfer, BlockDownload) and self.transfer.due == 1
        return [] if waits else super().expire()


class _Acknowledging(OwnClock):
    """Acknowledges a sub-block that does not go on, after a part of the time-out."""

    part = 1.0

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Start the clock with each segment."""
        frames = super().receive(frame)
        transfer = self.server.transfer
        waits = isinstance(transfer, BlockDownload) and transfer.due > 1 and not transfer.ended
        timeout = self.server_timeout
        self.own_due = None if timeout is None or not waits else self.now + timeout * self.part
        return frames

    def when_due(self) -> list[bytes]:
        """Say what came."""
        server, transfer = self.server, self.server.transfer
        if isinstance(server, Server) and isinstance(transfer, BlockDownload):
            return [server.acknowledge(transfer).encode()]
        return []


@variant("sub-block-acknowledged-after-silence")
class AcknowledgesAfterSilence(_Acknowledging):
    """Acknowledges what came of a sub-block soon after the client fell silent."""

    part = 0.05


@variant("sub-block-acknowledged-before-giving-up")
class AcknowledgesBeforeGivingUp(_Acknowledging):
    """Acknowledges what came of a sub-block shortly before it gives the client up."""

    part = 0.8


@variant("server-timeout-takes-half-as-long-again")
class HalfAsLongAgain(OwnClock):
    """Gives up somewhat later than declared: its timer is coarse."""

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        """Take a longer time."""
        longer = None if server_timeout is None else server_timeout * 1.5
        super().__init__(node_id, *servers, server_timeout=longer)
