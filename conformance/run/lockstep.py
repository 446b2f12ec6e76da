"""A conversation with a device in lockstep with the oracle, which judges each of its responses."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from conformance.bus.link import Captured, Direction
from conformance.device.device import Device
from conformance.run.dialogue import Dialogue
from conformance.run.verdict import INCIDENTAL
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle import Awaited, Facts, Knowledge, Oracle, Presence
from conformance.sdo.rules import Level, Violation


def knowledge_of(
    device: Device, capacity: dict[Multiplexer, int], about: Iterable[Multiplexer] | None = None
) -> Knowledge:
    """Return what the oracle may take for granted of a device's objects.

    ``capacity`` has the bytes for which strings and domains surely have room. ``about`` are the
    objects that the conversation may name; None for all.
    """
    return Knowledge(
        {
            mux: Facts(
                Presence.PRESENT,
                known.access,
                known.data_type,
                device.values.get(mux),
                steady=known.is_steady and mux in device.values,
                capacity=capacity.get(mux),
            )
            for mux in (device.known if about is None else about)
            if (known := device.known.get(mux)) is not None
        }
    )


class Lockstep:
    """Shows the oracle every frame that goes over the channel, and keeps what it finds."""

    def __init__(self, sdo: Dialogue, oracle: Oracle) -> None:
        """Start with an idle server."""
        self.oracle = oracle
        self._sdo = sdo
        self._findings: list[Violation] = []

    @contextmanager
    def following(self) -> Iterator[None]:
        """Follow what is sent and received from here on."""
        link = self._sdo.channel.link
        link.listen(self._take)
        try:
            yield
        finally:
            link.ignore(self._take)

    def _take(self, captured: Captured) -> None:
        if captured.direction is Direction.SENT:
            self.oracle.observe(captured.frame)
        elif captured.frame.can_id == self._sdo.channel.response_id:
            self._findings += self.oracle.response(captured.frame)

    def send(self, frame: CanFrame) -> list[bytes]:
        """Send any frame, take the answers that have to come, and return their data bytes."""
        answers = []
        if frame == CanFrame(self._sdo.channel.request_id, frame.data):
            self._sdo.send(frame.data)  # which knows whether it is a segment of a block
        else:
            self._sdo.send_frame(frame)
        while self.oracle.awaited is Awaited.ANSWER:
            answer = self._sdo.next_frame()
            if answer is None:
                self._findings += self.oracle.settled()
            self.check()
            if answer is not None:
                self._sdo.tracker.response(answer.data)
                answers.append(answer.data)
        return answers

    def has_left(self) -> bool:
        """Say whether the server has left the sub-block that is being sent."""
        return self._sdo.has_left()

    def settle(self, mux: Multiplexer) -> None:
        """Abort what may be open, and prove by a fence that nothing more comes."""
        self._sdo.send(Abort(mux, AbortCode.GENERAL_ERROR))
        try:
            self._sdo.fence()
        except Violation:
            self.check()
            raise
        self._findings += self.oracle.settled()
        self.check()

    def check(self) -> None:
        """Raise the first breach found that fails a device; note the others."""
        findings, self._findings = self._findings, []
        for found in findings:
            if found.level is Level.MUST and found.rule not in INCIDENTAL:
                raise found
            self._sdo.minor.append(found)
