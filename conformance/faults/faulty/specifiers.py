"""Servers that are wrong about commands that they do not know, or that do not belong there."""

from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import NO_MULTIPLEXER, SegmentedServer
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    Request,
    Response,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Refusal


@fault(
    "unknown-specifier-ignored",
    Defect.ROBUSTNESS,
    "specifier.unknown",
    "matrix.idle",
    "matrix.block-download-end",
    "matrix.block-upload-initiated",
    "matrix.block-upload-between",
    "matrix.block-upload-sent",
    "matrix.block-upload-end",
)
class UnknownIgnored(Server):
    """Does not answer a command specifier that it does not know."""

    def on_unexpected(self, request: Request) -> list[Response]:
        return []


@fault("unknown-specifier-code-wrong", Defect.ROBUSTNESS, "specifier.unknown")
class UnknownCodeWrong(Server):
    """Reports an unknown command specifier as a missing object."""

    def on_unexpected(self, request: Request) -> list[Response]:
        raise Refusal(AbortCode.OBJECT_MISSING)


@fault("unknown-specifier-served-as-upload", Defect.ROBUSTNESS, "specifier.unknown")
class UnknownServed(Server):
    """Serves an unknown command specifier as an upload."""

    def on_unexpected(self, request: Request) -> list[Response]:
        if isinstance(request, Unknown):
            mux = Multiplexer(int.from_bytes(request.frame[1:3], "little"), request.frame[3])
            return self.on_upload_initiate(UploadInitiate(mux))
        return super().on_unexpected(request)


@fault("unknown-specifier-spoils-next-read", Defect.ROBUSTNESS, "specifier.unknown-is-over")
class UnknownSpoilsNext(Server):
    """Reads 1018h:01 as 0 right after an unknown command specifier."""

    spoiled = False

    def react(self, request: Request) -> list[Response]:
        spoiled, self.spoiled = self.spoiled, isinstance(request, Unknown)
        if spoiled and request == UploadInitiate(Multiplexer(0x1018, 1)):
            return [UploadInitiateResponse.with_data(Multiplexer(0x1018, 1), b"\xff" * 4)]
        return super().react(request)


@fault("block-frame-confirmed-out-of-block", Defect.STATE, "specifier.out-of-block")
class BlockFrameConfirmed(Server):
    """Confirms the end of a block download that was not started."""

    def receive(self, frame: bytes) -> list[bytes]:
        if self.transfer is None and frame[:1] and frame[0] & 0xE3 == 0xC1:
            return [b"\xa1" + bytes(7)]
        return super().receive(frame)


@fault("block-refused-in-silence", Defect.ROBUSTNESS, "specifier.block-")
class BlockSilent(SegmentedServer):
    """Does not answer a block initiate, which it does not implement."""

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        return []


@fault("block-refused-with-wrong-code", Defect.ROBUSTNESS, "specifier.block-download")
class BlockCodeWrong(SegmentedServer):
    """Refuses block transfers as if the object did not exist."""

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        raise Refusal(AbortCode.OBJECT_MISSING)


@fault("block-upload-switched-without-leave", Defect.ROBUSTNESS, "specifier.block-upload")
class BlockSwitched(SegmentedServer):
    """Answers a block upload with an ordinary one though pst = 0 forbids it."""

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        if isinstance(request, BlockUploadInitiate):
            return self.on_upload_initiate(UploadInitiate(request.mux))
        return super().on_block_initiate(request)


@fault("block-sub-command-6-uploads", Defect.ROBUSTNESS, "specifier.sub-command[A6h]")
class SubCommandUploads(Server):
    """Takes A6h, whose bits are no initiate, for a block upload initiate."""

    def decode(self, frame: bytes) -> Request:
        if self.transfer is None and frame[0] == 0xA6:
            return super().decode(b"\xa4" + frame[1:])
        return super().decode(frame)


@fault("block-sub-command-7-downloads", Defect.ROBUSTNESS, "specifier.sub-command[C7h]")
class SubCommandDownloads(Server):
    """Takes C7h, whose bits are no initiate, for a block download initiate."""

    def decode(self, frame: bytes) -> Request:
        if self.transfer is None and frame[0] == 0xC7:
            return super().decode(b"\xc4" + frame[1:])
        return super().decode(frame)


@fault(
    "block-download-reserved-bits-ignored",
    Defect.ROBUSTNESS,
    "specifier.block-download-reserved-bits[08h]",
)
class DownloadReservedIgnored(Server):
    """Does not answer a block download initiate with a reserved bit set."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        return [] if request.reserved_bits else super().on_block_download_initiate(request)


@fault(
    "block-upload-reserved-bits-ignored",
    Defect.ROBUSTNESS,
    "specifier.block-upload-reserved-bits[08h]",
)
class UploadReservedIgnored(Server):
    """Does not answer a block upload initiate with a reserved bit set."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        return [] if request.reserved_bits else super().on_block_upload_initiate(request)


@fault("blocks-refused-without-multiplexer", Defect.ROBUSTNESS, "specifier.block-")
class BlocksRefused(Server):
    """Has no block transfers, and refuses them with 0000h:00."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        return self.refuse_block()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        return self.refuse_block()

    def refuse_block(self) -> list[Response]:
        """End what runs, and name no object."""
        self.transfer = None
        return [Abort(NO_MULTIPLEXER, AbortCode.COMMAND_NOT_VALID)]
