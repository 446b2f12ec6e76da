"""Every object that is listed of the device, in its EDS or by name (CiA 301, 7.4; CiA 306-1)."""

from conformance.device.device import Device
from conformance.device.eds_listing import STRUCTURE_OF_OBJECT, ListedObject
from conformance.device.known_objects import KnownObject
from conformance.device.learned import Reason
from conformance.device.not_testable import NotTestable
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.changing import changes_by_itself, is_steady
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.held_values import expect_stated
from conformance.dialogue.object_expectations import (
    NOT_NOW,
    encoded,
    expect_kept,
    expect_unlisted,
    expect_write_refused,
    expect_written_back,
    indices_text,
    is_within_limits,
    may_be_probed,
    may_be_written,
    readable_now,
    scan,
    unchanged,
    value_of,
    value_to_write_back,
    whole_value,
    write_quickly,
)
from conformance.dialogue.storage import Storage
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import of_another_length, same_value, with_spaces
from conformance.run import object_choices as choose
from conformance.run.case import may, must, should
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import shown
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.frames import (
    Abort,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.pdos import is_mapping, is_multiplexed
from conformance.sdo.rules import Violation
from conformance.sdo.rules.download_initiates import TOO_LONG, TOO_SHORT
from conformance.sdo.rules.idle import (
    EMPTY_PLACE,
    NO_DATA,
    READ_ONLY,
    SUB_INDEX_MISSING,
    WRITE_ONLY,
)
from conformance.sdo.rules.object_dictionary import STRUCTURE_ENTRY
from conformance.sdo.seen import Data, Received, Said

EDS = "CiA 306-1"
CHANGES = "the device changes the object by itself"
TOO_HIGH = (AbortCode.VALUE_TOO_HIGH, AbortCode.VALUE_INVALID)
TOO_LOW = (AbortCode.VALUE_TOO_LOW, AbortCode.VALUE_INVALID)


# What is there


@must("od.read", "dictionary.access", entry=choose.readable)
def test_read(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """An entry that is listed as readable can be read."""
    # What is very long was read when the run began, or is too long; that it can be read shows at
    # its beginning.
    too_long = device.learned.is_unread(entry.mux, Reason.TOO_LONG)
    try:
        if too_long or whole_value(device, entry) is not None:
            sdo.send(UploadInitiate(entry.mux))
            sdo.checks.upload_initiate(sdo.receive(), entry.mux)
        else:
            sdo.read(entry.mux)
    except ServerAborted as aborted:
        refusal = Received(aborted.abort)
        if aborted.abort.code not in NOT_NOW:
            raise sdo.breach(f"{entry.title} is read", refusal) from aborted
        sdo.info(f"{entry} cannot be read now: {refusal.words}")


@must("od.length", "data.type-length", entry=choose.of_fixed_length)
def test_length(sdo: Dialogue, entry: KnownObject) -> None:
    """A value has as many bytes as its data type."""
    data = readable_now(sdo, entry)
    if len(data) != entry.length:
        raise of_another_length(entry, data)


@must("od.within-limits", "dictionary.limits", entry=choose.limited)
def test_within_limits(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """The value of a number lies within its limits."""
    value_of(device, entry)
    data = sdo.upload(entry)
    if not is_within_limits(entry, data):
        raise sdo.breach(f"{entry.title} between {entry.low} and {entry.high}", Data(data))


@must("od.default", "dictionary.default", "dictionary.stated-text", entry=choose.fixed)
def test_default(sdo: Dialogue, entry: KnownObject) -> None:
    """What never changes has the value that the EDS states."""
    expect_stated(sdo, entry, entry.default or b"")


@must("od.load-defaults", "storage.load-defaults")
def test_load_defaults(storage: Storage) -> None:
    """A device that loads its defaults on command confirms "load", and boots with them then.

    What it had before is put back; what it had stored is stored again.
    """
    storage.loaded_defaults()


@must("od.default-of-parameter", "dictionary.default", entry=choose.parameters)
def test_default_of_parameter(
    sdo: Dialogue, storage: Storage, device: Device, entry: KnownObject
) -> None:
    """After the defaults were loaded a parameter has the value that the EDS states.

    All parameters are read when they are loaded, once in a run, and what was there is put back.
    """
    due = entry.default or b""
    if device.permits.at_defaults:
        ValueAccess(sdo).write_own(entry.mux)
        expect_stated(sdo, entry, due)
        return
    if not is_steady(device, entry):
        raise NotTestable(CHANGES)
    found = storage.loaded_defaults().get(entry.mux)
    if found is None:
        raise NotTestable("the object was not served when the defaults had been loaded")
    seen_of_it = device.known.get(entry.mux, entry)
    if not same_value(seen_of_it, found, with_spaces(entry, due, found)):
        if changes_by_itself(sdo, entry.mux):
            raise NotTestable(CHANGES)
        raise sdo.breach(f"{entry} reads {shown(due)} after the defaults were loaded", Data(found))


@should("od.configured", "dictionary.configured", entry=choose.configured)
def test_configured(sdo: Dialogue, entry: KnownObject) -> None:
    """The device is configured as its DCF says (ParameterValue)."""
    ValueAccess(sdo).write_own(entry.mux)
    expect_stated(sdo, entry, entry.configured or b"")


@must("od.identity", "dictionary.identity", said=choose.identity)
def test_identity(sdo: Dialogue, said: tuple[Multiplexer, int]) -> None:
    """The device is of the vendor, product and revision that the EDS is for."""
    mux, number = said
    data = sdo.upload(mux)
    if data != number.to_bytes(4, "little"):
        raise sdo.breach(
            f"{mux} reads {number:08X}h, as [DeviceInfo] says",
            Said(f"{int.from_bytes(data, 'little'):08X}h", "…"),
        )


@must(
    "od.error-list",
    "object.no-data",
    "object.empty-place",
    clause="7.5.2.4",
    entry=choose.error_places,
)
def test_error_list(sdo: Dialogue, entry: KnownObject) -> None:
    """A place of the error list (1003h) reads as 4 bytes if it holds an error, else not at all.

    To read an empty place as 0 breaks a SHOULD.
    """
    count = int.from_bytes(sdo.upload(Multiplexer(ERROR_LIST)), "little")
    sdo.send(UploadInitiate(entry.mux))
    answer = sdo.receive()
    is_empty = entry.mux.sub_index > count
    if is_empty and isinstance(answer, Abort):
        # Which code says so is a NOTE; devices after earlier editions have no such sub-index.
        earlier = (AbortCode.SUB_INDEX_MISSING,)
        sdo.take_abort(answer, NO_DATA.codes, entry, earlier)
        return
    response = sdo.checks.upload_initiate(answer, entry.mux)
    data = sdo.finish_upload(entry, response)
    if len(data) != 4:
        raise sdo.breach("4 bytes", Data(data))
    if not is_empty:
        return
    due = f"{entry} to be refused while 1003h:00 reads {count}"
    if any(data):
        raise sdo.breach(due, Data(data))
    sdo.note(Violation(EMPTY_PLACE, expected=due, actual=Data(data)))


# Writing


@must("od.write-back", "dictionary.access", entry=choose.writable)
def test_write_back(sdo: Dialogue, blocks: Blocks, device: Device, entry: KnownObject) -> None:
    """A writable entry takes the value that it has."""
    may_be_written(device, entry)
    value = value_to_write_back(sdo, entry)
    expect_written_back(sdo, entry, write_quickly(sdo, entry, value), value)


@must("od.too-short", "download.too-short", entry=choose.longer_than_a_byte)
def test_too_short(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """One byte less than the type has is refused, and the value stays."""
    may_be_written(device, entry)
    with unchanged(sdo, entry) as value:
        expect_write_refused(sdo, entry, value[:-1], *TOO_SHORT.codes)


@must("od.too-long", "download.too-long", entry=choose.writable_numbers)
def test_too_long(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """One byte more than the type has is refused, and the value stays."""
    may_be_written(device, entry)
    with unchanged(sdo, entry) as value:
        expect_write_refused(sdo, entry, value + b"\0", *TOO_LONG.codes)


@must("od.low-limit", "dictionary.limits-included", entry=choose.with_low_limit)
def test_low_limit(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """The low limit itself is a value that may be written."""
    may_be_written(device, entry)
    value = encoded(entry, entry.low)
    expect_written_back(sdo, entry, sdo.try_download(entry, value), value)


@must("od.high-limit", "dictionary.limits-included", entry=choose.with_high_limit)
def test_high_limit(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """The high limit itself is a value that may be written."""
    may_be_written(device, entry)
    value = encoded(entry, entry.high)
    expect_written_back(sdo, entry, sdo.try_download(entry, value), value)


@must("od.below-limit", "object.limits", entry=choose.undercuttable)
def test_below_limit(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """What is below the low limit is refused, and the value stays."""
    may_be_written(device, entry)
    with unchanged(sdo, entry):
        expect_write_refused(sdo, entry, choose.below(entry) or b"", *TOO_LOW)


@must("od.above-limit", "object.limits", entry=choose.exceedable)
def test_above_limit(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """What is above the high limit is refused, and the value stays."""
    may_be_written(device, entry)
    with unchanged(sdo, entry):
        expect_write_refused(sdo, entry, choose.above(entry) or b"", *TOO_HIGH)


# What may not be done


@must("od.read-only", "object.read-only", entry=choose.protected)
def test_read_only(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """A read-only entry refuses even the value that it has."""
    may_be_probed(device, entry)
    value = sdo.upload(entry)
    expect_write_refused(sdo, entry, value or b"\0", *READ_ONLY.codes)
    expect_kept(sdo, entry, value)


@must("od.write-only", "object.write-only", entry=choose.write_only)
def test_write_only(sdo: Dialogue, entry: KnownObject) -> None:
    """The upload of a write-only entry is aborted as such."""
    sdo.send(UploadInitiate(entry.mux))
    sdo.expect_abort(*WRITE_ONLY.codes, of=entry)


# What is not there


@must("od.highest-sub-index", "dictionary.highest-sub-index", of=choose.structured)
def test_highest_sub_index(sdo: Dialogue, of: ListedObject) -> None:
    """Sub-index 0 of an array or record holds the highest sub-index, as the EDS lists them.

    Where it can be written (1003h), and in a mapping, it counts those in use, and may be lower.
    """
    count = of.entries[0]
    data = sdo.upload(count)
    if is_multiplexed(count.mux, data):
        return
    in_use = count.access is Access.RW or of.index == ERROR_LIST or is_mapping(of.index)
    if len(data) != 1 or data[0] > of.highest or (not in_use and data[0] != of.highest):
        least = "at most " if in_use else ""
        raise sdo.breach(f"{count} reads {least}{of.highest:02X}h in 1 byte", Data(data))


@must("od.sub-index-beyond", "object.sub-index-missing", clause="7.4.2", mux=choose.beyond)
def test_sub_index_beyond(sdo: Dialogue, mux: Multiplexer) -> None:
    """The sub-index behind the last is aborted as missing; a variable has sub-index 0 only."""
    sdo.send(UploadInitiate(mux))
    sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=mux)


@must("od.gap", "object.sub-index-missing", clause="7.4.2", mux=choose.gaps)
def test_gap(sdo: Dialogue, mux: Multiplexer) -> None:
    """A sub-index that an array or record leaves out is aborted as missing."""
    sdo.send(UploadInitiate(mux))
    sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=mux)


@may("od.structure", "dictionary.structure", of=choose.listed_objects)
def test_structure(sdo: Dialogue, of: ListedObject) -> None:
    """Sub-index FFh is missing, or tells the data type and the object type that the EDS states."""
    mux = Multiplexer(of.index, STRUCTURE_OF_OBJECT)
    sdo.send(UploadInitiate(mux))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.take_abort(answer, STRUCTURE_ENTRY.codes, mux)
        return
    entry = KnownObject(mux, DataType.UNSIGNED32, Access.CONST)
    response = sdo.checks.upload_initiate(answer, mux)
    data = sdo.finish_upload(entry, response)
    due = bytes([of.object_type])
    if of.type_code is not None:
        due += of.type_code.to_bytes(3, "little")
    if len(data) != 4 or not data.startswith(due):
        raise sdo.breach(f"4 bytes that begin with {due.hex(' ')}", Data(data))


@must("od.unlisted", "object.missing-refused", "dictionary.unlisted", mux=choose.unlisted)
def test_unlisted(sdo: Dialogue, mux: Multiplexer) -> None:
    """An index that the EDS does not list is aborted as missing.

    That a device has more than its EDS lists breaks a SHOULD.
    """
    sdo.send(UploadInitiate(mux))
    expect_unlisted(sdo, sdo.receive(), mux)


@must("od.scan", "dictionary.unlisted", clause=EDS, indices=choose.ranges)
def test_scan(sdo: Dialogue, device: Device, indices: range) -> None:
    """Of all indices those that the EDS lists are there; what else there is, is told."""
    there, missing = scan(sdo, indices)
    listed = {index for index in device.listing.objects if index in indices}
    due = {index for index in listed if device.listing.objects[index].entries}
    if due & missing:
        raise sdo.breach(
            "an object at each index that is listed",
            Said(f"none at {indices_text(due & missing)}", "none at …"),
        )
    if there - listed:
        sdo.info(f"not listed, and there: {indices_text(there - listed)}")
