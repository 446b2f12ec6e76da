"""Servers whose one defect turns up wherever an abort or a download is, and hides other ones.

Each was met in servers that others wrote. They leave what they are not about to the class that
follows, so that each can be put together with any other fault.
"""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
)
from conformance.sdo.objects import DataType, Entry, ObjectDictionary, Refusal
from conformance.sdo.segmented_server import NO_MULTIPLEXER, Download
from conformance.sdo.server import BlockDownload, Server

ABORT = DefectClass.ABORT
CHECKS = DefectClass.ACCESS_OR_SIZE
# Bytes of every string and domain of a server that knows no other length; text fills its segments.
FIXED_LENGTH, FIXED_TEXT = 300, 301
# The segment of a sub-block for which a server has no room.
NO_ROOM_FROM = 9


@fault("every-abort-answered", ABORT, "abort.not-answered")
class EveryAbortAnswered(Server):
    """Answers every abort with an abort of 0000h:00, as it does commands that it does not know."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Not know the command."""
        return [*super().on_abort(request), Abort(NO_MULTIPLEXER, AbortCode.COMMAND_NOT_VALID)]


@fault("download-confirmed-then-refused", ABORT, "segmented-download.too-")
class ConfirmedThenRefused(Server):
    """Confirms the last segment of a download before it finds that it has to refuse it."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Put the abort behind the confirmation."""
        confirmed = isinstance(self.transfer, Download) and isinstance(request, DownloadSegment)
        responses = super().refuse(request, code)
        late = code is not AbortCode.TOGGLE_NOT_ALTERNATED
        if confirmed and late and isinstance(request, DownloadSegment) and request.last:
            return [DownloadSegmentResponse(request.toggle), *responses]
        return responses


@fault("unsized-downloads-refused", CHECKS, "segmented-download.size-not-indicated")
class UnsizedRefused(Server):
    """Refuses segmented and block downloads that do not indicate their size."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Insist on 21h."""
        if not request.expedited and not request.sized:
            raise Refusal(AbortCode.LENGTH_MISMATCH)
        return super().on_download_initiate(request)

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Insist on C2h or C6h."""
        if not request.sized:
            raise Refusal(AbortCode.LENGTH_MISMATCH)
        return super().on_block_download_initiate(request)


@fault("blocks-refused-without-multiplexer", DefectClass.ROBUSTNESS, "specifier.block-")
class BlocksRefused(Server):
    """Has no block transfers, and refuses them with 0000h:00."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        """Not know the command."""
        return self.refuse_block()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Not know the command."""
        return self.refuse_block()

    def refuse_block(self) -> list[Response]:
        """End what runs, and name no object."""
        self.transfer = None
        return [Abort(NO_MULTIPLEXER, AbortCode.COMMAND_NOT_VALID)]


@fault("strings-padded", CHECKS, "download.text")
class StringsPadded(Server):
    """Has strings and domains of 300 or 301 bytes only, and fills up with 0 what comes shorter."""

    def __init__(self, objects: ObjectDictionary) -> None:
        """Give what can be written its length."""
        super().__init__(objects)
        for entry in objects:
            if self.is_fixed(entry):
                entry.capacity = self.length_of(entry)
                entry.value = entry.value.ljust(entry.capacity, b"\0")

    def store(self, entry: Entry, data: bytes) -> None:
        """Fill up."""
        if self.is_fixed(entry):
            data = data.ljust(entry.capacity, b"\0")
        super().store(entry, data)

    def length_of(self, entry: Entry) -> int:
        """Return the only length that an entry has."""
        return FIXED_TEXT if entry.data_type is DataType.VISIBLE_STRING else FIXED_LENGTH

    def is_fixed(self, entry: Entry) -> bool:
        """Say whether an entry ought to take values of different lengths."""
        return entry.data_type.length is None and entry.access.writable


@fault("abort-in-transfer-unnamed", ABORT, "segmented-upload.toggle")
class AbortUnnamed(Server):
    """Ends a transfer with an abort of 0000h:00, and goes on with it all the same."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Keep the transfer that the request was about."""
        running = self.transfer
        responses = super().refuse(request, code)
        if running is None:
            return responses
        self.transfer = running
        return [
            replace(response, mux=NO_MULTIPLEXER) if isinstance(response, Abort) else response
            for response in responses
        ]


@fault("aborts-inside-sub-block", ABORT, "block-download.size")
class AbortsInsideSubBlock(Server):
    """Has room for 8 segments of each sub-block, and aborts with 0000h:00 when the ninth comes."""

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Run out of room; what is still on its way finds the server idle."""
        if isinstance(self.transfer, BlockDownload) and request.sequence >= NO_ROOM_FROM:
            self.transfer = None
            return [Abort(NO_MULTIPLEXER, AbortCode.OUT_OF_MEMORY)]
        return super().on_block_segment(request)
