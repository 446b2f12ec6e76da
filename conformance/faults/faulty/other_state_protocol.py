"""Nodes that serve transfers wrongly in NMT state Operational alone."""

from functools import partial

from conformance.faults import registry
from conformance.faults.odd_serving import AnswersAborts, LosesLongUploads, OddServing, WantsCrc
from conformance.faults.registry import About, Defect
from conformance.reference.node import ServerChannel
from conformance.sdo.nmt import NmtState

fault = partial(registry.fault, about=About.NMT)


class Operational(OddServing):
    """Is wrong in NMT state Operational."""

    def is_odd(self, channel: ServerChannel) -> bool:
        del channel
        return self.state is NmtState.OPERATIONAL


@fault("abort-answered-in-operational", Defect.ABORT, "other-state.frame")
class OperationalAnswersAborts(Operational, AnswersAborts):
    """Sends each abort back in NMT state Operational."""


@fault("upload-zeros-beyond-255-in-operational", Defect.FIELD_WIDTH, "other-state.long")
class OperationalLosesLongUploads(Operational, LosesLongUploads):
    """Sends zeros beyond byte 255 of segmented uploads in NMT state Operational."""


@fault("crc-wanted-in-operational", Defect.CRC, "other-state.conversation")
class OperationalWantsCrc(Operational, WantsCrc):
    """Aborts block downloads without a CRC at their end in NMT state Operational."""
