"""Nodes whose fault only the end of a run can tell."""

from conformance.device.device import VENDOR_ID
from conformance.faults.registry import About, Defect, fault
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.objects import Entry


@fault("answers-late", Defect.TIMING, "run.no-late-response")
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


@fault("vendor-id-changes", Defect.LEAK, "run.constants", about=About.OBJECTS)
class VendorIdChanges(Server):
    """Has another vendor-ID (1018h:01) once a value was stored."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        self.objects.find(VENDOR_ID.mux).value = b"\x01\x02\x03\x04"


@fault("first-answers-twice", Defect.FRAME_SHAPE, "run.outside-the-cases")
class FirstAnswersTwice(Server):
    """Sends its first two answers twice."""

    left = 2

    def receive(self, frame: bytes) -> list[bytes]:
        answers = super().receive(frame)
        if answers and self.left:
            self.left -= 1
            return answers * 2
        return answers


@fault("one-request-behind", Defect.STATE, "frame.one-answer")
class OneRequestBehind(Server):
    """Answers each request when the next one comes."""

    held_back: tuple[bytes, ...] = ()

    def receive(self, frame: bytes) -> list[bytes]:
        answers, self.held_back = list(self.held_back), tuple(super().receive(frame))
        return answers
