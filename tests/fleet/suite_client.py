"""The suite's own client on a bus: every response is held to everything that the protocol says."""

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import BlockClient, Burst, Step
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.frames import Response
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer
from conformance.sdo.stepping import Ended, Result, advance

RESPONSE_TIMEOUT = 5.0
# The bit of the last segment.
MARKED = 0x80


@dataclass(frozen=True, slots=True)
class SuiteClient:
    """The reference client, strict in everything, on the channel of one device."""

    channel: Channel
    client: BlockClient = field(default_factory=BlockClient)

    def upload(self, mux: Multiplexer) -> Uploaded:
        """Read an object."""
        return self._run(self.client.upload(mux))

    def download(
        self, mux: Multiplexer, data: bytes, *, segmented: bool | None = None, sized: bool = True
    ) -> None:
        """Write an object."""
        self._run(self.client.download(mux, data, segmented=segmented, sized=sized))

    def block_upload(
        self, mux: Multiplexer, *, block_size: int = 127, crc: bool = True
    ) -> Uploaded:
        """Read an object in blocks."""
        return self._run(self.client.block_upload(mux, block_size=block_size, crc=crc))

    def block_download(
        self, mux: Multiplexer, data: bytes, *, sized: bool = True, crc: bool = True
    ) -> None:
        """Write an object in blocks."""
        self._run(self.client.block_download(mux, data, sized=sized, crc=crc))

    def refusal(self, transfer: Generator[Step, Response, object]) -> AbortCode:
        """Run a transfer that the server has to abort; return with which code."""
        try:
            result = self._run(transfer)
        except ServerAborted as aborted:
            return AbortCode(aborted.abort.code)
        raise AssertionError(f"the server did not abort: {result!r}")

    def exchange(self, request: Message) -> bytes:
        """Send one request and return the data bytes of the answer."""
        self.channel.send(request)
        frame = self.channel.receive()
        assert frame is not None, f"no answer to {request}"
        return frame.data

    def _run(self, transfer: Generator[Step, Response, Result]) -> Result:
        step = advance(transfer)
        while not isinstance(step, Ended):
            burst = step if isinstance(step, Burst) else Burst((step,))
            for request in burst.requests:
                self.channel.send(request)
            step = advance(transfer, self._answer(burst) if burst.awaited else None)
        return step.result

    def _answer(self, burst: Burst) -> Response:
        frame = self.channel.receive()
        assert frame is not None, f"no answer to {burst}"
        if not burst.segments:
            return decode_response(frame.data)
        for segment in self.channel.take_arrived(burst.segments - 1, is_inner_segment):
            burst.more.append(decode_segment(segment.data))
        return decode_segment(frame.data)


def is_inner_segment(frame: CanFrame) -> bool:
    """Say whether this is a segment with another behind it, if any is due."""
    return len(frame.data) == FRAME_LENGTH and frame.data[0] < MARKED


@contextmanager
def suite_client(channel: str, node_id: int) -> Iterator[SuiteClient]:
    """Open a channel of the virtual bus for our client."""
    settings = BusSettings("virtual", channel)
    link = Link(open_bus(settings), str(settings))
    try:
        yield SuiteClient(Channel(link, node_id, RESPONSE_TIMEOUT))
    finally:
        link.close()
