"""Judges the SDO conversations in a recorded log, of any client with any device."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from conformance.logs.reading import Seen
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.decoding import decode_response
from conformance.sdo.describe import in_words
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.nmt import ALL_NODES, NmtCommand, NmtState, decode_nmt
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.rules import Level, Violation
from conformance.sdo.rules.channels import NMT_STOPPED

NMT = 0x000
ERROR_CONTROL_BASE = 0x700
STATE_BITS = 0x7F
NODE_IDS = range(1, 128)
# An answer that has not come within 100 ms before the client speaks again does not come: clients
# that wait for less are not met in the field. The shortest server time-out that is, is 25 ms.
PATIENCE = 0.1
SERVER_TIMEOUT = 0.02
# What an exchange of two frames begins and ends with. Those that are expedited carry a value.
EXPEDITED = frozenset((0x23, 0x27, 0x2B, 0x2F, 0x43, 0x47, 0x4B, 0x4F))
ASKING = frozenset((0x40, 0x23, 0x27, 0x2B, 0x2F))
ANSWERING = frozenset((0x43, 0x47, 0x4B, 0x4F, 0x60, 0x80))
MOST_EXCHANGES = 50_000
# The more requests a client sends ahead of the answers, the more ways there are in which a server
# may have gone on. These are the limits, on one channel and on all; only ways beyond the
# usual number count.
USUAL_EFFORT = 5
MOST_EFFORT = 4_000
MOST_EFFORT_OF_ALL = 20_000


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


@dataclass(frozen=True, slots=True)
class NotFollowed:
    """From this frame on nothing is judged on its channel until that has been quiet."""

    node_id: int
    seen: Seen


@dataclass(slots=True)
class Channel:
    """One default SDO channel: the oracle, what was seen last, and how much there was of it.

    ``asked`` is the request of an exchange that begins at rest; the oracle has not been told of it.
    ``effort`` is what following took beyond the usual; a channel that is ``out`` is not followed,
    ``not_judged`` counts its responses.
    """

    oracle: Oracle
    last: Seen | None = None
    requests: int = 0
    responses: int = 0
    asked: Seen | None = None
    effort: int = 0
    before: int = 0
    out: bool = False
    not_judged: int = 0

    def tell(self) -> None:
        """Tell the oracle of the request that waits for its answer."""
        if self.asked is not None:
            asked, self.asked = self.asked, None
            self.oracle.request(asked.frame)

    def is_in(self, seen: Seen) -> bool:
        """Say whether the channel is followed: again, once it was quiet before this frame."""
        if self.out and self.last is not None and seen.time - self.last.time >= PATIENCE:
            self.oracle.lose()
            self.oracle.settled()
            self.oracle.given_up = self.out = False
            self.effort = 0
        return not self.out


@dataclass(slots=True)
class Stopped:
    """A node that was told to stop, and when.

    ``owing`` says that an answer may have been on its way then, or that a transfer ended with an
    abort; ``asked`` that there was a request since.
    """

    since: float
    owing: bool
    asked: bool = False


class Exchanges:
    """Requests and answers, frame by frame, after which a channel was at rest as before.

    Most of a log are the same ones again and again, apart from the values in them, which are not
    known; of them nothing is left to find out.
    """

    def __init__(self) -> None:
        """Know none."""
        self._known: set[tuple[int, bytes, bytes]] = set()

    def has(self, channel: Channel, seen: Seen) -> bool:
        """Say whether what was asked and its answer are known."""
        asked = channel.asked
        if asked is None or not _is_one_of(ANSWERING, seen.frame):
            return False
        return (id(channel), _form(asked.frame.data), _form(seen.frame.data)) in self._known

    def add(self, channel: Channel, asked: Seen, seen: Seen) -> None:
        """Know an exchange."""
        if len(self._known) >= MOST_EXCHANGES:
            self._known.clear()
        if _is_one_of(ANSWERING, seen.frame):
            self._known.add((id(channel), _form(asked.frame.data), _form(seen.frame.data)))


def _is_one_of(commands: frozenset[int], frame: CanFrame) -> bool:
    ordinary = not frame.extended and not frame.remote and len(frame.data) == FRAME_LENGTH
    return ordinary and frame.data[0] in commands


def _form(data: bytes) -> bytes:
    """Return a frame without the bytes of a value."""
    if data[0] not in EXPEDITED:
        return data
    return data[:4] + data[FRAME_LENGTH - (data[0] >> 2 & 3) :]


@dataclass(slots=True)
class LogJudge:
    """Follows all default SDO channels of a log, frame by frame, each by its bus and its node.

    Nothing is known of the devices' objects, so the protocol is judged, and no value. A log may
    begin in the middle of a transfer, unless it ``begins_idle``.
    """

    channels: dict[tuple[str, int], Channel] = field(default_factory=dict)
    begins_idle: bool = False
    _effort: int = 0
    _exchanges: Exchanges = field(default_factory=Exchanges)
    _stopped: dict[tuple[str, int], Stopped] = field(default_factory=dict)
    _now: float = 0.0

    def take(self, seen: Seen) -> Iterator[Finding | NotFollowed]:
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

    def end(self, now: float = 0.0) -> Iterator[Finding]:
        """Yield which answers have not come though the log goes on for long enough, or until now.

        That is a time in seconds on the clock of the log.
        """
        self._now = max(self._now, now)
        for (_, node_id), channel in self.channels.items():
            last = channel.last
            if last is not None and self._now - last.time >= PATIENCE and not channel.out:
                yield from self._late(node_id, channel, last)

    def _request(self, node_id: int, seen: Seen) -> Iterator[Finding | NotFollowed]:
        channel = self._channel(seen.bus, node_id)
        stopped = self._stopped.get((seen.bus, node_id))
        if stopped is not None:
            stopped.asked = True
            channel.requests += 1
            return
        last = channel.last
        if channel.is_in(seen):
            if last is not None and seen.time - last.time >= PATIENCE:
                yield from self._late(node_id, channel, last)
            channel.tell()
            oracle = channel.oracle
            if oracle.awaited is Awaited.NOTHING and not oracle.in_sub_block:
                oracle.settled()
            if oracle.idle and _is_one_of(ASKING, seen.frame):
                channel.asked = seen
            else:
                oracle.request(seen.frame)
                yield from self._effort_of(node_id, channel, seen)
        channel.requests += 1
        channel.last = seen

    def _response(self, node_id: int, seen: Seen) -> Iterator[Finding | NotFollowed]:
        channel = self._channel(seen.bus, node_id)
        stopped = self._stopped.get((seen.bus, node_id))
        if stopped is not None:
            channel.responses += 1
            yield from self._in_stopped(node_id, stopped, seen)
            return
        channel.responses += 1
        if not channel.is_in(seen):
            channel.not_judged += 1
        else:
            if not self._exchanges.has(channel, seen):
                yield from self._judged(node_id, channel, seen)
            yield from self._effort_of(node_id, channel, seen)
        channel.asked = None
        channel.last = seen

    def _judged(self, node_id: int, channel: Channel, seen: Seen) -> Iterator[Finding]:
        oracle, last, asked = channel.oracle, channel.last, channel.asked
        channel.tell()
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
        if asked is not None and not findings and ended is None and oracle.idle:
            self._exchanges.add(channel, asked, seen)

    def _effort_of(self, node_id: int, channel: Channel, seen: Seen) -> Iterator[NotFollowed]:
        """Count what following a frame took; yield that a channel is no longer followed."""
        beyond = channel.oracle.effort - channel.before - USUAL_EFFORT
        channel.before = channel.oracle.effort
        channel.effort = max(0, channel.effort + beyond)
        self._effort = max(0, self._effort + beyond)
        too_much = channel.effort > MOST_EFFORT and self._effort > MOST_EFFORT_OF_ALL
        if channel.oracle.given_up or too_much:
            channel.out = True
            yield NotFollowed(node_id, seen)

    def _late(self, node_id: int, channel: Channel, last: Seen) -> Iterator[Finding]:
        channel.tell()
        for violation in channel.oracle.settled():
            yield Finding(node_id, last, violation)

    def _channel(self, bus: str, node_id: int) -> Channel:
        if (bus, node_id) not in self.channels:
            oracle = Oracle(node_id=node_id)
            if not self.begins_idle:
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
            rests = channel is None or (channel.oracle.idle and channel.asked is None)
            last = None if channel is None or rests else channel.last
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
            actual = in_words(decode_response(seen.frame.data))
            broken = Violation(NMT_STOPPED, expected="no answer in Stopped", actual=actual)
            yield Finding(node_id, seen, broken)

    def _restart(self, bus: str, node_id: int | None) -> None:
        """After a boot-up or an NMT command it is open where a server is."""
        for (near, found), channel in self.channels.items():
            if bus == near and node_id in (None, found) and not channel.out:
                channel.tell()
                channel.oracle.lose()
                channel.last = None
