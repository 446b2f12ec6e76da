"""Servers that are strict or lenient about bits, bytes and lengths, as they may be."""

from conformance.faults.registry import unusual
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.objects import Refusal

# The bytes of an initiate that holds its multiplexer and no more.
SHORTEST_INITIATE = 4


@unusual("strict-about-reserved-bits")
class StrictAboutBits(Server):
    """Refuses requests with reserved bits set, or with n where it has no meaning."""

    def react(self, request: Request) -> list[Response]:
        bits = getattr(request, "reserved_bits", 0)
        meaningless = (
            isinstance(request, DownloadInitiate)
            and request.unused
            and not (request.expedited and request.sized)
        )
        if bits or meaningless:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().react(request)


@unusual("strict-about-reserved-bytes", soft=True)
class StrictAboutBytes(Server):
    """Refuses upload requests with reserved bytes that are not 0."""

    def react(self, request: Request) -> list[Response]:
        if isinstance(request, UploadInitiate | UploadSegment) and any(request.reserved):
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().react(request)


@unusual("short-frames-served")
class ShortFramesServed(Node):
    """Serves a request of fewer than 8 bytes that holds all it needs."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        command = frame.data[:1]
        upload = command == b"\x40" and frame.dlc >= 4
        download = command in (b"\x2f", b"\x2b", b"\x27", b"\x23") and (
            frame.dlc >= 8 - ((command[0] >> 2) & 3)
        )
        if self.is_addressed(frame) and (upload or download):
            frame = CanFrame(frame.can_id, frame.data.ljust(FRAME_LENGTH, b"\0"))
        return super().receive(frame)


@unusual("short-frames-refused")
class ShortFramesRefused(Server):
    """Answers a frame of fewer than 8 bytes with an abort."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        if frame[:1] >= b"\x80":
            return []
        self.transfer = None
        return [Abort(Multiplexer(0), AbortCode.LENGTH_MISMATCH).encode()]


def _holds_all(request: Request, length: int) -> bool:
    """Say whether the bytes of a frame cut short are all that a request needs."""
    match request:
        case DownloadInitiate(expedited=True):
            return length >= SHORTEST_INITIATE + len(request.data)
        case DownloadInitiate(sized=True) | BlockDownloadInitiate(sized=True):
            return False
        case DownloadSegment():
            return length > len(request.data)
        case BlockSegment():
            return False
        case BlockUploadInitiate():
            return length > SHORTEST_INITIATE
        case DownloadInitiate() | UploadInitiate() | BlockDownloadInitiate() | Abort():
            return length >= SHORTEST_INITIATE
        case BlockAck() | BlockEnd():
            return length >= 3
        case _:
            return length >= 1


@unusual("whole-short-frames-served")
class WholeShortFramesServed(Server):
    """Serves any request of fewer than 8 bytes that holds all it needs, also within a transfer."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        whole = frame.ljust(FRAME_LENGTH, b"\0")
        if not frame or not _holds_all(self.decode(whole), len(frame)):
            return []
        return self.receive(whole)


@unusual("short-frames-called-not-valid")
class ShortFramesNotValid(Server):
    """Calls any frame of fewer than 8 bytes no valid command, whatever it begins with."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        mux = Multiplexer(0)
        if self.transfer is not None:
            mux = self.transfer.mux
        elif len(frame) >= SHORTEST_INITIATE:
            mux = UploadInitiate.decode(frame.ljust(FRAME_LENGTH, b"\0")).mux
        self.transfer = None
        return [Abort(mux, AbortCode.COMMAND_NOT_VALID).encode()]
