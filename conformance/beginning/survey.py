"""What may be wrong with every answer of a device, and would hide all else: tried before the cases.

A device that answers aborts, or sends something behind a confirmation, answers the suite's own
tidying in every case. Each such habit is provoked once, on its own, so that it is named as what it
is and the cases can step round it. What is written is put back.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from conformance.beginning.adapting import find_cut
from conformance.beginning.longer import PADDINGS, find_longer, find_others
from conformance.beginning.states import look_where_it_writes, was_download_refused
from conformance.bus.errors import DeviceLost
from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.effort import SHORT_VALUE, THOUSANDS_OF_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.rule_families import INCIDENTAL
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import (
    end_missing,
    filled_up,
    not_stored,
    other_in_blocks,
    same_value,
    tail_kept,
)
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import as_answer
from conformance.sdo.describe import describe
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    DownloadInitiate,
    Request,
    UploadInitiate,
)
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH, LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.objects import DataType, Habits
from conformance.sdo.rules import Level, Rule, Violation
from conformance.sdo.rules.defects import EXPEDITED_NOT_STORED, NUMBER_NOT_STORED

SURVEY = Rule("run.habits", "", Level.MAY, "What a device does whatever it is asked.")
GONE = "it does not answer any more, not even a read of 1000h after an abort"
FIRST_SEEN = "the beginning of the run"
# Two lengths in bytes, of which a wrong count cannot turn one into the other.
SHORT, LONGER = 7, 15


def survey(sdo: Dialogue, brings_back: Callable[[], bool] | None = None) -> None:
    """Provoke what would hide all else, and add what is found to the causes, aside of any case.

    ``brings_back`` does that with a device that is lost; without it, what might lose it is left to
    the cases. Raises DeviceLost for one that is lost nevertheless.
    """
    refuses = False
    for probe in _probes(sdo.device, all_of_them=brings_back is not None):
        try:
            probe(sdo)
            sdo.end_transfer()
            sdo.silence.calm()
        except (Violation, ServerAborted) as error:
            # That the device does not serve this is for the cases to find.
            asked = sdo.wire.last_sent
            refuses |= was_download_refused(sdo)
            if sdo.silence.recover():
                continue
            if isinstance(error, Violation):
                sdo.wire.explain(error)
                sdo.note(error)
            if brings_back is not None and brings_back():
                break
            keep_aside(sdo)
            raise lost_early(sdo, asked) from error
    if refuses:
        look_where_it_writes(sdo)
    used: set[Multiplexer] = set()
    unstored: list[Violation] = []
    # What is found of one may let another take its place.
    while known := next((one for one in _used(sdo.device) if one.mux not in used), None):
        used.add(known.mux)
        try:
            if known.habits.beyond:
                continue
            if find_longer(sdo, known):
                find_others(sdo)
                continue
            _find_only_length(sdo, known)
            unstored += _find_remains(sdo, known)
            if any(one.habits.too_long for one in sdo.device.known.values()):
                _find_miscount(sdo, known)
            if sdo.device.learned.lengths[known.mux].least > SHORT_VALUE:
                ValueAccess(sdo).read_alike()  # on that hangs what it is used for
            find_cut(sdo, sdo.device.known[known.mux])
        except (Violation, ServerAborted, NotTestable, Unimplemented) as error:
            asked = sdo.wire.last_sent
            if not sdo.silence.recover():
                keep_aside(sdo)
                raise lost_early(sdo, asked) from error
    if unstored and len(unstored) == len(used):
        sdo.note(unstored[0])
    else:
        _find_unstored_number(sdo)
    keep_aside(sdo)


def lost_early(sdo: Dialogue, asked: Request, why: str = GONE) -> DeviceLost:
    """Describe a device that was lost before the first case, behind a request."""
    return DeviceLost(
        f"Node {sdo.device.node_id} was lost before the first case, after: {describe(asked)}. "
        f"What is wrong: {why}. Reset or power-cycle it; bus.log shows all that was sent to it."
    )


def keep_aside(sdo: Dialogue) -> None:
    """Add what was met before the first case to the causes: no case has failed for it yet."""
    for found in sdo.record.minor:
        if found.level is Level.MUST and found.rule not in INCIDENTAL:
            cause = sdo.record.cause_of(found, sdo.wire.last_sent)
            sdo.record.causes.add(cause, FIRST_SEEN, found, aside=True)


Probe = Callable[[Dialogue], None]


def _abort_while_idle(sdo: Dialogue) -> None:
    sdo.send(Abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR))


def _probes(device: Device, *, all_of_them: bool) -> list[Probe]:
    """Return what is tried; last, if at all, what a device may not answer any more behind."""
    probes = [_abort_while_idle, *_aborts_of_transfers(device), *_downloads(device)]
    if not all_of_them:
        return probes
    return probes + [
        _beginning(BlockDownloadInitiate.with_size(known.mux, len(device.values[known.mux])))
        for known in _written(device)
    ]


def _aborts_of_transfers(device: Device) -> list[Probe]:
    """Return what begins a transfer of each kind but a block download, to be aborted."""
    begun: list[Message] = []
    long = max(device.values, key=lambda mux: len(device.values[mux]), default=None)
    if long is not None and len(device.values[long]) > 4:
        begun += [UploadInitiate(long), BlockUploadInitiate(long, LARGEST_BLOCK)]
    for known in _written(device):
        size = len(device.values[known.mux])
        begun.append(DownloadInitiate.with_size(known.mux, size))
    probes = [_beginning(request) for request in begun]
    if long is not None and len(device.values[long]) > SEGMENT_LENGTH:
        probes.append(_sub_block_of_one(long))
    return [*probes, _block_upload_to_its_end(device)]


def _sub_block_of_one(mux: Multiplexer) -> Probe:
    """Ask for one segment of several: what comes behind it is met when the transfer is aborted."""

    def begin(sdo: Dialogue) -> None:
        sdo.send(BlockUploadInitiate(mux, 1))
        if isinstance(as_answer(sdo.receive()), BlockUploadInitiateResponse):
            sdo.send(BlockUploadStart())
            sdo.receive()

    return begin


def _block_upload_to_its_end(device: Device) -> Probe:
    """Read a value in a block: what comes behind the end is met then, and whether it is the same.

    Segments cost no requests, so it has several where that is to be had.
    """
    lengths = {mux: len(device.values[mux]) for mux in device.steady()}
    few = [mux for mux, length in lengths.items() if length <= SHORT_VALUE]
    target = max(few, key=lambda mux: lengths[mux], default=DEVICE_TYPE)

    def upload(sdo: Dialogue) -> None:
        with suppress(NotTestable, Unimplemented):
            found, due = Blocks(sdo).upload(target).data, device.values.get(target)
            known = device.known.get(target)
            if known is not None and due is not None and not same_value(known, found, due):
                _compare_with_blocks(sdo, known)

    return upload


def _compare_with_blocks(sdo: Dialogue, known: KnownObject) -> None:
    """Note that a block upload brings other data, unless the value has changed by itself."""
    before, found, after = sdo.upload(known), Blocks(sdo).upload(known).data, sdo.upload(known)
    if before == after and not same_value(known, found, before):
        sdo.note(other_in_blocks(known, before, found))


def _beginning(request: Message) -> Probe:
    def begin(sdo: Dialogue) -> None:
        sdo.send(request)
        sdo.receive()

    return begin


def _downloads(device: Device) -> list[Probe]:
    """Return downloads of the values that are there, by each protocol."""
    return [
        _downloading(known, segmented=segmented)
        for known in _written(device)
        for segmented in (None, True)
    ]


def _downloading(known: KnownObject, *, segmented: bool | None) -> Probe:
    return lambda sdo: sdo.download(known, sdo.device.values[known.mux], segmented=segmented)


def _written(device: Device) -> list[KnownObject]:
    """Return a number and the shortest string that may be written, where there are any."""
    writable = [known for known in Roles(device).all_writable() if device.values[known.mux]]
    numbers = [known for known in writable if known.length is not None]
    others = [known for known in writable if known.varies]
    shortest = sorted(others, key=lambda known: len(device.values[known.mux]))
    return [*numbers[:1], *shortest[:1]]


def _used(device: Device) -> list[KnownObject]:
    """Return the strings and domains that cases write to."""
    used: list[KnownObject] = []
    for choose in (Roles(device).variable, Roles(device).text):
        with suppress(NotTestable):
            used.append(choose())
    return used


def _find_only_length(sdo: Dialogue, known: KnownObject) -> None:
    """Find out whether an object with a long value takes no shorter ones.

    Cases on other things than length do without one that has many bytes whatever is written.
    """
    if SHORT_VALUE < len(sdo.device.values[known.mux]) <= THOUSANDS_OF_SEGMENTS:
        Room(sdo).fit(known, SHORT)


def _find_remains(sdo: Dialogue, known: KnownObject) -> list[Violation]:
    """Find out what a device leaves behind a value that is shorter than the one before.

    Returns the breach where that is the one before itself.
    """
    before = sdo.device.values[known.mux]
    if not before[SHORT:].strip(b"\0 "):
        before = sdo.payload(LONGER)
        sdo.download(known, before)
    due = sdo.payload(SHORT)
    sdo.download(known, due)
    found = _held_by(sdo, known)
    if 0 < len(found) < SHORT and due.startswith(found):
        _find_missing_end(sdo, known, SHORT - len(found))
    elif found.startswith(due + before[SHORT:]):
        sdo.device.learn(known, Habits(keeps_tails=True))
        lengths = sdo.device.learned.lengths[known.mux]
        lengths.lasting = lengths.most = len(found)
        sdo.note(tail_kept(known, due))
    elif found == sdo.device.values[known.mux] != due:
        return [not_stored(known, due)]
    elif len(found) > LONGER and found in [due.ljust(len(found), each) for each in PADDINGS]:
        _find_filled(sdo, known, len(found), found[-1:])
    return []


def _find_unstored_number(sdo: Dialogue) -> None:
    """Find out whether a device confirms writes to a number and stores none of them.

    In which way they are sent, tells whether it is about numbers or about expedited downloads.
    """
    known = next((one for one in _written(sdo.device) if one.length is not None), None)
    if known is None or known.length is None or known.length > EXPEDITED_LENGTH:
        return
    try:
        expedited, segmented = (_stores(sdo, known, segmented=how) for how in (False, True))
    except (Violation, ServerAborted):
        if not sdo.silence.recover():
            raise
        return
    if expedited is False and segmented is not None:
        unstored = EXPEDITED_NOT_STORED if segmented else NUMBER_NOT_STORED
        sdo.note(not_stored(known, _changed(sdo, known), unstored))


def _changed(sdo: Dialogue, known: KnownObject) -> bytes:
    before = sdo.device.values[known.mux]
    return bytes([before[0] ^ 1]) + before[1:]


def _stores(sdo: Dialogue, known: KnownObject, *, segmented: bool) -> bool | None:
    """Write another value to a number; say whether it is there, None where that does not tell."""
    before, due = sdo.device.values[known.mux], _changed(sdo, known)
    if sdo.try_download(known, due, segmented=segmented) is not None:
        return None
    found = sdo.upload(known)
    return found == due if found in (before, due) else None


def _held_by(sdo: Dialogue, known: KnownObject) -> bytes:
    """Read a value, in blocks where an ordinary upload of it is wrong: that is for the cases."""
    try:
        return sdo.upload(known)
    except Violation:
        sdo.end_transfer()
        return Blocks(sdo).upload(known).data


def _find_miscount(sdo: Dialogue, known: KnownObject) -> None:
    """Find out whether a value that comes in one answer reads longer or shorter than it is."""
    due = sdo.payload(1)
    sdo.download(known, due)
    found = sdo.upload(known)
    if found != due and due.ljust(EXPEDITED_LENGTH, b"\0").startswith(found):
        sdo.device.learn(known, replace(sdo.device.known[known.mux].habits, miscounted=True))


def _find_missing_end(sdo: Dialogue, known: KnownObject, count: int) -> None:
    """Find out whether the last ``count`` bytes of a value are never read.

    Two lengths of which only one fills its segments tell that from a wrong count in the last one.
    """
    due = sdo.payload(LONGER)
    sdo.download(known, due)
    if sdo.upload(known) == due[:-count]:
        sdo.device.learn(known, Habits(lacks=count))
        sdo.note(end_missing(known, due, count))


def _find_filled(sdo: Dialogue, known: KnownObject, length: int, padding: bytes) -> None:
    """Find out whether a device has one ``length`` for an object and fills up what is shorter.

    Two short values that read alike long tell that from a wrong count of their bytes. A string may
    be filled up with 00h; what a case stores there is as long as the object all the same.
    """
    due = sdo.payload(LONGER)
    sdo.download(known, due)
    found = sdo.upload(known)
    if found != due.ljust(length, padding):
        return
    habits = Habits(filled=length, padding=padding, cut=known.habits.cut)
    sdo.device.learn(known, habits)
    sdo.device.learned.lengths[known.mux].filled = length
    sdo.device.learned.lengths[known.mux].taken |= {SHORT, LONGER, length}
    if known.data_type is not DataType.VISIBLE_STRING and not habits.adapts:
        sdo.note(filled_up(known, due, found))
