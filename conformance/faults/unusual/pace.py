"""Nodes that are right and slow: with each frame, or with one kind of request."""

from functools import partial

from conformance.faults import registry
from conformance.faults.own_clock import OneByOne
from conformance.faults.registry import About
from conformance.reference.server import BlockDownload
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import BlockEnd, DownloadInitiate, DownloadSegment, Request
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.storage_commands import SIGNATURES

unusual = partial(registry.unusual, about=About.TIME)
# What only some objects are stored in, of those of the built-in device.
IN_EEPROM = frozenset((0x2002, 0x2004, 0x2010, 0x2011))


class _SlowWith(OneByOne):
    """Takes its time for what is no segment of a sub-block."""

    def seconds_for(self, frame: CanFrame) -> float:
        """Look at the request in the state in which it comes."""
        if len(frame.data) != FRAME_LENGTH:
            return 0.0
        channel = next(
            (each for each in self.channels if each.record.request.can_id == frame.can_id), None
        )
        transfer = None if channel is None else channel.server.transfer
        if isinstance(transfer, BlockDownload) and not transfer.ended:
            return self.seconds_for_segment()
        running = getattr(transfer, "mux", None)
        return self.seconds_for_request(decode_request(frame.data), running)

    def seconds_for_segment(self) -> float:
        """Return how long a segment of a block takes."""
        return 0.0

    def seconds_for_request(self, request: Request, running: Multiplexer | None) -> float:
        """Return how long a request takes; ``running`` is the object of the transfer."""
        del request, running
        return 0.0


@unusual("each-frame-takes-10-ms")
class EachFrame(OneByOne):
    """Looks at its mailbox every 10 ms, and has room there for all that comes meanwhile."""

    def seconds_for(self, frame: CanFrame) -> float:
        """Take as long for each."""
        del frame
        return 0.01


@unusual("each-segment-of-a-burst-takes-10-ms")
class SlowBursts(_SlowWith):
    """Takes 10 ms for each segment of a block download: 1.27 s for 127 that come at once."""

    def seconds_for_segment(self) -> float:
        """Take as long for each."""
        return 0.01


@unusual("writes-of-some-objects-take-300-ms")
class SlowWrites(_SlowWith):
    """Stores some objects in an EEPROM, which takes 300 ms, and answers then."""

    def seconds_for_request(self, request: Request, running: Multiplexer | None) -> float:
        """Take as long for what writes."""
        match request:
            case DownloadInitiate() if request.expedited:
                running = request.mux
            case DownloadSegment() if request.last:
                pass
            case BlockEnd():
                pass
            case _:
                return 0.0
        return 0.3 if running is not None and running.index in IN_EEPROM else 0.0


@unusual("storing-takes-3-s")
class SlowStoring(_SlowWith):
    """Takes 3 s to store its parameters and to load its defaults, and answers then."""

    def seconds_for_request(self, request: Request, running: Multiplexer | None) -> float:
        """Take as long for a signature."""
        del running
        if not isinstance(request, DownloadInitiate) or not request.expedited:
            return 0.0
        return 3.0 if request.data == SIGNATURES.get(request.mux) else 0.0
