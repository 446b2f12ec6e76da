"""Judges the SDO conversations in a recorded log, whoever held them with which device."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from conformance.recorded_logs import Seen
from conformance.sdo.describe import describe_response
from conformance.sdo.nmt import ALL_NODES, NmtCommand, NmtState, decode_nmt
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.oracle.follow import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.rules import Level, Violation, rule_of

NMT = 0x000
ERROR_CONTROL_BASE = 0x700
STATE_BITS = 0x7F
NODE_IDS = range(1, 128)
# An answer that has not come within 100 ms before the client speaks again does not come: clients
# that wait for less are not met in the field. The shortest server time-out that is, is 25 ms.
PATIENCE = 0.1
SERVER_TIMEOUT = 0.02
NMT_STOPPED = rule_of("nmt.stopped")


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
class Stopped:
    """A node that was told to stop, and when.

    ``owing`` says that an answer may have been on its way then, or that a transfer ended with an
    abort; ``asked`` that there was a request since.
    """

    since: float
    owing: bool
    asked: bool = False


@dataclass(slots=True)
class LogJudge:
    """Follows all default SDO channels of a log, frame by frame, each by its bus and its node.

    Nothing is known of the devices' objects, so the protocol is judged, and no value.
    """

    channels: dict[tuple[str, int], Channel] = field(default_factory=dict)
    _stopped: dict[tuple[str, int], Stopped] = field(default_factory=dict)
    _now: float = 0.0

    def take(self, seen: Seen) -> Iterator[Finding]:
        """Take the next frame; yield what is wrong with it, or with the time before it."""
        self._now = seen.time
        frame = seen.frame
        node_id, function = frame.can_id & 0x7F, frame.can_id & ~0x7F
        if frame.can_id == NMT:
            self._command(seen)
        elif function == ERROR_CONTROL_BASE and frame.dlc == 1 and not frame.remote:
            self._told(seen.bus, node_id, frame.data[0] & STATE_BITS)
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
        stopped = self._stopped.get((seen.bus, node_id))
        if stopped is not None:
            stopped.asked = True
            channel.requests += 1
            return
        last = channel.last
        if last is not None and seen.time - last.time >= PATIENCE:
            yield from self._late(node_id, channel, last)
        elif channel.oracle.awaited is Awaited.NOTHING and not channel.oracle.in_sub_block:
            channel.oracle.settled()
        channel.oracle.request(seen.frame)
        channel.requests += 1
        channel.last = seen

    def _response(self, node_id: int, seen: Seen) -> Iterator[Finding]:
        channel = self._channel(seen.bus, node_id)
        oracle, last = channel.oracle, channel.last
        stopped = self._stopped.get((seen.bus, node_id))
        if stopped is not None:
            channel.responses += 1
            yield from self._in_stopped(node_id, stopped, seen)
            return
        pause = last is not None and seen.time - last.time >= SERVER_TIMEOUT
        if pause and oracle.awaited is Awaited.NOTHING:
            oracle.silence()
        findings = oracle.response(seen.frame)
        ended = oracle.ended
        if ended is not None and not ended.refusal:
            # It may do so at any time; whether it does so every time no log can tell.
            findings = [found for found in findings if found is not ended.violation]
        for violation in findings:
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

    # Network management: what a node may send depends on the state that it was told to enter

    def _command(self, seen: Seen) -> None:
        """Follow an NMT command; of a frame that is none it is open what a node makes of it."""
        message = decode_nmt(seen.frame)
        if message is None:
            self._restart(seen.bus, None)
            return
        addressed = None if message.node_id == ALL_NODES else message.node_id
        if message.command is NmtCommand.STOP:
            self._stop(seen, addressed)
        else:
            self._go_on(seen.bus, addressed)
        self._restart(seen.bus, addressed)

    def _stop(self, seen: Seen, node_id: int | None) -> None:
        node_ids = NODE_IDS if node_id is None else (node_id,)
        for each in node_ids:
            channel = self.channels.get((seen.bus, each))
            last = None if channel is None or channel.oracle.idle else channel.last
            owing = last is not None and seen.time - last.time < PATIENCE
            self._stopped.setdefault((seen.bus, each), Stopped(seen.time, owing))

    def _go_on(self, bus: str, node_id: int | None) -> None:
        for each in NODE_IDS if node_id is None else (node_id,):
            self._stopped.pop((bus, each), None)

    def _told(self, bus: str, node_id: int, state: int) -> None:
        """Follow what a node says of its state: one that runs was not told, or does not obey."""
        if state != NmtState.STOPPED:
            self._go_on(bus, node_id)
        if state == NmtState.INITIALISING:
            self._restart(bus, node_id)

    def _in_stopped(self, node_id: int, stopped: Stopped, seen: Seen) -> Iterator[Finding]:
        """Yield that a node answers in Stopped, unless it ended what was running before."""
        owing, stopped.owing = stopped.owing, False
        if stopped.asked and not (owing and seen.time - stopped.since < PATIENCE):
            actual = describe_response(seen.frame.data)
            broken = Violation(NMT_STOPPED, expected="no answer in Stopped", actual=actual)
            yield Finding(node_id, seen, broken)

    def _restart(self, bus: str, node_id: int | None) -> None:
        """After a boot-up or an NMT command it is open where a server is."""
        for (near, found), channel in self.channels.items():
            if bus == near and node_id in (None, found):
                channel.oracle.lose()
                channel.last = None
