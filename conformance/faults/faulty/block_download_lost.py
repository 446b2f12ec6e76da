"""Servers that are wrong about lost and repeated segments of a block download."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import BlockAck, BlockDownloadInitiate, BlockEnd, BlockSegment, Response
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import ObjectDictionary, Refusal

FIRST_SUB_BLOCK = LARGEST_BLOCK * SEGMENT_LENGTH


class _Gaps(Server):
    """Does something of its own when it acknowledges fewer segments than were sent."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Look for a gap in what is acknowledged."""
        transfer = self.transfer
        responses = super().on_block_segment(request)
        ack = responses[0] if responses else None
        if not isinstance(transfer, BlockDownload) or not isinstance(ack, BlockAck):
            return responses
        if ack.sequence == request.sequence:
            return responses
        return self.on_gap(transfer, ack, request)

    def on_gap(
        self, transfer: BlockDownload, ack: BlockAck, request: BlockSegment
    ) -> list[Response]:
        """Return what is sent instead of the acknowledgement."""
        del transfer, request
        return [ack]


@fault("block-download-gap-not-noticed", Defect.LOST_SEGMENTS, "block-download.lost")
class GapNotNoticed(Server):
    """Stores what follows a gap, and acknowledges it."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        if isinstance(self.transfer, BlockDownload):
            self.transfer.due = max(self.transfer.due, request.sequence)
        return super().on_block_segment(request)


@fault("block-download-later-gap-not-noticed", Defect.LOST_SEGMENTS, "block-download.lost-later")
class LaterGapNotNoticed(GapNotNoticed):
    """Stores what follows a gap, and acknowledges it, behind the first sub-block."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and len(transfer.data) < FIRST_SUB_BLOCK:
            return Server.on_block_segment(self, request)
        return super().on_block_segment(request)


@fault("block-download-first-lost-not-noticed", Defect.LOST_SEGMENTS, "block-download.lost[first]")
class FirstLostNotNoticed(Server):
    """Takes the segment of a sub-block that arrives first for segment 1."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        if isinstance(self.transfer, BlockDownload) and self.transfer.due == 1:
            self.transfer.due = max(request.sequence, 1)
        return super().on_block_segment(request)


@fault("block-download-sent-acknowledged", Defect.LOST_SEGMENTS, "block-download.lost")
class SentAcknowledged(_Gaps):
    """Acknowledges the last number that came instead of the last in sequence."""

    def on_gap(
        self, transfer: BlockDownload, ack: BlockAck, request: BlockSegment
    ) -> list[Response]:
        return [replace(ack, sequence=request.sequence)]


@fault("block-download-repeated-kept-twice", Defect.LOST_SEGMENTS, "block-download.lost[middle]")
class RepeatedKeptTwice(_Gaps):
    """Acknowledges one segment fewer than it has stored when there was a gap."""

    def on_gap(
        self, transfer: BlockDownload, ack: BlockAck, request: BlockSegment
    ) -> list[Response]:
        return [replace(ack, sequence=max(ack.sequence - 1, 0))]


@fault("block-download-gap-aborted", Defect.LOST_SEGMENTS, "block-download.lost")
class GapAborted(Server):
    """Aborts when a segment is lost."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        if isinstance(self.transfer, BlockDownload) and request.sequence > self.transfer.due:
            raise Refusal(AbortCode.INVALID_SEQUENCE_NUMBER)
        return super().on_block_segment(request)


@fault("block-download-second-gap-aborted", Defect.LOST_SEGMENTS, "block-download.lost-twice")
class SecondGapAborted(_Gaps):
    """Aborts when segments are lost a second time in one transfer."""

    gaps = 0

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.gaps = 0
        return super().on_block_download_initiate(request)

    def on_gap(
        self, transfer: BlockDownload, ack: BlockAck, request: BlockSegment
    ) -> list[Response]:
        self.gaps += 1
        if self.gaps > 1:
            raise Refusal(AbortCode.TIMED_OUT)
        return [ack]


@fault("block-download-ends-with-gap", Defect.LOST_SEGMENTS, "block-download.lost[before-last]")
class EndsWithGap(_Gaps):
    """Expects the end frame behind a last segment though one before it is lost."""

    def on_gap(
        self, transfer: BlockDownload, ack: BlockAck, request: BlockSegment
    ) -> list[Response]:
        transfer.ended = request.last
        return [ack]


@fault("block-download-numbering-goes-on", Defect.LOST_SEGMENTS, "block-download.lost[middle]")
class NumberingGoesOn(_Gaps):
    """Expects what is sent again under its old numbers."""

    def on_gap(
        self, transfer: BlockDownload, ack: BlockAck, request: BlockSegment
    ) -> list[Response]:
        transfer.due = ack.sequence + 1
        return [ack]


@fault("block-download-crc-of-repeated", Defect.LOST_SEGMENTS, "block-download.lost")
class CrcOfRepeated(Server):
    """Sums up what it discards behind a gap, and then the same again."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        self.heard = bytearray()

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        self.heard.clear()
        return super().on_block_download_initiate(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        self.heard += request.payload
        return super().on_block_segment(request)

    def check_crc(self, transfer: BlockDownload, request: BlockEnd, data: bytes) -> None:
        super().check_crc(transfer, request, bytes(self.heard[: len(self.heard) - request.unused]))


@fault(
    "block-download-repeated-segment-stored",
    Defect.LOST_SEGMENTS,
    "block-download.repeated-segment",
)
class RepeatedStored(Server):
    """Stores a segment that comes twice in a row twice."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and 0 < request.sequence == transfer.due - 1:
            self.take_block_segment(transfer, request)
            return []
        return super().on_block_segment(request)

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        transfer.data += request.payload


@fault("block-download-sequence-zero-stored", Defect.LOST_SEGMENTS, "block-download.sequence-zero")
class SequenceZeroStored(Server):
    """Takes number 0 for the segment that is due."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        if isinstance(self.transfer, BlockDownload) and request.sequence == 0:
            request = replace(request, sequence=self.transfer.due)
        return super().on_block_segment(request)


@fault(
    "block-download-lost-first-forgotten", Defect.TIMING, "block-download.lost[first]", timed=True
)
class LostFirstForgotten(Server):
    """Waits for ever for the first segment of a sub-block, and never says so."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and transfer.due == 1 != request.sequence:
            return []
        return super().on_block_segment(request)

    def expire(self) -> list[bytes]:
        waits = isinstance(self.transfer, BlockDownload) and self.transfer.due == 1
        return [] if waits else super().expire()
