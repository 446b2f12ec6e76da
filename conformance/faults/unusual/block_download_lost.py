"""Servers that are right in their own way where segments of a block download are lost or late."""

from conformance.faults.own_clock import OwnClock
from conformance.faults.registry import unusual
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import is_abort
from conformance.sdo.frames import BlockAck, BlockDownloadInitiate, BlockSegment, Response
from conformance.sdo.objects import Refusal

# The share of its time-out, here 3 s where none is declared, for which a server waits for a lost
# first segment.
OWN_TIMEOUT = 3.0
PART = 0.7


class _BreaksAtOnce(Server):
    """Acknowledges a break at once, and discards what is still to come of that sub-block.

    A number that is not higher than the last one says that the next sub-block has begun.
    """

    seen = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.seen = 0
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload) or not request.sequence:
            return super().on_block_segment(request)
        if self.seen and request.sequence > self.seen:
            self.seen = request.sequence
            return []
        self.seen = 0
        if self.is_break(transfer.due, request.sequence):
            self.seen = request.sequence
            return [self.acknowledge(transfer)]
        return super().on_block_segment(request)

    def is_break(self, due: int, sequence: int) -> bool:
        """Say whether a number breaks the sequence."""
        return sequence > due


@unusual("gap-acknowledged-at-once")
class GapAtOnce(_BreaksAtOnce):
    """Acknowledges a gap in a sub-block at once."""


@unusual("repeated-segment-breaks")
class RepeatedBreaks(_BreaksAtOnce):
    """Takes a repeated segment for a break, and acknowledges the last good one at once."""

    def is_break(self, due: int, sequence: int) -> bool:
        return sequence != due


class _InSequence(Server):
    """Compares each number with the one that is due, and does nothing else."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        responses = super().on_block_segment(request)
        if isinstance(self.transfer, BlockDownload):
            self.transfer.broken = False
        return responses


@unusual("late-segment-taken")
class LateTaken(_InSequence):
    """Takes the segment that is due when it comes late, behind others that it discards."""


@unusual("late-segment-aborts")
class LateAborts(Server):
    """Aborts when a segment comes behind one with a higher number."""

    highest = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.highest = 0
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        if request.sequence <= self.highest:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        responses = super().on_block_segment(request)
        self.highest = 0 if responses else request.sequence
        return responses

    def acknowledge(self, transfer: BlockDownload) -> BlockAck:
        self.highest = 0
        return super().acknowledge(transfer)


class _WaitsForFirst(Server):
    """Ignores whatever comes before number 1 of a sub-block."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.due == 1 != request.sequence:
            return []
        return super().on_block_segment(request)


@unusual("gap-acknowledged-at-once-then-waits")
class GapAtOnceThenWaits(_WaitsForFirst):
    """Acknowledges a gap at once, and then ignores everything until number 1 comes."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and 1 < transfer.due < request.sequence:
            return [self.acknowledge(transfer)]
        return super().on_block_segment(request)


@unusual("lost-first-segment-never-acknowledged")
class FirstNeverAcknowledged(_WaitsForFirst):
    """Keeps silent as long as number 1 of a sub-block has not come."""


@unusual("gap-acknowledged-by-time-out")
class GapByTimeout(OwnClock):
    """Waits for what is due in a sub-block, and acknowledges a gap after a part of its time-out."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        transfer = self.server.transfer
        waits = isinstance(transfer, BlockDownload) and not transfer.ended
        if waits and self._is_out_of_sequence(frame):
            self._start()
            return []
        frames = super().receive(frame)
        self.own_due = None
        after = self.server.transfer
        if isinstance(after, BlockDownload) and not after.ended and after.due > 1:
            self._start()
        return frames

    def _is_out_of_sequence(self, frame: CanFrame) -> bool:
        transfer = self.server.transfer
        segment = frame.can_id == 0x600 + self.node_id and len(frame.data) == 8
        if not segment or not isinstance(transfer, BlockDownload) or is_abort(frame.data):
            return False
        return 1 <= frame.data[0] & 0x7F <= transfer.block_size and (
            frame.data[0] & 0x7F != transfer.due
        )

    def _start(self) -> None:
        self.own_due = self.now + self.patience()

    def patience(self) -> float:
        """Return how many seconds it waits for what is due."""
        return PART * (self.server_timeout or OWN_TIMEOUT)

    def when_due(self) -> list[bytes]:
        server, transfer = self.server, self.server.transfer
        if isinstance(server, Server) and isinstance(transfer, BlockDownload):
            return [server.acknowledge(transfer).encode()]
        return []


@unusual("gap-acknowledged-after-50-ms")
class GapAfter50ms(GapByTimeout):
    """Acknowledges a gap after a silence of 50 ms."""

    def patience(self) -> float:
        return 0.05


@unusual("gap-ends-transfer-after-1-s")
class GapEnds(GapByTimeout):
    """Waits for a second for what is due in a sub-block, and ends the transfer then."""

    def patience(self) -> float:
        return 1.0

    def when_due(self) -> list[bytes]:
        return self.server.expire()
