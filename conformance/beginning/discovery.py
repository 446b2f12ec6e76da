"""The beginning of a run: does the node answer, what is it, what do the named objects hold?"""

from collections.abc import Callable
from functools import partial

from conformance.beginning.baseline import record_baseline
from conformance.beginning.first_reading import FirstReading, in_order
from conformance.beginning.states import learn_refusal, look_where_it_reads
from conformance.beginning.survey import GONE, keep_aside, lost_early
from conformance.beginning.two_devices import examine, look_for_second
from conformance.beginning.whole_reading import TooLong, read_whole
from conformance.bus.channel import Channel
from conformance.device.device import (
    DEVICE_TYPE,
    IDENTITY_COUNT,
    IDENTITY_NAMES,
    TEXTS,
    Device,
)
from conformance.device.effort import MOST_LOSSES
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Reason, Unread
from conformance.device.not_testable import Unimplemented
from conformance.device.object_roles import Roles
from conformance.device.serving import BY_STATE, Service
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.causes import Causes
from conformance.dialogue.changing import may_change, take_as_changing
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.payload import PRINTABLE_OBJECTS
from conformance.dialogue.transfers import EXISTS
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import decode_response
from conformance.sdo.describe import describe
from conformance.sdo.emergency import is_error_place
from conformance.sdo.frames import UploadInitiate, UploadSegment
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.rules import (
    IDLE_AFTERWARDS,
    NOT_REFUSED,
    UNSOLICITED,
    Level,
    Rule,
    Violation,
)
from conformance.sdo.rules.defects import ANSWERS_TWICE, FIRST_TWICE, IS_BEHIND
from conformance.sdo.seen import NoAnswer, Received, abort_in

# Reserved (CiA 301, 7.4.1).
NEVER_THERE = Multiplexer(0x0F00)
ASTRAY = (AbortCode.COMMAND_NOT_VALID, AbortCode.TOGGLE_NOT_ALTERNATED)
_MANDATORY = (
    KnownObject(DEVICE_TYPE, DataType.UNSIGNED32, Access.CONST),
    *(
        KnownObject(
            Multiplexer(IDENTITY_COUNT.index, sub_index),
            DataType.UNSIGNED32 if sub_index else DataType.UNSIGNED8,
            Access.CONST,
        )
        for sub_index in (0, *IDENTITY_NAMES)
    ),
    *(KnownObject(mux, DataType.VISIBLE_STRING, Access.CONST) for mux in TEXTS),
)
# What many devices have besides, and may change by itself; strings first.
COMMON = (
    *(
        KnownObject(Multiplexer(index), DataType.VISIBLE_STRING, Access.RO)
        for index in (0x6403, 0x6404, 0x6503, 0x6504, 0x6505)
    ),
    *(
        KnownObject(Multiplexer(index), data_type, Access.RO)
        for index, data_type in (
            (0x1001, DataType.UNSIGNED8),
            (0x1002, DataType.UNSIGNED32),
            (0x1003, DataType.UNSIGNED8),
            (0x1005, DataType.UNSIGNED32),
            (0x1006, DataType.UNSIGNED32),
            (0x100C, DataType.UNSIGNED16),
            (0x100D, DataType.UNSIGNED8),
            (0x1010, DataType.UNSIGNED8),
            (0x1011, DataType.UNSIGNED8),
            (0x1014, DataType.UNSIGNED32),
            (0x1016, DataType.UNSIGNED8),
            (0x1017, DataType.UNSIGNED16),
            (0x1200, DataType.UNSIGNED8),
            (0x1400, DataType.UNSIGNED8),
            (0x1800, DataType.UNSIGNED8),
        )
    ),
)
# Takes the object that is read next, how many were read before, and how many there are.
Progress = Callable[[KnownObject, int, int], None]
READING = Rule("run.discovery", "", Level.MAY, "What the suite reads before the first case.")


