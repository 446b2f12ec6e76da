"""Which fields of the matrix a device may not survive: it depends on the frame that they send."""

from conformance.model_cases.matrix.stimuli import Stimulus, Targets
from conformance.model_cases.server_states import State
from conformance.run.risks import LOST_SEGMENT, Risk, RiskOf, risk_of_frame
from conformance.sdo.decoding import decode_segment
from conformance.sdo.frames import BlockSegment, Request
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer

# Which objects a stimulus names does not change its kind.
_ANY = Targets(1, *(Multiplexer(0x2000),) * 3, bytes(4))


def risk_in(state: State[Request | None]) -> RiskOf:
    """Return what tells the risk of a stimulus in a state.

    That is what is unusual about it, or else its service; but where a segment of a sub-block is
    due, any other segment.
    """

    def risk_of(stimulus: Stimulus) -> Risk | None:
        frame = stimulus(_ANY)
        whole = not frame.remote and not frame.extended and len(frame.data) == FRAME_LENGTH
        if state.segment is None or not whole:
            return risk_of_frame(frame)
        request = decode_segment(frame.data)
        if not isinstance(request, BlockSegment):
            return risk_of_frame(frame)
        return None if request.sequence == state.segment else LOST_SEGMENT

    return risk_of
