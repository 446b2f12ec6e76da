"""Nodes that are wrong in their frames: identifiers, formats, lengths, and who is answered."""

from conformance.faults.registry import Defect, fault
from conformance.reference.node import Node
from conformance.reference.segmented_server import Upload
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request, is_abort
from conformance.sdo.frames import DownloadInitiate, DownloadInitiateResponse
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.limits import EXPEDITED_LENGTH, SEGMENT_LENGTH
from conformance.sdo.objects import Entry


@fault("response-copied-to-other-id", Defect.FRAME_SHAPE, "frame.one-identifier")
class ResponseCopied(Node):
    """Sends every answer on a second identifier as well."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Repeat the answers on 480h plus node-ID."""
        answers = super().receive(frame)
        return answers + [CanFrame(answer.can_id - 0x100, answer.data) for answer in answers]


@fault("abort-on-request-identifier", Defect.FRAME_SHAPE, "frame.abort-identifier")
class AbortOnRequestId(Node):
    """Sends its aborts back on the identifier of the requests."""

    def respond(self, data: bytes) -> CanFrame:
        aborts = is_abort(data)
        return CanFrame(self.request_id if aborts else self.response_id, data)


@fault("answers-twice", Defect.FRAME_SHAPE, "frame.one-answer", "upload.multiplexer")
class AnswersTwice(Node):
    """Sends every answer twice."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        return [answer for answer in super().receive(frame) for _ in range(2)]


@fault("answers-extended", Defect.FRAME_SHAPE, "frame.extended-ignored", soft=True)
class AnswersExtended(Node):
    """Takes a 29-bit identifier of the same number for its own."""

    def is_addressed(self, frame: CanFrame) -> bool:
        return frame.can_id == self.request_id and not frame.remote


class _StaleBuffer(Node):
    """Keeps one receive buffer and does not clear what a shorter frame leaves in it."""

    buffer = bytes(FRAME_LENGTH)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if not self.is_addressed(frame):
            return super().receive(frame)
        self.buffer = frame.data + self.buffer[len(frame.data) :]
        return [self.respond(data) for data in self.server.receive(self.buffer)]


@fault("answers-remote", Defect.FRAME_SHAPE, "frame.remote")
class AnswersRemote(_StaleBuffer):
    """Takes a remote frame for the request before it."""

    def is_addressed(self, frame: CanFrame) -> bool:
        return frame.can_id == self.request_id and not frame.extended

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if self.is_addressed(frame) and not frame.remote and frame.dlc != FRAME_LENGTH:
            return []
        return super().receive(frame)


@fault("answers-remote-with-abort", Defect.FRAME_SHAPE, "frame.remote-ignored", soft=True)
class AbortsRemote(Node):
    """Answers a remote frame with an abort."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if frame.can_id == self.request_id and frame.remote:
            return [self.respond(bytes.fromhex("8000000001000405"))]
        return super().receive(frame)


@fault("dead-after-remote", Defect.ROBUSTNESS, "frame.remote")
class DeadAfterRemote(Node):
    """Answers nothing behind a remote frame: the data that it reads are not there."""

    is_dead = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        self.is_dead |= frame.can_id == self.request_id and frame.remote
        return [] if self.is_dead else super().receive(frame)


@fault("short-request-from-stale-buffer", Defect.FRAME_SHAPE, "frame.short")
class StaleBuffer(_StaleBuffer):
    """Completes a request of fewer than 8 bytes with what was received before it."""


@fault("short-request-padded", Defect.FRAME_SHAPE, "frame.short-segment")
class PaddedRequests(Node):
    """Completes a request of fewer than 8 bytes with 0, data included."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Fill up the data of requests that have 4 bytes or of segments that have 1."""
        if self.is_addressed(frame) and (frame.data[:1] < b"\x20" or frame.dlc >= 4):
            return super().receive(CanFrame(frame.can_id, frame.data.ljust(FRAME_LENGTH, b"\0")))
        return super().receive(frame)


