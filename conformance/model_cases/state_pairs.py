"""Two states in turn: what a server keeps of the first must not show in the transfer behind it.

Most of what a server knows of a transfer it keeps in variables that all transfers share: buffer,
position, size, toggle bit, sequence number. An initiate has to set each of them, and what one kind
of transfer leaves there another may find much later.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from conformance.device.device import DEVICE_TYPE, THREE_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.exchange import InitiateRefused
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.values import segments_of
from conformance.model_cases.lockstep import Lockstep, knowledge_of
from conformance.model_cases.server_states import (
    BLOCK_DOWNLOADS,
    BLOCK_UPLOADS,
    IDLE,
    SIZE,
    STATES,
    State,
)
from conformance.run.risks import Risk
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import INITIATES, Abort, Request
from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import Violation

AnyState = State[Request | None]
# So many objects are enough for any pair.
ENOUGH = 2


@dataclass(frozen=True, slots=True)
class Pair:
    """A state that the server leaves, and one through which its next transfer passes."""

    first: AnyState
    second: AnyState


def risk_in(pair: Pair) -> Risk | None:
    """Return what a server may not survive on the way into either state."""
    return pair.first.risk or pair.second.risk


def _pairs(firsts: Iterable[AnyState]) -> dict[str, Pair]:
    return {
        f"{first.name}-then-{second.name}": Pair(first, second)
        for first in firsts
        for second in STATES.values()
    }


BEHIND_ABORT: Mapping[str, Pair] = _pairs(STATES.values())
"""All pairs: an abort of the client leads out of each state, and changes nothing when idle."""
SUPERSEDED: Mapping[str, Pair] = _pairs(
    state for state in STATES.values() if state is not IDLE and state.segment is None
)
"""The pairs of which a new initiate leads out of the first: not where it would be a segment."""
BESIDE: Mapping[str, Pair] = {
    f"{pair.first.name}-beside-{pair.second.name}": pair
    for pair in BEHIND_ABORT.values()
    if pair.first is not IDLE
}
"""The pairs of which the first lasts while another channel passes the second."""


@dataclass(frozen=True, slots=True)
class Target:
    """An object, and of how many bytes its transfers are."""

    known: KnownObject
    size: int


def perform_pair(pair: Pair, sdo: Dialogue, *, superseding: bool) -> None:
    """Lead the server into the first state, out of it, and by another transfer into the second.

    That is done three times. The other transfer is about another object, then about the same, and
    goes on to its end; at last the client aborts it where it is. The objects are read each time.
    What a server may do with all this the oracle knows, which follows it.

    The first transfer ends by an abort of the client, or the other is ``superseding`` it. Raises
    Violation, NotTestable and Unimplemented.
    """
    _require_blocks(pair, sdo)
    firsts, seconds = _targets(sdo, pair.first), _targets(sdo, pair.second)
    one = next((each for each in firsts if each in seconds), firsts[0])
    other = next((each for each in seconds if each != one), one)
    same = one if one in seconds else other
    client = _Client(sdo, {one.known, other.known})
    walk = _Walk(pair, client, superseding=superseding)
    with client.lockstep.following():
        walk.perform(one, other)
        if same != other:
            walk.perform(one, same)
        if pair.second is not IDLE:
            walk.perform(one, same, to_the_end=False)


def perform_beside(pair: Pair, sdo: Dialogue, other: Dialogue) -> None:
    """Let a transfer wait in the first state while the ``other`` channel passes the second.

    Each transfer is about an object of its own, and goes on to its end; then they are read. The
    oracle follows each channel. Raises Violation, NotTestable and Unimplemented.
    """
    _require_blocks(pair, sdo)
    one = _targets(sdo, pair.first)[0]
    another = next((each for each in _targets(sdo, pair.second) if each.known != one.known), None)
    if another is None:
        raise NotTestable(f"needs another string or domain than {one.known}: name a second one")
    waiting, passing = _Client(sdo, {one.known}), _Client(other, {another.known})
    with waiting.lockstep.following(), passing.lockstep.following():
        waiting.fill(one)
        passing.fill(another)
        rest = waiting.way(pair.first, one)
        next(rest)
        waiting.lockstep.check()
        passing.go_on(passing.way(pair.second, another))
        waiting.go_on(rest)
        waiting.read(one)
        passing.read(another)


def _require_blocks(pair: Pair, sdo: Dialogue) -> None:
    names = {pair.first.name, pair.second.name}
    if not names.isdisjoint(BLOCK_DOWNLOADS):
        Blocks(sdo).require_download()
    if not names.isdisjoint(BLOCK_UPLOADS):
        Blocks(sdo).require_upload()


def _targets(sdo: Dialogue, state: AnyState) -> list[Target]:
    """Return objects for transfers into a state: strings, domains, and for uploads what is long."""
    roles, room = Roles(sdo.device), Room(sdo)
    if state.downloads:
        roles.text()  # which says what is lacking where there is none
    found: list[Target] = []
    lacking: list[NotTestable] = []
    for known in roles.varying():
        try:
            found.append(Target(known, room.fit(known, SIZE, state.least)))
        except NotTestable as why:
            lacking.append(why)
    if not state.downloads and len(found) < ENOUGH:
        found += sorted(_long_constants(sdo), key=lambda target: target.size)
    if found:
        return found
    if lacking:
        raise lacking[0]
    known, value = room.long_object()
    return [Target(known, len(value))]


def _long_constants(sdo: Dialogue) -> Iterator[Target]:
    for known in sdo.device.objects:
        size = len(sdo.device.values.get(known.mux, b""))
        if not known.access.writable and known.is_steady and size >= THREE_SEGMENTS:
            yield Target(known, size)


class _Client:
    """A client on one channel, whose transfers the oracle follows."""

    def __init__(self, sdo: Dialogue, objects: Iterable[KnownObject]) -> None:
        """Take the ``objects`` that the transfers are about."""
        self.sdo = sdo
        device = sdo.device
        self._held = {known.mux: device.contents.value(known.mux) for known in objects}
        surely = {mux: device.learned.lengths[mux].surely for mux in self._held}
        capacity = {mux: size for mux, size in surely.items() if size is not None}
        self.lockstep = Lockstep(sdo, Oracle(knowledge_of(device, capacity), device.node_id))

    def fill(self, target: Target) -> None:
        """Write an object that does not read in as many segments as the transfers count on."""
        held = self._held[target.known.mux]
        if held is not None and len(segments_of(held)) == len(segments_of(bytes(target.size))):
            return
        data = self.sdo.payload(target.size)
        Room(self.sdo).store(target.known, data, segmented=True)
        self._held[target.known.mux] = data
        self.lockstep.check()

    def way(self, state: AnyState, target: Target) -> Iterator[object]:
        """Return the way through a state; when idle that is a short transfer."""
        if state is IDLE:
            return self._short_transfer()
        return state.way(self.sdo, target.known, target.size)

    def _short_transfer(self) -> Iterator[None]:
        """Ask for what is answered in one frame: the server is idle again then."""
        self.sdo.upload(DEVICE_TYPE)
        yield None

    def go_on(self, rest: Iterator[object]) -> None:
        """Go what is left of a way."""
        for _ in rest:
            pass
        self.lockstep.check()

    def abort(self, target: Target) -> None:
        """End the transfer of an object."""
        abort = Abort(target.known.mux, AbortCode.GENERAL_ERROR)
        self.lockstep.send(self.sdo.channel.ids.request.frame(abort.encode()))
        self.lockstep.check()

    def read(self, target: Target) -> None:
        """Read an object, which holds what the oracle expects."""
        self._held[target.known.mux] = self.sdo.upload(target.known)
        self.lockstep.check()


class _Walk:
    """The way of one pair on one channel."""

    def __init__(self, pair: Pair, client: _Client, *, superseding: bool) -> None:
        self._pair = pair
        self._client = client
        self._superseding = superseding

    def perform(self, one: Target, another: Target, *, to_the_end: bool = True) -> None:
        """Go by a transfer of one object into the first state, and by another into the second."""
        client, first = self._client, self._pair.first
        for target in (one, another):
            client.fill(target)
        first.reach(client.sdo, one.known, one.size)
        client.lockstep.check()
        if not self._superseding:
            client.abort(one)
        rest = self._begin(another, is_cut=first.downloads and another == one)
        if to_the_end:
            client.go_on(rest)
        else:
            client.abort(another)
        for target in dict.fromkeys((one, another)):
            client.read(target)

    def _begin(self, target: Target, *, is_cut: bool) -> Iterator[object]:
        """Lead the server into the second state; return what goes on from there.

        Where it refuses, and may, to begin a transfer in the middle of another, it begins when that
        is over. Nothing goes on where the object ``is_cut``: some servers keep what came of a
        download that was aborted, which may be too short for an upload with this state.
        """
        client, second = self._client, self._pair.second
        way = client.way(second, target)
        try:
            with client.sdo.superseding():
                next(way)
        except InitiateRefused:
            client.lockstep.check()
            client.lockstep.settle(target.known.mux)
            way = client.way(second, target)
            next(way)
        except (Violation, NotTestable):
            if self._superseding and isinstance(client.sdo.wire.last_sent, INITIATES):
                with client.sdo.one_transfer():
                    raise
            if not is_cut:
                raise
            client.lockstep.check()
            client.lockstep.settle(target.known.mux)
            way = iter(())
        client.lockstep.check()
        return way
