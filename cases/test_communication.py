"""Objects of the communication beside SDO: identity, errors, SYNC, TIME, EMCY and PDOs (7.5.2)."""

from contextlib import suppress

from conformance.device.device import VENDOR_ID, Device
from conformance.device.learned import Reason
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.missing_objects import missing_object
from conformance.dialogue.parameters import (
    COB_ID_ENTRIES,
    PDOS,
    CobIdEntry,
    Parameters,
    number_of,
)
from conformance.dialogue.value_access import ValueAccess
from conformance.run.case import may, must
from conformance.sdo.cob_id import (
    EXTENDED,
    LARGEST_EXTENDED_ID,
    REQUEST_BASE,
    RESPONSE_BASE,
    RESTRICTED,
)
from conformance.sdo.describe import shown
from conformance.sdo.emergency import ERROR_LIST, ERROR_REGISTER, GENERIC
from conformance.sdo.frames import Abort, DownloadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import ERROR_CONTROL_BASE
from conformance.sdo.pdos import MOST_BITS, Mapped
from conformance.sdo.rules import Rule, Violation, communication
from conformance.sdo.seen import Data, Received, other_data, said

COUNT = Multiplexer(ERROR_LIST)
STORED_EDS, STORED_FORMAT = Multiplexer(0x1021), Multiplexer(0x1022)
SECTIONS = (b"[deviceinfo]", b"[mandatoryobjects]")
# The capabilities of 1010h: on command, and by itself; of 1011h: on command.
CAPABILITIES = {"1010h": (0x1010, 0b11), "1011h": (0x1011, 0b01)}
# Both ends of each range that is kept for other services, NMT last: a device that takes any of them
# has failed before.
KEPT_FOR_OTHERS = sorted({can_id for ends in RESTRICTED for can_id in ends}, reverse=True)
FREE_ID, LONG_ID = 0x6A1, 0x106A1
STRAY_BIT = 1 << 11
NO_REMOTE_FRAMES = 1 << 30
SYNC_PERIOD = Multiplexer(0x1006)
RESERVED_TYPE = 0xF1


# What can be read


@must("communication.vendor-id")
def test_vendor_id(sdo: Dialogue) -> None:
    """1018h:01 holds a vendor-ID; 0 is none."""
    value = sdo.upload(VENDOR_ID)
    if not any(value):
        raise sdo.breach(f"{VENDOR_ID} reads the vendor-ID of the manufacturer", Data(value))


@must("communication.error-register")
def test_error_register(sdo: Dialogue, parameters: Parameters) -> None:
    """Bit 0 of 1001h (generic error) is set whenever another bit is."""
    value = parameters.present(ERROR_REGISTER)
    register = value[0] if value else 0
    if register and not register & GENERIC:
        raise sdo.breach(
            "bit 0 set beside the others", other_data(f"{ERROR_REGISTER} reads {register:02X}h")
        )


@must("communication.storage-capability", command=CAPABILITIES)
def test_storage_capability(
    sdo: Dialogue, parameters: Parameters, command: tuple[int, int]
) -> None:
    """1010h and 1011h say in each sub-index what they can; all other bits are 0."""
    index, capabilities = command
    highest = parameters.present(Multiplexer(index))
    for sub_index in range(1, (highest[0] if highest else 0) + 1):
        mux = Multiplexer(index, sub_index)
        value = sdo.read_if_there(mux)
        if value is not None and (len(value) != 4 or number_of(value) & ~capabilities):
            raise sdo.breach(
                f"{mux} reads 4 bytes, with no bits but {capabilities:X}h", Data(value)
            )


@must("communication.stored-eds")
def test_stored_eds(sdo: Dialogue, blocks: Blocks, parameters: Parameters) -> None:
    """1021h is the EDS of the device, and reads the same in blocks."""
    unread = sdo.device.learned.unread.get(STORED_EDS)
    if unread is not None and unread.reason is Reason.TOO_LONG:
        raise NotTestable(f"the EDS is too long for that: {unread.why}")
    known = sdo.device.values.get(STORED_EDS) or ValueAccess(sdo).announced_in_blocks(STORED_EDS)
    text = known or parameters.present(STORED_EDS)
    storage_format = sdo.read_if_there(STORED_FORMAT)
    if storage_format is not None and any(storage_format):
        sdo.info(f"the EDS is stored in format {storage_format.hex()}h: it is not looked into")
    elif missing := [name for name in SECTIONS if name not in text.lower()]:
        names = " and ".join(name.decode() for name in missing)
        raise sdo.breach(f"an EDS, with {names}", Data(text))
    uploaded = blocks.try_upload(STORED_EDS)
    found = getattr(uploaded, "data", None)
    if found is not None and found != text:
        raise sdo.breach(f"{shown(text)} in blocks as in segments", Data(found))


