"""Nodes whose fault only the end of a run can tell."""

from conformance.faults.registry import Defect, fault
from conformance.reference.node import Node
from conformance.sdo.can_frame import CanFrame


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
