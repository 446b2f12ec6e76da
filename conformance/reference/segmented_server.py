"""What the reference server does without block transfer: frames in, frames out, no clock, no bus.

It is idle or in one transfer. Where CiA 301 leaves a choice, it takes the one that most servers
take: a new initiate ends the running transfer and is served; a frame that does not belong there
ends the transfer with 05040001h; reserved bits and bytes of a request are ignored; any abort ends
the transfer. Each reaction is a method of its own: a faulty or an unusual server is a subclass
that changes one.
"""

from dataclasses import dataclass, field
from typing import Protocol

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH, SEGMENT_LENGTH
from conformance.sdo.objects import Entry, ObjectDictionary, Refusal

NO_MULTIPLEXER = Multiplexer(0, 0)


@dataclass(slots=True)
class Download:
    """A segmented download: what came so far, and the toggle bit that is due."""

    mux: Multiplexer
    entry: Entry
    size: int | None
    toggle: int = 0
    data: bytearray = field(default_factory=bytearray)

    @property
    def room(self) -> int:
        """How many bytes may still come."""
        limit = self.entry.longest if self.size is None else self.size
        return limit - len(self.data)


@dataclass(slots=True)
class Upload:
    """A segmented upload: what is sent, how far, and the toggle bit that is due."""

    mux: Multiplexer
    data: bytes
    offset: int = 0
    toggle: int = 0


class Transfer(Protocol):
    """A transfer of whatever kind: it is about one object."""

    mux: Multiplexer


