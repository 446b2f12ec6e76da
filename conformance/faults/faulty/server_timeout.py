"""Servers that give up a silent client wrongly.

Without a time-out (``--sdo-server-timeout``) they do as the reference server does.
"""

from functools import partial

from conformance.faults import registry
from conformance.faults.own_clock import OwnClock
from conformance.faults.registry import About, Defect
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import is_abort
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer

fault = partial(registry.fault, about=About.TIME, timed=True)


@fault("server-timeout-from-the-first-frame", Defect.TIMING, "server-timeout.slow-client")
class FromTheFirstFrame(OwnClock):
    """Counts its time-out from the beginning of a transfer."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        before = self.server.transfer
        frames = super().receive(frame)
        if self.server.transfer is None or self.server_timeout is None:
            self.own_due = None
        elif self.server.transfer is not before:
            self.own_due = self.now + self.server_timeout
        return frames


@fault("server-timeout-too-early", Defect.TIMING, "server-timeout.gives-up")
class TooEarly(OwnClock):
    """Gives up after a fifth of the time that it declares."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        frames = super().receive(frame)
        running = self.server.transfer is not None and self.server_timeout is not None
        self.own_due = self.now + (self.server_timeout or 0) / 5 if running else None
        return frames


@fault(
    "server-timeout-not-in-block-download", Defect.TIMING, "server-timeout.gives-up[block-download"
)
class NotInBlockDownload(Server):
    """Waits for the segments of a block download for ever."""

    def expire(self) -> list[bytes]:
        return [] if isinstance(self.transfer, BlockDownload) else super().expire()


@fault(
    "server-timeout-not-at-end-of-block-upload",
    Defect.TIMING,
    "server-timeout.gives-up[block-upload-end]",
)
class NotAtEnd(Server):
    """Waits for the confirmation of a block upload for ever."""

    def expire(self) -> list[bytes]:
        at_end = isinstance(self.transfer, BlockUpload) and self.transfer.ended
        return [] if at_end else super().expire()


@fault("server-timeout-unsaid", Defect.TIMING, "server-timeout.gives-up")
class Unsaid(Server):
    """Gives up a silent client without a word."""

    def expire(self) -> list[bytes]:
        self.transfer = None
        return []


@fault("server-timeout-goes-on", Defect.TIMING, "server-timeout.gives-up")
class GoesOn(Server):
    """Says that it gives up, and takes what the client sends after all."""

    def expire(self) -> list[bytes]:
        transfer = self.transfer
        responses = super().expire()
        self.transfer = transfer
        return responses


class _OtherAbort(Server):
    """Gives up with another abort."""

    def expire(self) -> list[bytes]:
        if self.transfer is None:
            return []
        mux = self.transfer.mux
        self.transfer = None
        return [abort.encode() for abort in self.aborts(mux)]

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        return [Abort(mux, AbortCode.TIMED_OUT)]


@fault("server-timeout-code-wrong", Defect.TIMING, "server-timeout.gives-up")
class CodeWrong(_OtherAbort):
    """Gives up with a general error."""

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        return [Abort(mux, AbortCode.GENERAL_ERROR)]


@fault("server-timeout-multiplexer-missing", Defect.TIMING, "server-timeout.gives-up")
class MultiplexerMissing(_OtherAbort):
    """Gives up without saying what."""

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        return [Abort(Multiplexer(0), AbortCode.TIMED_OUT)]


@fault("server-timeout-said-twice", Defect.TIMING, "server-timeout.once")
class SaidTwice(_OtherAbort):
    """Says twice that it gives up."""

    def aborts(self, mux: Multiplexer) -> list[Abort]:
        return super().aborts(mux) * 2


@fault(
    "server-timeout-stores-what-came",
    Defect.TIMING,
    "server-timeout.gives-up[segmented-download-middle]",
    soft=True,
)
class StoresWhatCame(Server):
    """Writes what came of a segmented download that it gives up."""

    def expire(self) -> list[bytes]:
        transfer = self.transfer
        data = getattr(transfer, "data", b"")
        if transfer is not None and isinstance(data, bytearray) and data:
            self.objects.find(transfer.mux).value = bytes(data)
        return super().expire()


@fault("server-timeout-behind-client-abort", Defect.TIMING, "server-timeout.after-abort")
class BehindClientAbort(OwnClock):
    """Forgets to stop its timer when the client aborts, and gives up what is over."""

    aborted: Multiplexer | None = None

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        running = self.server.transfer
        frames = super().receive(frame)
        if running is not None and is_abort(frame.data) and self.server_timeout is not None:
            self.aborted, self.own_due = running.mux, self.now + self.server_timeout
        return frames

    def when_due(self) -> list[bytes]:
        return [Abort(self.aborted, AbortCode.TIMED_OUT).encode()] if self.aborted else []
