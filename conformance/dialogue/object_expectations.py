"""What cases on listed objects expect, whatever the object: values kept, writes refused."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from conformance.device.device import Device
from conformance.device.effort import LONG_VALUE, READS_OF_MEASURED, SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Reason
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.numbers import Number, decode_number, encode_number
from conformance.device.serving import Service
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.changing import changes_by_itself, is_steady
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.held_values import expect_read
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import check_constant, longer_than_taken, same_value
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import shown
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    Response,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.pdos import IN_ORDER
from conformance.sdo.rules import MISSING_REFUSED, Violation
from conformance.sdo.rules.accepted import IN_USE
from conformance.sdo.rules.download_initiates import LIMITS
from conformance.sdo.rules.object_dictionary import UNLISTED
from conformance.sdo.seen import Received

MOST_SHOWN = 32
# From there on a counter of 16 bits has wrapped: what is longer does not count any further.
BEYOND_16_BITS = 1 << 16
# What a device may say of an object that it has, at a time when it cannot serve it.
NOT_NOW = (AbortCode.NO_DATA, AbortCode.LOCAL_CONTROL, AbortCode.DEVICE_STATE)
KEPT_IN_USE = (*IN_USE, AbortCode.UNSUPPORTED_ACCESS, AbortCode.NOT_MAPPABLE)


def value_of(device: Device, entry: KnownObject) -> bytes:
    """Return what an entry read at the start of the run; raises NotTestable where it did not."""
    value = device.values.get(entry.mux)
    if value is None:
        if device.learned.is_unread(entry.mux, Reason.TOO_LONG):
            unread = device.learned.unread[entry.mux]
            raise NotTestable(f"the object is too long for that: {unread.why}", unread.missing)
        if device.learned.is_unread(entry.mux, Reason.PASSED_OVER):
            raise NotTestable(
                "the object is one of very many, and was not read when the run began: a run "
                "without --sdo-quick reads all",
                Missing(Lack.WHOLE_READING),
            )
        if refused := device.learned.serving.refusal(Service.UPLOAD, entry.mux):
            raise device.learned.serving.way_out(refused, device.permissions)
        raise NotTestable("the object could not be read at the start of the run: see od.read")
    return value


def readable_now(sdo: Dialogue, entry: KnownObject) -> bytes:
    """Read an entry; raises NotTestable where it is refused, which is for od.read to judge."""
    try:
        data = sdo.read(entry)
    except ServerAborted as aborted:
        raise NotTestable("the object cannot be read: see od.read") from aborted
    check_constant(sdo.device, entry.mux, data)
    return data


def differing_reads(
    sdo: Dialogue, blocks: Blocks, entry: KnownObject, *, crc: bool, threshold: int
) -> tuple[bytes, bytes] | None:
    """Read an entry by an ordinary upload and in blocks; return both where they differ, else None.

    What a device measures changes in between: there every attempt has to differ, and the ordinary
    uploads among themselves must not. A very long value is read by an ordinary upload once in a
    run, and again only where it differs.
    """
    held = whole_value(sdo.device, entry)
    if held is not None:
        uploaded = blocks.upload(entry, crc=crc, threshold=threshold)
        if same_value(entry, sdo.of_its_length(entry, uploaded), held):
            return None
    ordinary: set[bytes] = set()
    steady = is_steady(sdo.device, entry)
    for _ in range(1 if steady else READS_OF_MEASURED):
        read = sdo.device.contents.current.get(entry.mux) if steady else None
        before = sdo.upload(entry) if read is None else read
        ordinary.add(before)
        uploaded = blocks.upload(entry, crc=crc, threshold=threshold)
        found = sdo.of_its_length(entry, uploaded)
        if same_value(entry, found, before):
            return None
    if len(ordinary) > 1 or changes_by_itself(sdo, entry.mux):
        sdo.info(f"{entry} changes by itself: its values are not compared")
        return None
    return before, found


def whole_value(device: Device, entry: KnownObject) -> bytes | None:
    """Return what an entry read when the run began if that is very long, and only the suite's."""
    value = device.values.get(entry.mux, b"") if is_steady(device, entry) else b""
    return value if len(value) > LONG_VALUE else None


def value_to_write_back(sdo: Dialogue, entry: KnownObject) -> bytes:
    """Return the value that an entry has, without what fills it up where it takes none so long.

    Raises Violation for one that reads longer than may be written, and is not filled up.
    """
    device = sdo.device
    known = device.known.get(entry.mux, entry)
    if known.habits.beyond:
        return device.values[entry.mux]
    value = whole_value(device, entry)
    if value is None:
        value = ValueAccess(sdo).in_blocks(entry.mux, device.values.get(entry.mux, b""))
    if value is None:
        value = sdo.upload(entry)
    if device.learned.lengths[entry.mux].irreplaceable:
        raise longer_than_taken(entry, value)
    return value


def is_known_to_go(device: Device, value: bytes) -> bool:
    """Say whether a very long value is known to go in segments: one that counts as far did so."""
    whole = [size for lengths in device.learned.lengths.values() for size in lengths.whole]
    return len(value) > LONG_VALUE and max(whole, default=0) >= min(len(value), BEYOND_16_BITS)


def write_quickly(sdo: Dialogue, entry: KnownObject, value: bytes) -> Abort | None:
    """Write a value, in blocks if it is known to go in segments; return the abort if refused."""
    if is_known_to_go(sdo.device, value) and ValueAccess(sdo).write_in_blocks(entry.mux, value):
        return None
    return sdo.try_download(entry, value)


