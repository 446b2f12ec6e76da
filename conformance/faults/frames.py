"""Nodes that are wrong in their frames: identifiers, formats, lengths, and who is answered."""

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.node import Node

SHAPE = DefectClass.FRAME_SHAPE


@fault("response-on-other-id", SHAPE, "download.")
class ResponseOnOtherId(Node):
    """Confirms downloads with the identifier of the next node."""

    def respond(self, data: bytes) -> CanFrame:
        """Shift the identifier of 60h."""
        return CanFrame(self.response_id + (data[:1] == b"\x60"), data)


@fault("response-copied-to-other-id", SHAPE, "frame.one-identifier")
class ResponseCopied(Node):
    """Sends every answer on a second identifier as well."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Repeat the answers on 480h plus node-ID."""
        answers = super().receive(frame)
        return answers + [CanFrame(answer.can_id - 0x100, answer.data) for answer in answers]


@fault("response-short-dlc", SHAPE, "upload.")
class ShortResponses(Node):
    """Leaves away the bytes behind the last one that is not 0."""

    def respond(self, data: bytes) -> CanFrame:
        """Cut the frame, to 4 bytes at least."""
        return CanFrame(self.response_id, data[:4] + data[4:].rstrip(b"\0"))


@fault("response-extended", SHAPE, "upload.device-type")
class ExtendedResponses(Node):
    """Answers with a 29-bit identifier."""

    def respond(self, data: bytes) -> CanFrame:
        """Use the other identifier format."""
        return CanFrame(self.response_id, data, extended=True)


@fault("abort-on-request-identifier", SHAPE, "frame.abort-identifier")
class AbortOnRequestId(Node):
    """Sends its aborts back on the identifier of the requests."""

    def respond(self, data: bytes) -> CanFrame:
        """Put an abort where the client sends its own."""
        aborts = data[:1] == b"\x80"
        return CanFrame(self.request_id if aborts else self.response_id, data)


@fault("answers-twice", SHAPE, "frame.one-answer")
class AnswersTwice(Node):
    """Sends every answer twice."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Repeat the answers."""
        return [answer for answer in super().receive(frame) for _ in range(2)]


@fault("answers-extended", SHAPE, "frame.extended-ignored", soft=True)
class AnswersExtended(Node):
    """Takes a 29-bit identifier of the same number for its own."""

    def is_addressed(self, frame: CanFrame) -> bool:
        """Look at the number alone."""
        return frame.can_id == self.request_id and not frame.remote


class _StaleBuffer(Node):
    """Keeps one receive buffer and does not clear what a shorter frame leaves in it."""

    buffer = bytes(FRAME_LENGTH)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Overwrite the beginning of the buffer."""
        if not self.is_addressed(frame):
            return super().receive(frame)
        self.buffer = frame.data + self.buffer[len(frame.data) :]
        return [self.respond(data) for data in self.server.receive(self.buffer)]


@fault("answers-remote", SHAPE, "frame.remote")
class AnswersRemote(_StaleBuffer):
    """Takes a remote frame for the request before it."""

    def is_addressed(self, frame: CanFrame) -> bool:
        """Do not look at the RTR bit."""
        return frame.can_id == self.request_id and not frame.extended

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Ignore short data frames."""
        if self.is_addressed(frame) and not frame.remote and frame.dlc != FRAME_LENGTH:
            return []
        return super().receive(frame)


@fault("answers-remote-with-abort", SHAPE, "frame.remote-ignored", soft=True)
class AbortsRemote(Node):
    """Answers a remote frame with an abort."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Refuse what has no data."""
        if frame.can_id == self.request_id and frame.remote:
            return [self.respond(bytes.fromhex("8000000001000405"))]
        return super().receive(frame)


@fault("short-request-from-stale-buffer", SHAPE, "frame.short")
class StaleBuffer(_StaleBuffer):
    """Completes a request of fewer than 8 bytes with what was received before it."""


@fault("short-request-padded", SHAPE, "frame.short-segment")
class PaddedRequests(Node):
    """Completes a request of fewer than 8 bytes with 0, data included."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Fill up the data of requests that have 4 bytes or of segments that have 1."""
        if self.is_addressed(frame) and (frame.data[:1] < b"\x20" or frame.dlc >= 4):
            return super().receive(CanFrame(frame.can_id, frame.data.ljust(FRAME_LENGTH, b"\0")))
        return super().receive(frame)


@fault("short-download-cut", SHAPE, "frame.short-download-whole")
class ShortDownloadCut(Node):
    """Serves a download of fewer than 8 bytes, but loses its last byte."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Put 0 for the last byte of 1 or 2 that came."""
        short = self.is_addressed(frame) and 4 < frame.dlc < FRAME_LENGTH
        if short and frame.data[:1] in (b"\x2f", b"\x2b"):
            cut = frame.data[:-1].ljust(FRAME_LENGTH, b"\0")
            return super().receive(CanFrame(frame.can_id, cut))
        return super().receive(frame)


@fault("answers-all-nodes", SHAPE, "frame.other-node")
class AnswersAllNodes(Node):
    """Answers requests to any node."""

    def is_addressed(self, frame: CanFrame) -> bool:
        """Look at the function code alone."""
        return frame.can_id & 0x780 == 0x600 and not frame.extended and not frame.remote


@fault("node-id-masked", SHAPE, "frame.other-node")
class MaskedNodeId(Node):
    """Looks at four bits of the node-ID only."""

    def is_addressed(self, frame: CanFrame) -> bool:
        """Leave out bits 4 to 6."""
        same = frame.can_id & 0x78F == self.request_id & 0x78F
        return same and not frame.extended and not frame.remote


@fault("echoes-request", SHAPE, "frame.mirror")
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


@fault("answers-late", DefectClass.TIMING, "run.no-late-response")
class AnswersLate(Node):
    """Answers an abort of the client after the transfers that follow it."""

    reads_to_go = 0

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Hold an answer back until 1000h was read twice: by a case, and at its end."""
        answers = super().receive(frame)
        if self.is_addressed(frame) and frame.data[:4] == bytes.fromhex("80181001"):
            self.reads_to_go = 2
        elif self.reads_to_go and answers and frame.data[1:4] == b"\x00\x10\x00":
            self.reads_to_go -= 1
            if not self.reads_to_go:
                answers.append(self.respond(bytes.fromhex("8018100100000008")))
        return answers
