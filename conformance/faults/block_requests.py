"""Servers that stumble over block requests with odd bits, and over segments that are cut short."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.frames import BlockDownloadInitiate, BlockUploadInitiate, Request, Response
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.segmented_server import SEGMENT_LENGTH, Upload
from conformance.sdo.server import BlockDownload, Server

SHAPE = DefectClass.FRAME_SHAPE
ROBUST = DefectClass.ROBUSTNESS


@fault("block-sub-command-6-uploads", ROBUST, "specifier.sub-command[A6h]")
class SubCommandUploads(Server):
    """Takes A6h, whose bits are no initiate, for a block upload initiate."""

    def decode(self, frame: bytes) -> Request:
        """Look at one bit of the sub-command while idle."""
        if self.transfer is None and frame[0] == 0xA6:
            return super().decode(b"\xa4" + frame[1:])
        return super().decode(frame)


@fault("block-sub-command-7-downloads", ROBUST, "specifier.sub-command[C7h]")
class SubCommandDownloads(Server):
    """Takes C7h, whose bits are no initiate, for a block download initiate."""

    def decode(self, frame: bytes) -> Request:
        """Do not look at the sub-command while idle."""
        if self.transfer is None and frame[0] == 0xC7:
            return super().decode(b"\xc4" + frame[1:])
        return super().decode(frame)


@fault(
    "block-download-reserved-bits-ignored", ROBUST, "specifier.block-download-reserved-bits[08h]"
)
class DownloadReservedIgnored(Server):
    """Does not answer a block download initiate with a reserved bit set."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Keep silent unless they are 0."""
        return [] if request.reserved_bits else super().on_block_download_initiate(request)


@fault("block-upload-reserved-bits-ignored", ROBUST, "specifier.block-upload-reserved-bits[08h]")
class UploadReservedIgnored(Server):
    """Does not answer a block upload initiate with a reserved bit set."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Keep silent unless they are 0."""
        return [] if request.reserved_bits else super().on_block_upload_initiate(request)


@fault("short-segment-request-skips", SHAPE, "frame.short-segment-request")
class ShortRequestSkips(Server):
    """Leaves a segment out when the request for it is cut short."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        """Fill up the request and go on too far."""
        if isinstance(self.transfer, Upload) and frame:
            self.transfer.offset += SEGMENT_LENGTH
            return self.receive(frame.ljust(FRAME_LENGTH, b"\0"))
        return super().on_wrong_length(frame)


@fault("short-block-segment-padded", SHAPE, "frame.short-block-segment")
class ShortBlockSegmentPadded(Server):
    """Fills up a segment of a block download that is cut short."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        """Take what is missing for zeros."""
        if isinstance(self.transfer, BlockDownload) and frame:
            return self.receive(frame.ljust(FRAME_LENGTH, b"\0"))
        return super().on_wrong_length(frame)