class Reading:
    """The conversation of a discovery, which ends with a device that is lost.

    It goes on with one that something ``brings_back``; ``losses`` counts how often.
    """

    def __init__(self, sdo: Dialogue, brings_back: Callable[[], bool] | None = None) -> None:
        """Take a device of which only the baseline is known."""
        self.sdo = sdo
        self.device = sdo.device
        self.losses = 0
        self._brings_back = brings_back

    def recover(self) -> bool:
        """Leave the server idle after a breach; raises DeviceLost where that is not to be had."""
        sdo = self.sdo
        asked = sdo.wire.last_sent
        answers = sdo.silence.recover()
        # Of a device that is always one request behind, the cases say what is wrong.
        unsound = "" if sdo.device.learned.is_behind else sdo.channel.pace.unsound
        why = unsound if answers else GONE
        if not why:
            return True
        self.losses += 1
        brings_back = None if answers or self.losses > MOST_LOSSES else self._brings_back
        if brings_back is None or not brings_back():
            raise lost_early(sdo, asked, why)
        expected, nothing = "an answer to a read of 1000h", NoAnswer("nothing")
        sdo.note(Violation(IDLE_AFTERWARDS, expected=expected, actual=nothing, asked=asked))
        return True


def unseen(entry: KnownObject, number: int, count: int) -> None:
    """Show nothing."""


def discover(
    channel: Channel,
    device: Device,
    causes: Causes | None = None,
    progress: Progress = unseen,
    brings_back: Callable[[], bool] | None = None,
) -> None:
    """Fill in the device's baseline, identity, texts and the values of its objects.

    Only reads. What cannot be read stays unknown: the cases will say what is wrong with it. Where
    no EDS lists what there is, the objects that devices commonly have are tried, and the device is
    asked whether it has block uploads: an EDS would not say that either, but its cases ask. What is
    met on the way is added to ``causes``; ``progress`` is told of each object that is read. One
    that is lost is read on where something ``brings_back`` it. In haste some of very many objects
    are passed over. Raises SilentNode when nothing answers, TwoDevices where two do, DeviceLost
    when nothing does any more.
    """
    at_once = record_baseline(channel, device)
    again = look_for_second(channel, device)
    record = CaseRecord(READING, Causes() if causes is None else causes)
    reading = Reading(Dialogue(channel, device, record, 0), brings_back)
    if again is not None and at_once:
        _note_first_twice(reading, again)
    if device.learned.is_behind:
        record.causes.of_one = IS_BEHIND
    named = set(device.known)
    _read_listed(reading, progress)
    look_where_it_reads(reading.sdo, partial(_learn, reading))
    for entry in _MANDATORY:
        passed_over = device.learned.is_unread(entry.mux, Reason.PASSED_OVER)
        if (entry.mux not in named or passed_over) and (
            _learn(reading, entry) or entry.mux == DEVICE_TYPE
        ):
            device.known.setdefault(entry.mux, entry)
    if not device.listing.is_complete:
        _try_common(reading, named)
        _ask_for_block_upload(reading)
    if any(known.varies for known in Roles(device).all_writable()):
        _seek_nowhere(reading)
    if not device.learned.answers_twice and any(
        found.rule is UNSOLICITED for found in record.minor
    ):
        examine(channel, device)
    if device.learned.answers_twice:
        record.causes.of_one = ANSWERS_TWICE
    _find_changing(reading)
    keep_aside(reading.sdo)


def _read_listed(reading: Reading, progress: Progress) -> None:
    device = reading.device
    first = FirstReading(device.permits.effort)
    listed = in_order(device)
    for number, entry in enumerate(listed):
        if first.ends():
            over = {left.mux: Unread(Reason.PASSED_OVER) for left in listed[number:]}
            device.learned.unread.update(over)
            return
        progress(entry, number, len(listed))
        _learn(reading, entry)
        first.count(device.values.get(entry.mux, b""))


def _find_changing(reading: Reading) -> None:
    """Read numbers once more, when all was read: what reads otherwise the device changes."""
    device = reading.device
    numbers = [
        known
        for known in device.objects
        if known.is_steady and known.mux in device.values and may_change(device, known)
    ]
    for known in device.permits.effort.sampled(numbers):
        try:
            found = reading.sdo.upload(known)
        except Violation:
            reading.recover()  # the cases will say what is wrong with it
            continue
        if found != device.values[known.mux]:
            take_as_changing(device, known)


