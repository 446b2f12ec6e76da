"""What a case sends and receives, frame by frame, and what it finds on the way."""

import random
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Self

from conformance.bus.channel import Channel
from conformance.device.device import Device
from conformance.device.not_testable import NotTestable
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.must_serve import Served
from conformance.dialogue.payload import MOST_PLAIN, text
from conformance.dialogue.silence import Silence
from conformance.dialogue.wire import Wire
from conformance.sdo.block_client import BlockClient
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ResponseChecks
from conformance.sdo.decoding import as_answer
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort, Response, Unknown
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.rules import Cause, Violation
from conformance.sdo.seen import Seen


class InitiateRefused(Exception):
    """The server has refused to begin a transfer in the middle of another, and is idle.

    Which of the two its ``abort`` names is its choice.
    """

    def __init__(self, abort: Abort) -> None:
        super().__init__(in_words(abort))
        self.abort = abort


class Exchange:
    """Requests and responses of one case on one channel of a device.

    The ``wire`` has the frames, the ``silence`` proves that nothing was answered, and the
    ``record`` is what is known of the case. ``checks`` hold responses to what every response has to
    be, the ``client`` makes the requests of whole transfers.
    """

    def __init__(self, channel: Channel, device: Device, record: CaseRecord, seed: int) -> None:
        """``seed`` decides on the bytes that are written."""
        self.channel = channel
        self.device = device
        self.record = record
        self.wire = Wire(channel, device, record)
        self.silence = Silence(self.wire)
        self.line = self.wire.line
        self.checks = ResponseChecks(self.wire.note)
        self.client = BlockClient(self.checks, device.contents.longest)
        self._superseded: Multiplexer | None = None
        self._served = Served(self.wire)
        self._seed = f"{seed}/{record.rule.id}"

    def beside(self, channel: Channel) -> Self:
        """Return the same case on another channel of the device."""
        return type(self)(channel, self.device, self.record, 0)

    # Frames

    def send(self, request: Message | Unknown | bytes) -> None:
        """Send a request: a message, or 0 to 8 data bytes as they are.

        Raises WriteNotPermitted for one that would write where the user has not allowed it.
        """
        built = request if isinstance(request, Message) else None
        data = request if isinstance(request, bytes) else request.encode()
        self.silence.before(data)
        self.wire.send(data, built)

    def send_frame(self, frame: CanFrame) -> None:
        """Send any CAN frame, a request or not; raises NotTestable for one that the bus cannot."""
        self.wire.send_frame(frame)

    def receive(self) -> Response:
        """Return the next response, which has to come, read by the state in which it came.

        Raises Violation when none comes in time, or one that has not the shape of a response.
        """
        response = self.wire.receive()
        superseded, self._superseded = self._superseded, None
        if superseded is None or not isinstance(abort := as_answer(response), Abort):
            return response
        self.checks.abort(abort, None)
        served = self.behind_superseded(abort, superseded)
        if served is None:
            raise InitiateRefused(abort)
        return served

    @contextmanager
    def superseding(self) -> Iterator[None]:
        """Begin a transfer in the middle of another: its first answer may follow an abort of that.

        Raises InitiateRefused where there is only an abort.
        """
        self._superseded = self.line.open
        try:
            yield
        finally:
            self._superseded = None

    def behind_superseded(self, abort: Abort, superseded: Multiplexer) -> Response | None:
        """Return the answer to a new initiate that follows an abort of the superseded transfer.

        None where there is none: the server has refused the new one.
        """
        if abort.mux != superseded:
            return None
        response = self.wait(self.wire.waits.soon)
        if response is not None:
            self.info("the superseded transfer is aborted, and the new one is served")
        return response

    def served(self) -> Served:
        """Expect the server to refuse nothing of what is sent within."""
        return self._served

    def wait(self, seconds: float) -> Response | None:
        """Send nothing for a time; return the response that is due within it."""
        return self.wire.wait(seconds)

    def fence(self) -> list[Response]:
        """Read 1000h, and return what came before its answer."""
        return self.silence.fence()

    def reaction(self) -> Response | None:
        """Return the answer to what was sent last, or None when there was none.

        Ends the open transfer, if any, by an abort, so that the fence finds the server idle.
        Raises Violation when more than one answer came.
        """
        return self.silence.reaction()

    def drain(self) -> list[CanFrame]:
        """Return the responses that are there though nothing was asked."""
        return self.silence.drain()

    def end_transfer(self) -> None:
        """Abort the open transfer from the client's side; a server never answers that."""
        self.silence.end_transfer()

    # Findings

    def note(self, violation: Violation) -> None:
        """Keep a breach that does not stop a transfer."""
        self.wire.note(violation)

    def info(self, note: str) -> None:
        """Record what the device does where the specification says nothing."""
        self.record.notes.append(note)

    def breach(
        self, expected: str, actual: Seen | str, *, told_as: Cause | None = None
    ) -> Violation:
        """Build a breach of the case's rule; ``told_as`` is the defect behind it, if known."""
        return Violation(self.record.rule, expected=expected, actual=actual, told_as=told_as)

    @cached_property
    def _random(self) -> random.Random:
        return random.Random(self._seed)

    def payload(self, size: int) -> bytes:
        """Return printable bytes, others with every call and the same in every run.

        Raises NotTestable for what might be written elsewhere (see ``payload``).
        """
        nowhere = self.device.learned.nowhere
        if size > MOST_PLAIN and not nowhere:
            raise NotTestable(
                f"needs an object that the device lacks: a device may take some of the {size} "
                "bytes for requests, which have to name it; no read was refused so far"
            )
        return text(self._random, size, nowhere)
