"""Judges the SDO conversations in a recorded log, whoever held them with which device."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.oracle.follow import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.rules import Level, Violation

NMT = 0x000
ERROR_CONTROL_BASE = 0x700
BOOT_UP = b"\0"
# An answer that has not come within 100 ms before the client speaks again does not come: clients
# that wait for less are not met in the field. The shortest server time-out that is, is 25 ms.
PATIENCE = 0.1
SERVER_TIMEOUT = 0.02


@dataclass(frozen=True, slots=True)
class Seen:
    """A frame of the log: its number, from 1, its time in seconds, and the bus that it is from."""

    number: int
    time: float
    bus: str
    frame: CanFrame


@dataclass(frozen=True, slots=True)
class Finding:
    """What was wrong, at which frame: the response, or the request that got no answer."""

    node_id: int
    seen: Seen
    violation: Violation

    @property
    def is_failure(self) -> bool:
        """Whether it was not allowed: a breach of a SHOULD is."""
        return self.violation.level is Level.MUST


@dataclass(slots=True)
class Channel:
    """One default SDO channel: the oracle, what was seen last, and how much there was of it."""

    oracle: Oracle
    last: Seen | None = None
    requests: int = 0
    responses: int = 0


@dataclass(slots=True)
class LogJudge:
    """Follows all default SDO channels of a log, frame by frame, each by its bus and its node.

    Nothing is known of the devices' objects, so the protocol is judged, and no value.
    """

    channels: dict[tuple[str, int], Channel] = field(default_factory=dict)
    _now: float = 0.0

    def take(self, seen: Seen) -> Iterator[Finding]:
        """Take the next frame; yield what is wrong with it, or with the time before it."""
        self._now = seen.time
        frame = seen.frame
        node_id, function = frame.can_id & 0x7F, frame.can_id & ~0x7F
        if frame.can_id == NMT or self._is_boot_up(frame):
            self._restart(seen.bus, None if frame.can_id == NMT else node_id)
        elif node_id and function == REQUEST_BASE:
            yield from self._request(node_id, seen)
        elif node_id and function == RESPONSE_BASE:
            yield from self._response(node_id, seen)

    def end(self) -> Iterator[Finding]:
        """Yield which answers have not come though the log goes on for long enough."""
        for (_, node_id), channel in self.channels.items():
            last = channel.last
            if last is not None and self._now - last.time >= PATIENCE:
                yield from self._late(node_id, channel, last)

    def _request(self, node_id: int, seen: Seen) -> Iterator[Finding]:
        channel = self._channel(seen.bus, node_id)
        last = channel.last
        if last is not None and seen.time - last.time >= PATIENCE:
            yield from self._late(node_id, channel, last)
        elif channel.oracle.awaited is Awaited.NOTHING:
            channel.oracle.settled()
        channel.oracle.request(seen.frame)
        channel.requests += 1
        channel.last = seen

    def _response(self, node_id: int, seen: Seen) -> Iterator[Finding]:
        channel = self._channel(seen.bus, node_id)
        oracle, last = channel.oracle, channel.last
        pause = last is not None and seen.time - last.time >= SERVER_TIMEOUT
        if pause and oracle.awaited is Awaited.NOTHING:
            oracle.silence()
        for violation in oracle.response(seen.frame):
            yield Finding(node_id, seen, violation)
        channel.responses += 1
        channel.last = seen

    def _late(self, node_id: int, channel: Channel, last: Seen) -> Iterator[Finding]:
        for violation in channel.oracle.settled():
            yield Finding(node_id, last, violation)

    def _channel(self, bus: str, node_id: int) -> Channel:
        if (bus, node_id) not in self.channels:
            oracle = Oracle(node_id=node_id)
            # The log may begin in the middle of a transfer.
            oracle.lose()
            self.channels[bus, node_id] = Channel(oracle)
        return self.channels[bus, node_id]

    def _restart(self, bus: str, node_id: int | None) -> None:
        """After a boot-up or an NMT command it is open where a server is."""
        for (near, found), channel in self.channels.items():
            if bus == near and node_id in (None, found):
                channel.oracle.lose()

    def _is_boot_up(self, frame: CanFrame) -> bool:
        return frame.can_id & ~0x7F == ERROR_CONTROL_BASE and frame.data == BOOT_UP