@must("communication.reserved-entry", "communication.compatibility-entry")
def test_reserved_entry(sdo: Dialogue, device: Device, parameters: Parameters) -> None:
    """Sub-index 04h of 1800h is reserved, or the compatibility entry that the EDS lists.

    Without an EDS nobody knows which: that the entry is there breaks a SHOULD then.
    """
    parameters.present(Multiplexer(0x1800))
    mux = Multiplexer(0x1800, 4)
    if device.listing.find(mux) is not None:
        raise NotTestable(f"the EDS lists {mux}, the compatibility entry of DS-301 4.02")
    sdo.send(UploadInitiate(mux))
    response = sdo.receive()
    if device.listing.is_complete or isinstance(response, Abort):
        sdo.take_abort(response, communication.RESERVED_ENTRY.codes, mux)
        return
    sdo.finish_upload(mux, sdo.checks.upload_initiate(response, mux))
    rule = communication.COMPATIBILITY_ENTRY
    sdo.note(Violation(rule, expected=f"{mux} to be missing", actual=Received(response)))


# The list of errors


@must("communication.error-list-cleared")
def test_error_list_cleared(sdo: Dialogue, parameters: Parameters) -> None:
    """A 0 written to 1003h:00 clears the list of errors, but for one that an emergency tells."""
    sdo.device.permits.require_write(ERROR_LIST)
    parameters.present(COUNT)
    told = sdo.channel.emergency
    sdo.download(COUNT, b"\0")
    if any(found := sdo.upload(COUNT)) and sdo.channel.emergency is told:
        raise sdo.breach(f"{COUNT} reads 00", Data(found))


@must("communication.error-list-count", value=[1, 5, 255])
def test_error_list_count(sdo: Dialogue, parameters: Parameters, value: int) -> None:
    """1003h:00 refuses every value but 0, with 06090030h, and stays."""
    sdo.device.permits.require_write(ERROR_LIST)
    before = parameters.present(COUNT)
    sdo.send(DownloadInitiate.with_data(COUNT, bytes([value])))
    try:
        sdo.expect_abort(*communication.ERROR_LIST_COUNT.codes, of=COUNT)
    except Violation:
        sdo.try_download(COUNT, b"\0")  # a number that was taken would stay
        raise
    if (found := sdo.upload(COUNT)) != before:
        raise sdo.breach(f"{COUNT} reads {before.hex()} as before", said("{}", found.hex()))


# COB-IDs


@must("communication.restricted-identifier", entry=COB_ID_ENTRIES)
def test_restricted_identifier(sdo: Dialogue, parameters: Parameters, entry: CobIdEntry) -> None:
    """SYNC, TIME, EMCY and PDOs refuse CAN-IDs that are kept for other services.

    Of each range both ends are tried, but not those on which the device itself is served.
    """
    node_id = sdo.device.node_id
    own = {base + node_id for base in (RESPONSE_BASE, REQUEST_BASE, ERROR_CONTROL_BASE)}
    with parameters.out_of_use(entry) as before:
        for can_id in KEPT_FOR_OTHERS:
            if can_id in own:
                continue
            for value in entry.ways_of_using(before, can_id):
                refuse_cob_id(sdo, entry, value, communication.RESTRICTED_IDENTIFIER)


@must("communication.identifier-bits", entry=COB_ID_ENTRIES)
def test_identifier_bits(sdo: Dialogue, parameters: Parameters, entry: CobIdEntry) -> None:
    """A COB-ID of 11 bits with bits 28 to 11 set is refused."""
    with parameters.out_of_use(entry) as before:
        refuse_cob_id(
            sdo, entry, entry.using(before, FREE_ID) | STRAY_BIT, communication.IDENTIFIER_BITS
        )


@must("communication.valid-keeps-identifier", entry=COB_ID_ENTRIES)
def test_valid_keeps_identifier(sdo: Dialogue, parameters: Parameters, entry: CobIdEntry) -> None:
    """A COB-ID that is in use does not change."""
    with parameters.out_of_use(entry) as before:
        parameters.require_used(entry, before)
        wanted = before & ~0x1FFF_FFFF | (FREE_ID if before & 0x7FF != FREE_ID else FREE_ID + 1)
        refuse_cob_id(sdo, entry, wanted, communication.VALID_KEEPS_IDENTIFIER)