def may_be_written(device: Device, entry: KnownObject) -> None:
    """Raise NotTestable for an entry that may not be written, or that was not read."""
    refusal = device.permits.refusal(entry)
    if refusal is not None:
        raise refusal
    value_of(device, entry)


def may_be_probed(device: Device, entry: KnownObject) -> None:
    """Raise NotTestable for a read-only entry that the suite may not try to write."""
    refusal = device.permits.probe_refusal(entry)
    if refusal is not None:
        raise refusal
    value_of(device, entry)


def encoded(entry: KnownObject, number: Number | None) -> bytes:
    """Return the bytes of a number, a limit for example, in the type of an entry."""
    if entry.data_type is None or number is None:
        raise NotTestable(f"the type of {entry} is not known")
    return encode_number(entry.data_type, number)


def is_within_limits(entry: KnownObject, data: bytes) -> bool:
    """Say whether a value lies within the limits, which are included."""
    if entry.data_type is None or len(data) != entry.length:
        return False
    number = decode_number(entry.data_type, data)
    low_enough = entry.high is None or number <= entry.high
    return low_enough and (entry.low is None or number >= entry.low)


def expect_written_back(
    sdo: Dialogue, entry: KnownObject, abort: Abort | None, value: bytes
) -> None:
    """Expect a download to have been served, and the value to stay; ``abort`` is a refusal.

    A value without bytes may be refused, and any value for the state that the device is in. What
    does not change while it is in use may refuse the value that it has as well.
    """
    if abort is None:
        if is_steady(sdo.device, entry):
            Blocks(sdo).expect_value(sdo.device.known.get(entry.mux, entry), value)
        return
    refusal = Received(abort)
    in_use = entry.mux.index in IN_ORDER and abort.code in KEPT_IN_USE
    if abort.code not in NOT_NOW and value and not in_use:
        raise sdo.breach(f"a download of {shown(value)} to {entry} to be confirmed", refusal)
    sdo.info(f"{entry} does not take {shown(value)} now: {refusal.words}")


def codes_of_refusal(entry: KnownObject, data: bytes, *codes: AbortCode) -> tuple[AbortCode, ...]:
    """Return the codes with which data may be refused.

    Those of another length may lie beyond a limit as well, and a server may look at that first.
    """
    is_beyond = entry.is_limited and len(data) != entry.length
    return (*codes, *LIMITS.codes) if is_beyond else codes


def expect_write_refused(sdo: Dialogue, entry: KnownObject, data: bytes, *codes: AbortCode) -> None:
    """Send a download, in one frame where it fits, that has to be refused with one of the codes."""
    codes = codes_of_refusal(entry, data, *codes)
    if not 1 <= len(data) <= EXPEDITED_LENGTH:
        sdo.expect_download_refused(entry, data, *codes, size=len(data))
        return
    sdo.send(DownloadInitiate.with_data(entry.mux, data))
    sdo.expect_abort(*codes, of=entry)


def expect_kept(sdo: Dialogue, entry: KnownObject, value: bytes) -> None:
    """Expect an entry to read as before, unless the device changes it by itself."""
    if is_steady(sdo.device, entry):
        sdo.expect_value(entry, value)


@contextmanager
def unchanged(sdo: Dialogue, entry: KnownObject) -> Iterator[bytes]:
    """Expect an entry to keep its value, unless the device changes it by itself."""
    value = sdo.upload(entry)
    yield value
    sdo.end_transfer()
    expect_kept(sdo, entry, value)


def expect_unlisted(sdo: Dialogue, response: Response, mux: Multiplexer) -> None:
    """Expect what the EDS does not list to be missing; that it is there breaks a SHOULD only."""
    if isinstance(response, Abort) and response.code not in _THERE:
        sdo.take_abort(response, MISSING_REFUSED.codes, mux)
        return
    if not isinstance(response, Abort):
        sdo.checks.upload_initiate(response, mux)
    sdo.note(
        Violation(
            UNLISTED,
            expected=f"{mux} to be missing, as the EDS does not list it",
            actual=Received(response),
        )
    )


def scan(sdo: Dialogue, indices: Iterable[int]) -> tuple[set[int], set[int]]:
    """Read sub-index 0 of each index; return the indices that are there, and the missing ones.

    The next request waits for the answer of the one before, and for nothing else.
    """
    there: set[int] = set()
    missing: set[int] = set()
    for index in indices:
        sdo.send(UploadInitiate(Multiplexer(index)))
        response = sdo.receive()
        sdo.end_transfer()
        lacking = isinstance(response, Abort) and response.code == AbortCode.OBJECT_MISSING
        (missing if lacking else there).add(index)
    return there, missing


def indices_text(indices: Iterable[int]) -> str:
    """Write indices in their order, the first of very many."""
    found = sorted(indices)
    rest = f" and {len(found) - MOST_SHOWN} more" if len(found) > MOST_SHOWN else ""
    return ", ".join(f"{index:04X}h" for index in found[:MOST_SHOWN]) + rest


_THERE = (AbortCode.READ_OF_WRITE_ONLY, AbortCode.UNSUPPORTED_ACCESS, *NOT_NOW)


def expect_stored_and_read(sdo: Dialogue, room: Room, known: KnownObject, size: int) -> None:
    """Expect a value of ``size`` bytes to be stored by a download, and to be read by an upload.

    Long values take so many requests that the cases on either side share one exchange.
    """
    whole = sdo.device.learned.lengths[known.mux].whole
    if size in whole:
        return
    data = sdo.payload(size)
    room.store(known, data, segmented=True)
    expect_read(sdo, known, data)
    if size > SHORT_VALUE:
        whole.add(size)