def _seek_nowhere(reading: Reading) -> None:
    """Find out which of some entries the device lacks: long values may name them."""
    device = reading.device
    there = {mux.index for mux in device.known}
    for mux in PRINTABLE_OBJECTS:
        if mux.index in there:
            continue
        try:
            asked = (NEVER_THERE, Multiplexer(mux.index), mux)
            lack, *codes = [_refusal(reading.sdo, each) for each in asked]
            if all(_says_missing(code, lack) for code in codes):
                device.learned.nowhere += (mux,)
        except Violation:
            # Other cases say what is wrong with this; one silence is enough.
            reading.recover()
            return


def _refusal(sdo: Dialogue, mux: Multiplexer) -> int | None:
    try:
        sdo.read(mux)
    except ServerAborted as aborted:
        return aborted.abort.code
    return None


def _says_missing(code: int | None, lack: int | None) -> bool:
    """Say whether a code is that of an entry that is not there.

    A device may have a wrong one for that: the one with which it refuses what no device can have.
    """
    is_wrong = code == lack and code not in BY_STATE
    return code is not None and (code not in EXISTS or is_wrong)


def _ask_for_block_upload(reading: Reading) -> None:
    try:
        Blocks(reading.sdo, reading.recover).require_upload()
    except Unimplemented:
        return  # the refusal is known from now on
    except Violation:
        # Silence, or no answer of SDO: the cases on block uploads will say so.
        reading.recover()


def _try_common(reading: Reading, named: set[Multiplexer]) -> None:
    for entry in COMMON:
        if entry.mux in named:
            continue
        if _learn(reading, entry):
            reading.device.known.setdefault(entry.mux, entry)
        else:
            del reading.device.learned.unread[entry.mux]  # it was only tried
            reading.device.learned.serving.forget(Service.UPLOAD, entry.mux)


def _note_first_twice(reading: Reading, again: CanFrame) -> None:
    """Note that the first answers of a device come twice, and later ones do not."""
    request = UploadInitiate(DEVICE_TYPE)
    found = Violation(
        UNSOLICITED,
        expected=f"one answer to: {describe(request)}",
        actual=Received(decode_response(again.data), remark=", twice"),
        asked=request,
        told_as=FIRST_TWICE,
    )
    reading.sdo.note(found)


def _learn(reading: Reading, known: KnownObject) -> bool:
    device = reading.device
    unread = device.learned.unread
    try:
        value = reading.sdo.again_if_aborted(lambda: read_whole(reading.sdo, known))
    except TooLong as size:
        unread[known.mux] = Unread(Reason.TOO_LONG, str(size), size.missing)
        return True
    except ServerAborted as refused:
        unread[known.mux] = Unread(Reason.REFUSED, str(refused))
        learn_refusal(reading.sdo, known.mux)
        return False
    except Violation as error:
        # A device that answers badly here is tested all the same.
        unread[known.mux] = Unread(Reason.BREACH, str(error), came=error.actual)
        learn_refusal(reading.sdo, known.mux)
        early = reading.sdo.record.early.met is not None
        error.asked = error.asked or reading.sdo.wire.last_sent
        wrong = not early and (error.rule is not NOT_REFUSED or _goes_astray(error))
        losses = reading.losses
        if reading.recover() and wrong and reading.losses == losses:
            reading.sdo.note(error)  # no case may ever write or read what cannot be read
        return False
    unread.pop(known.mux, None)
    device.learned.serving.learn(Service.UPLOAD, known.mux, None)
    if known.length is not None and len(value) < known.length:
        why = f"{len(value)} bytes instead of {known.length}"
        unread[known.mux] = Unread(Reason.REFUSED, why)
        return False
    if is_error_place(known.mux):
        return True  # what it holds comes and goes: no case may count on it
    # What reads too long for its type could not be written back as it was read.
    device.values[known.mux] = value[: known.length]
    return True


def _goes_astray(error: Violation) -> bool:
    """Say whether a server took the request for the next segment for an error of the client.

    It may end an upload for reasons of its own, with other codes.
    """
    abort = abort_in(error.seen)
    return isinstance(error.asked, UploadSegment) and abort is not None and abort.code in ASTRAY