class SegmentedServer:
    """One SDO server on an object dictionary, which refuses block transfers."""

    def __init__(self, objects: ObjectDictionary) -> None:
        """Start idle."""
        self.objects = objects
        self.transfer: Transfer | None = None

    def receive(self, frame: bytes) -> list[bytes]:
        """Take the data bytes of one request; return those of the responses, in order."""
        if len(frame) != FRAME_LENGTH:
            return self.on_wrong_length(frame)
        request = self.decode(frame)
        try:
            responses = self.react(request)
        except Refusal as refusal:
            responses = self.refuse(request, refusal.code)
        return [response.encode() for response in responses]

    def decode(self, frame: bytes) -> Request:
        """Read a request of 8 bytes."""
        return decode_request(frame)

    def expire(self) -> list[bytes]:
        """Give up the running transfer: the client was silent for too long (CiA 301, 7.2.4.2)."""
        if self.transfer is None:
            return []
        abort = Abort(self.transfer.mux, AbortCode.TIMED_OUT)
        self.transfer = None
        return [abort.encode()]

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        """Ignore what is not a frame of 8 bytes."""
        return []

    def react(self, request: Request) -> list[Response]:
        """Choose the reaction by the kind of the request."""
        match request:
            case Abort():
                return self.on_abort(request)
            case DownloadInitiate():
                return self.on_download_initiate(request)
            case UploadInitiate():
                return self.on_upload_initiate(request)
            case BlockDownloadInitiate() | BlockUploadInitiate():
                return self.on_block_initiate(request)
            case DownloadSegment():
                return self.on_download_segment(request)
            case UploadSegment():
                return self.on_upload_segment(request)
            case _:
                return self.on_unexpected(request)

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """End the transfer, if any, with an abort that names what it is about."""
        mux = self.refused_multiplexer(request)
        self.transfer = None
        return [Abort(mux, code)]

    def refused_multiplexer(self, request: Request) -> Multiplexer:
        """Name the refused initiate's object, or the running transfer's, or none."""
        if isinstance(
            request, DownloadInitiate | UploadInitiate | BlockDownloadInitiate | BlockUploadInitiate
        ):
            return request.mux
        return self.transfer.mux if self.transfer else NO_MULTIPLEXER

    def on_abort(self, request: Abort) -> list[Response]:
        """End the transfer without a word."""
        self.transfer = None
        return []

    def on_unexpected(self, request: Request) -> list[Response]:
        """Refuse what has no meaning here."""
        raise Refusal(AbortCode.COMMAND_NOT_VALID)

    def on_block_initiate(
        self, request: BlockDownloadInitiate | BlockUploadInitiate
    ) -> list[Response]:
        """Refuse: this server has no block transfer."""
        self.transfer = None
        return self.on_unexpected(request)

    # Download

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        """Write up to 4 bytes at once, or get ready for segments."""
        self.transfer = None
        entry = self.entry_to_write(request)
        if request.expedited:
            self.store(entry, self.expedited_data(request, entry))
        else:
            self.check_announced_size(entry, request.size)
            self.transfer = self.start_download(request, entry)
        return [DownloadInitiateResponse(request.mux)]

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Find the entry, or refuse."""
        return self.objects.writable(request.mux)

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        """Take as many bytes as the request indicates or, where it does not, as the type has."""
        return request.data if request.sized else request.data[: entry.longest]

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Refuse a size that the entry cannot take before any data has come."""
        if size is not None:
            entry.check_length(size)

    def start_download(self, request: DownloadInitiate, entry: Entry) -> Download:
        """Set up the state of a segmented download."""
        return Download(request.mux, entry, request.size)

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        """Take up to 7 bytes; after the last ones, write."""
        transfer = self.transfer
        if not isinstance(transfer, Download):
            return self.on_unexpected(request)
        self.check_toggle(transfer, request.toggle)
        transfer.data += self.segment_data(transfer, request)
        if request.last:
            self.finish_download(transfer)
            self.transfer = None
        transfer.toggle ^= 1
        return [DownloadSegmentResponse(request.toggle)]

    def check_toggle(self, transfer: Download | Upload, toggle: int) -> None:
        """Refuse a toggle bit that did not alternate."""
        if toggle != transfer.toggle:
            raise Refusal(AbortCode.TOGGLE_NOT_ALTERNATED)

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Return the bytes that count.

        n = 0 in a last segment also stands for "not stated": then the size that was announced
        says how many bytes are left.
        """
        data = request.data
        if len(data) <= transfer.room:
            return data
        if request.last and request.unused == 0 and transfer.size is not None:
            return data[: transfer.room]
        raise Refusal(AbortCode.LENGTH_TOO_HIGH)

    def finish_download(self, transfer: Download) -> None:
        """Write what came, unless it is less than was announced."""
        if transfer.size is not None and len(transfer.data) < transfer.size:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        self.store(transfer.entry, bytes(transfer.data))

    def store(self, entry: Entry, data: bytes) -> None:
        """Write a value that has the right length and lies within the limits."""
        entry.check_length(len(data))
        entry.check_limits(data)
        entry.value = data

    # Upload

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        """Answer with up to 4 bytes, or with the size of what comes in segments."""
        self.transfer = None
        entry = self.objects.readable(request.mux)
        return [self.start_upload(request.mux, self.value_to_read(entry))]

    def value_to_read(self, entry: Entry) -> bytes:
        """Return the bytes that an upload carries."""
        return entry.value

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        """Answer an upload initiate; set up the state where segments follow."""
        if 1 <= len(data) <= EXPEDITED_LENGTH:
            return UploadInitiateResponse.with_data(mux, data)
        self.transfer = Upload(mux, data)
        return UploadInitiateResponse.with_size(mux, len(data))

    def on_upload_segment(self, request: UploadSegment) -> list[Response]:
        """Send the next bytes; mark the last."""
        transfer = self.transfer
        if not isinstance(transfer, Upload):
            return self.on_unexpected(request)
        self.check_toggle(transfer, request.toggle)
        data = self.next_upload_data(transfer)
        transfer.offset += len(data)
        last = transfer.offset == len(transfer.data)
        if last:
            self.transfer = None
        transfer.toggle ^= 1
        return [UploadSegmentResponse.with_data(data, toggle=request.toggle, last=last)]

    def next_upload_data(self, transfer: Upload) -> bytes:
        """Return the bytes of the next segment."""
        return transfer.data[transfer.offset : transfer.offset + SEGMENT_LENGTH]
