"""Nodes that serve transfers wrongly on a further channel alone."""

from functools import partial

from conformance.faults import registry
from conformance.faults.odd_serving import AnswersAborts, LosesLongUploads, OddServing, WantsCrc
from conformance.faults.registry import About, Defect
from conformance.reference.node import ServerChannel

fault = partial(registry.fault, about=About.CHANNELS)


class Further(OddServing):
    """Is wrong on a further channel."""

    def is_odd(self, channel: ServerChannel) -> bool:
        return channel is not self.channels[0]


@fault("abort-answered-on-further-channel", Defect.ABORT, "independence.frame")
class FurtherAnswersAborts(Further, AnswersAborts):
    """Sends each abort back on a further channel."""


@fault("upload-zeros-beyond-255-on-further-channel", Defect.FIELD_WIDTH, "independence.long")
class FurtherLosesLongUploads(Further, LosesLongUploads):
    """Sends zeros beyond byte 255 of segmented uploads on a further channel."""


@fault("crc-wanted-on-further-channel", Defect.CRC, "independence.conversation")
class FurtherWantsCrc(Further, WantsCrc):
    """Aborts block downloads without a CRC at their end on a further channel."""
