"""The frames of a run as messages of Python's logging, which pytest shows live on demand."""

import logging
from collections.abc import Callable, Sequence

from conformance.bus.link import Captured, Direction
from conformance.run.recording import ChannelDecoder
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.nmt import describe_nmt

LOGGER = logging.getLogger("conformance.frames")


def logging_too(
    listen: Callable[[Captured], None], channels: Sequence[ChannelIds]
) -> Callable[[Captured], None]:
    """Return a listener that also logs each frame, at the level DEBUG.

    Where nobody wants such messages, a frame costs one look at a level that ``logging`` keeps.
    """
    decoders = [ChannelDecoder(ids) for ids in channels]

    def log(captured: Captured) -> None:
        listen(captured)
        if LOGGER.isEnabledFor(logging.DEBUG):
            frame = captured.frame
            words = next(filter(None, (decoder.words(frame) for decoder in decoders)), "")
            arrow = ">" if captured.direction is Direction.SENT else "<"
            LOGGER.debug("%s %s %s", arrow, frame, words or describe_nmt(frame))

    return log
