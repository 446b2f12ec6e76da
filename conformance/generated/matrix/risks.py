"""Which fields of the matrix a device may not survive: it depends on the frame that they send."""

from conformance.generated.matrix.stimuli import Stimulus, Targets
from conformance.run.risks import LOST_SEGMENT, Risk, RiskOf, risk_of_frame
from conformance.sdo.decoding import decode_segment
from conformance.sdo.frames import BlockSegment
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer

# Which objects a stimulus names does not change its kind.
_ANY = Targets(1, Multiplexer(0x2000), Multiplexer(0x2000), Multiplexer(0x2000))


def of_stimulus(stimulus: Stimulus) -> Risk:
    """Return what is unusual about a stimulus where no sub-block is due, or else its service."""
    return risk_of_frame(stimulus(_ANY))


def in_sub_block(due: int) -> RiskOf:
    """Return the same for a state in which a segment with the number ``due`` comes next."""

    def risk_of(stimulus: Stimulus) -> Risk | None:
        frame = stimulus(_ANY)
        if frame.remote or frame.extended or len(frame.data) != FRAME_LENGTH:
            return risk_of_frame(frame)
        request = decode_segment(frame.data)
        if not isinstance(request, BlockSegment):
            return risk_of_frame(frame)
        return None if request.sequence == due else LOST_SEGMENT

    return risk_of