def refuse_cob_id(sdo: Dialogue, entry: CobIdEntry, value: int, rule: Rule) -> None:
    """Write a COB-ID that has to be refused, and see that it is not there."""
    sdo.send(DownloadInitiate.with_data(entry.mux, value.to_bytes(4, "little")))
    sdo.expect_abort(*rule.codes, of=entry.mux)
    if number_of(sdo.upload(entry.mux)) == value:
        raise sdo.breach(
            f"{entry.mux} as before", other_data(f"it reads {value:08X}h though it was refused")
        )


@may("communication.extended-bit", "communication.optional-bits", entry=COB_ID_ENTRIES)
def test_extended_bit(sdo: Dialogue, parameters: Parameters, entry: CobIdEntry) -> None:
    """A CAN-ID of 29 bits (bit 29) is taken and reads back, or refused."""
    with parameters.out_of_use(entry) as before:
        flags = entry.unused(before) & ~LARGEST_EXTENDED_ID
        take_or_refuse(sdo, entry, flags | EXTENDED | LONG_ID)


@may("communication.sync-producer", "communication.optional-bits")
def test_sync_producer(sdo: Dialogue, parameters: Parameters) -> None:
    """Bit 30 of 1005h, by which a device produces SYNC, is taken and reads back, or refused.

    Nothing is sent meanwhile: the period (1006h) is 0.
    """
    entry = COB_ID_ENTRIES["1005h"]
    with suppress(Unimplemented):
        if any(parameters.present(SYNC_PERIOD)):
            raise NotTestable(f"{SYNC_PERIOD} is not 0: the device would send SYNC")
    with parameters.out_of_use(entry) as before:
        take_or_refuse(sdo, entry, entry.unused(before) | entry.in_use)


@may("communication.remote-bit", "communication.optional-bits")
def test_remote_bit(sdo: Dialogue, parameters: Parameters) -> None:
    """Bit 30 of 1800h:01 (no remote frames), set or not, is taken and reads back, or refused."""
    entry = COB_ID_ENTRIES["1800h"]
    with parameters.out_of_use(entry) as before:
        unused = entry.unused(before)
        for value in (unused ^ NO_REMOTE_FRAMES, unused):
            take_or_refuse(sdo, entry, value)


def take_or_refuse(sdo: Dialogue, entry: CobIdEntry, value: int) -> None:
    """Write a COB-ID that a device may take or refuse; what it takes, reads back."""
    rule = communication.OPTIONAL_BITS
    abort = sdo.try_download(entry.mux, value.to_bytes(4, "little"))
    if abort is not None:
        sdo.take_abort(abort, rule.codes, entry.mux, rule.tolerated)
    elif (found := number_of(sdo.upload(entry.mux))) != value:
        raise sdo.breach(
            f"{entry.mux} reads {value:08X}h, which it has taken",
            other_data(f"it reads {found:08X}h"),
        )


# PDOs


@must("communication.transmission-type", pdo=PDOS)
def test_transmission_type(sdo: Dialogue, parameters: Parameters, pdo: CobIdEntry) -> None:
    """A reserved transmission type, which no device can support, is refused with 06090030h."""
    mux = Multiplexer(pdo.mux.index, 2)
    with parameters.out_of_use(pdo):
        before = parameters.present(mux)
        parameters.write_if_configurable(mux, before)
        sdo.send(DownloadInitiate.with_data(mux, bytes([RESERVED_TYPE])))
        sdo.expect_abort(*communication.TRANSMISSION_TYPE.codes, of=mux)
        if (found := sdo.upload(mux)) != before:
            raise sdo.breach(f"{mux} reads {before.hex()} as before", said("{}", found.hex()))


@must("communication.mapped-object", pdo=PDOS)
def test_mapped_object(sdo: Dialogue, parameters: Parameters, pdo: CobIdEntry) -> None:
    """An object that does not exist is not mapped: the entry is refused, or the number of them."""
    missing = missing_object(sdo)
    with parameters.free_mapping(pdo) as (count, _):
        entries = [int(Mapped(missing, bits=8))]
        parameters.expect_not_mapped(count, entries, communication.MAPPED_OBJECT)


@must("communication.mapped-length", pdo=PDOS)
def test_mapped_length(sdo: Dialogue, parameters: Parameters, pdo: CobIdEntry) -> None:
    """More than 8 bytes are not mapped: an entry is refused, or the number of them."""
    with parameters.free_mapping(pdo) as (count, mapped):
        if not mapped or not mapped[0] & 0xFF:
            raise NotTestable(f"{count} maps nothing: map an object")
        entry = max(mapped, key=lambda each: each & 0xFF)
        entries = [entry] * (MOST_BITS // (entry & 0xFF) + 1)
        parameters.expect_not_mapped(count, entries, communication.MAPPED_LENGTH)