@fault(
    "short-download-cut", Defect.FRAME_SHAPE, "frame.short-download-whole", "frame.short-download"
)
class ShortDownloadCut(Node):
    """Serves a download of fewer than 8 bytes, but loses its last byte."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        short = self.is_addressed(frame) and 4 < frame.dlc < FRAME_LENGTH
        if short and frame.data[:1] in (b"\x2f", b"\x2b"):
            cut = frame.data[:-1].ljust(FRAME_LENGTH, b"\0")
            return super().receive(CanFrame(frame.can_id, cut))
        return super().receive(frame)


@fault("short-download-stores-nothing", Defect.FRAME_SHAPE, "frame.short-download")
class ShortDownloadOfNothing(Server):
    """Takes an initiate without its data for a download of none; has no data to read then."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        request = decode_request(frame.ljust(FRAME_LENGTH, b"\0"))
        empty = len(frame) == FRAME_LENGTH - EXPEDITED_LENGTH
        if not (empty and isinstance(request, DownloadInitiate) and request.expedited):
            return super().on_wrong_length(frame)
        entry = self.objects.writable(request.mux)
        entry.value = b""
        entry.has_data = False
        return [DownloadInitiateResponse(request.mux).encode()]

    def store(self, entry: Entry, data: bytes) -> None:
        entry.has_data = True
        super().store(entry, data)


@fault("answers-all-nodes", Defect.FRAME_SHAPE, "frame.other-node")
class AnswersAllNodes(Node):
    """Answers requests to any node."""

    def is_addressed(self, frame: CanFrame) -> bool:
        return frame.can_id & 0x780 == 0x600 and not frame.extended and not frame.remote


@fault("node-id-masked", Defect.FRAME_SHAPE, "frame.other-node")
class MaskedNodeId(Node):
    """Looks at four bits of the node-ID only."""

    def is_addressed(self, frame: CanFrame) -> bool:
        same = frame.can_id & 0x78F == self.request_id & 0x78F
        return same and not frame.extended and not frame.remote


@fault("echoes-request", Defect.FRAME_SHAPE, "frame.mirror")
class EchoesRequest(Node):
    """Sends back each request of an upload of more than the device type instead of an answer."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Mirror upload initiates once the device type was read."""
        if (
            self.is_addressed(frame)
            and frame.data[:1] == b"\x40"
            and frame.data[1:3] == b"\x18\x10"
        ):
            return [self.respond(frame.data)]
        return super().receive(frame)


@fault("short-abort-served", Defect.ABORT, "frame.short-abort")
class ShortAbortServed(Server):
    """Takes an abort of fewer than 8 bytes for a request for the next segment."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        if isinstance(self.transfer, Upload) and is_abort(frame):
            return self.receive(bytes([0x60 | self.transfer.toggle << 4]) + bytes(7))
        return super().on_wrong_length(frame)


@fault("short-segment-request-skips", Defect.FRAME_SHAPE, "frame.short-segment-request")
class ShortRequestSkips(Server):
    """Leaves a segment out when the request for it is cut short."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        """Fill up the request and go on too far."""
        if isinstance(self.transfer, Upload) and frame:
            self.transfer.offset += SEGMENT_LENGTH
            return self.receive(frame.ljust(FRAME_LENGTH, b"\0"))
        return super().on_wrong_length(frame)


@fault("short-block-segment-padded", Defect.FRAME_SHAPE, "frame.short-block-segment")
class ShortBlockSegmentPadded(Server):
    """Fills up a segment of a block download that is cut short."""

    def on_wrong_length(self, frame: bytes) -> list[bytes]:
        if isinstance(self.transfer, BlockDownload) and frame:
            return self.receive(frame.ljust(FRAME_LENGTH, b"\0"))
        return super().on_wrong_length(frame)


@fault("answer-as-long-as-request", Defect.FRAME_SHAPE, "frame.short")
class AsLongAsRequest(Node):
    """Serves requests of 1 to 7 bytes, and sends answers of as many."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if not self.is_addressed(frame) or not 0 < frame.dlc < FRAME_LENGTH:
            return super().receive(frame)
        padded = CanFrame(frame.can_id, frame.data.ljust(FRAME_LENGTH, b"\0"))
        return [
            CanFrame(self.response_id, answer.data[: frame.dlc])
            if answer.can_id == self.response_id
            else answer
            for answer in super().receive(padded)
        ]


@fault("deaf-after-remote-frame", Defect.ROBUSTNESS, "frame.remote")
class DeafAfterRemote(Node):
    """Hears nothing more on its request identifier once it has got a remote frame there."""

    deaf = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        ours = frame.can_id == self.request_id and not frame.extended
        self.deaf |= ours and frame.remote
        return [] if ours and self.deaf else super().receive(frame)
