"""One field of the matrix: lead the server into a state, send one frame, judge what follows."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

from conformance.device.device import DEVICE_TYPE, TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import same_value
from conformance.model_cases.lockstep import Lockstep, knowledge_of
from conformance.model_cases.matrix.stimuli import Stimulus, Targets
from conformance.model_cases.server_states import BLOCK_DOWNLOAD_BETWEEN, SIZE, State
from conformance.model_cases.ways_to_states import LONGEST
from conformance.sdo.describe import shown
from conformance.sdo.frames import DownloadSegment, RemoteFrame, Request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import IDLE_AFTERWARDS, Violation
from conformance.sdo.rules.defects import CHANGED_UNASKED
from conformance.sdo.rules.short_requests import SHORT_REQUEST_RULES
from conformance.sdo.seen import Data

AnyState = State[Request | None]
CUT_SHORT = frozenset(rule.id for rule in SHORT_REQUEST_RULES)


def perform_stimulus(
    state: AnyState, stimulus: Stimulus, sdo: Dialogue, known: KnownObject
) -> None:
    """Judge the reaction to a stimulus, the value that ``known`` has then, and the next transfers.

    ``known`` is a writable string; where it is too short for the state, another string or a domain
    takes its place. It is written before only if it does not hold a value that suits the state, and
    read afterwards only if anything was sent that might write to it. The oracle follows from the
    first frame on. Raises Violation, NotTestable and Unimplemented.
    """
    missing = missing_object(sdo)
    missing_entry = _missing_entry(sdo, missing)
    known, size = _suited(sdo, known, state)
    targets = Targets(sdo.device.node_id, known.mux, missing, missing_entry, sdo.device.device_type)
    with ExitStack() as following:
        try:
            lockstep = following.enter_context(_led_into(state, sdo, known, size, targets))
        except Violation as breach:
            if not _has_changed_unasked(sdo, known, breach):
                raise
            Room(sdo).restore_own(known)
            lockstep = following.enter_context(_led_into(state, sdo, known, size, targets))
        lockstep.send(stimulus(targets), point=True)
        # What a server keeps of data that are not due it may store when it is aborted.
        stray = (
            isinstance(sdo.wire.last_sent, DownloadSegment | RemoteFrame) and not state.downloads
        )
        try:
            lockstep.settle(known.mux, abort=stray)
        except Violation as behind:
            sdo.record.own.add(behind)  # the frame was answered; what follows comes of it
            raise
        if any(found.rule.id in CUT_SHORT for found in sdo.record.minor):
            Room(sdo).restore_own(known)  # what it holds now is for no case to read
        elif known.mux not in sdo.device.contents.current:
            ValueAccess(sdo).read(known)
            lockstep.check()


def _missing_entry(sdo: Dialogue, missing: Multiplexer) -> Multiplexer:
    """Return a sub-index that an object lacks, of 1000h if possible.

    That a device serves any there is for other cases to say; it is not asked again.
    """
    if DEVICE_TYPE.index not in sdo.device.learned.all_entries:
        with suppress(Violation):
            return missing_sub_index(sdo, DEVICE_TYPE.index)
    return Multiplexer(missing.index, 1)


@contextmanager
def _led_into(
    state: AnyState, sdo: Dialogue, known: KnownObject, size: int, targets: Targets
) -> Iterator[Lockstep]:
    """Lead the server into a state by an object, which is written before if it has to be."""
    surely = sdo.device.learned.lengths[known.mux].surely
    capacity = {} if surely is None else {known.mux: surely}
    knowledge = knowledge_of(sdo.device, capacity, targets.there)
    lockstep = Lockstep(sdo, Oracle(knowledge, sdo.device.node_id))
    with lockstep.following():
        if not _suits(sdo.device.contents.value(known.mux), known, state, size):
            wanted = size if state.uploads else min(size, SEGMENT_LENGTH)
            Room(sdo).store(known, sdo.payload(wanted), segmented=True)
        state.reach(sdo, known, size)
        lockstep.check()
        yield lockstep


def _has_changed_unasked(sdo: Dialogue, known: KnownObject, breach: Violation) -> bool:
    """Say whether an object holds another value than it was left with, and note that.

    What a case has sent that is no download may have changed it when that was over.
    """
    believed = sdo.device.contents.value(known.mux)
    if believed is None or known.mux in sdo.record.written or sdo.record.early.met is not None:
        return False
    if not sdo.silence.recover():
        return False
    found = sdo.upload(known)
    if same_value(known, found, believed):
        return False
    sdo.device.contents.will_change(known.mux)
    sdo.record.written.add(known.mux)
    changed = Violation(
        IDLE_AFTERWARDS,
        expected=f"{known} to read as it was left: {shown(believed)}",
        actual=Data(found, remark=f"; met as: {breach}"),
        told_as=CHANGED_UNASKED,
    )
    sdo.note(changed)
    return True


def _suits(value: bytes | None, known: KnownObject, state: AnyState, size: int) -> bool:
    """Say whether an object holds what a transfer into a state needs, or what is quickly read."""
    if value is None:
        return False
    if not state.uploads:
        return len(value) <= SEGMENT_LENGTH or known.habits.filled > 0
    return len(value) == size


def _suited(sdo: Dialogue, known: KnownObject, state: AnyState) -> tuple[KnownObject, int]:
    """Return an object that takes a transfer into a state, and of how many bytes that is."""
    lacking = []
    for candidate in _candidates(sdo, known):
        try:
            return candidate, _size(sdo, candidate, state)
        except NotTestable as found:
            lacking.append(found)
    if state is BLOCK_DOWNLOAD_BETWEEN:
        return known, LONGEST  # the server may ask for less than a sub-block can have
    raise lacking[0]


def _candidates(sdo: Dialogue, known: KnownObject) -> Iterator[KnownObject]:
    """Yield an object, then all others that may take its place."""
    yield known
    for other in Roles(sdo.device).varying():
        if other.mux != known.mux:
            yield other


def _size(sdo: Dialogue, known: KnownObject, state: AnyState) -> int:
    room = Room(sdo)
    if state is BLOCK_DOWNLOAD_BETWEEN:
        room.need(known, LONGEST)
        return LONGEST
    if known.habits.filled and state.uploads:
        return known.habits.filled
    if state.short and room.has(known, TWO_SEGMENTS):
        return TWO_SEGMENTS
    try:
        room.need(known, SIZE)
    except NotTestable:
        size = room.fit(known, SIZE, state.least)
        if known.mux in sdo.record.written:
            room.restore_own(known)
        return size
    return SIZE
