"""Objects of the communication: their types and defaults, and values that they refuse (7.5.2)."""

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.protected_objects import CLEAR_ERRORS, NMT, STORE_PARAMETERS
from conformance.device.safety import IDENTITY
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.object_expectations import expect_write_refused
from conformance.dialogue.parameters import COB_ID_ENTRIES, PRODUCES, Parameters, number_of
from conformance.dialogue.storage import Storage, require_command, write_signature
from conformance.dialogue.values import of_another_length
from conformance.run.case import must
from conformance.sdo.checks import ServerAborted
from conformance.sdo.cob_id import EXTENDED, LARGEST_EXTENDED_ID
from conformance.sdo.describe import shown
from conformance.sdo.emergency import ERROR_LIST, ERROR_REGISTER
from conformance.sdo.fixed_objects import FIXED_OBJECTS, FixedObject
from conformance.sdo.frames import DownloadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import EMERGENCY_BASE, NmtCommand
from conformance.sdo.rules import Rule, Violation
from conformance.sdo.rules.communication_values import (
    CONSUMED_TWICE,
    ERROR_BEHAVIOUR,
    LATEST_FIRST,
    SYNC_COUNTER,
    SYNC_COUNTER_IN_USE,
)
from conformance.sdo.rules.idle import READ_ONLY, SUB_INDEX_MISSING
from conformance.sdo.seen import Data, Said, said
from conformance.sdo.storage_commands import SAVE_ALL

SYNC_ID = 0x080
CONSUMED = Multiplexer(0x1016)
SYNC, PERIOD, OVERFLOW = Multiplexer(0x1005), Multiplexer(0x1006), Multiplexer(0x1019)
BEHAVIOUR = Multiplexer(0x1029, 1)
IDENTIFIER = LARGEST_EXTENDED_ID | EXTENDED
LISTED = Multiplexer(ERROR_LIST)
DATE, TIME = Multiplexer(0x1020, 1), Multiplexer(0x1020, 2)
# In microseconds: nothing is sent while 1005h does not say that SYNC is produced.
A_PERIOD = (1_000_000).to_bytes(4, "little")
# In milliseconds: the longest that an entry of 1016h has room for, and the one before.
LONG_TIMES = (0xFFFF, 0xFFFE)
# Of rows of objects that are alike the first stands for all.
FIXED = {
    f"{fixed.indices[0]:04X}h": fixed
    for fixed in FIXED_OBJECTS
    if any(entry.data_type is not None and entry.data_type.length for _, entry in fixed)
}
BOUNDED = {
    f"{fixed.indices[0]:04X}h": fixed
    for fixed in FIXED_OBJECTS
    if fixed.first_forbidden is not None
}
# Of what is read-only, these objects need no permission of their own.
READ_ONLY_OBJECTS = {
    f"{fixed.indices[0]:04X}h": fixed for fixed in FIXED_OBJECTS if fixed.indices[0] in IDENTITY
}


@must("communication.type", "data.type-length", clause="7.5.2", of=FIXED)
def test_type(sdo: Dialogue, parameters: Parameters, of: FixedObject) -> None:
    """An object that CiA 301 defines has as many bytes as the type there has."""
    index = of.indices[0]
    first = parameters.present(Multiplexer(index))
    for sub_index, entry in of:
        if sub_index > (first[0] if len(first) == 1 else 0):
            break
        mux = Multiplexer(index, sub_index)
        if entry.data_type is None or entry.data_type.length is None:
            continue
        try:
            data = first if sub_index == 0 else sdo.read(mux)
        except ServerAborted:
            continue  # whether it has to be there is not the question
        if len(data) != entry.data_type.length:
            raise of_another_length(KnownObject(mux, entry.data_type), data)


@must("communication.no-further-entry", "object.sub-index-missing", clause="7.5.2", of=BOUNDED)
def test_no_further_entry(sdo: Dialogue, parameters: Parameters, of: FixedObject) -> None:
    """The first sub-index that CiA 301 gives to no such object is refused as missing: 1000h:01."""
    index = of.indices[0]
    parameters.present(Multiplexer(index))
    mux = Multiplexer(index, of.first_forbidden or 0)
    sdo.send(UploadInitiate(mux))
    sdo.expect_abort(*SUB_INDEX_MISSING.codes, of=mux)


@must("communication.read-only", "object.read-only", clause="7.5.2", of=READ_ONLY_OBJECTS)
def test_read_only(sdo: Dialogue, parameters: Parameters, of: FixedObject) -> None:
    """What CiA 301 makes read-only refuses even the value that it has."""
    index = of.indices[0]
    first = parameters.present(Multiplexer(index))
    for sub_index, entry in of:
        mux = Multiplexer(index, sub_index)
        value = first if sub_index == 0 else sdo.read_if_there(mux)
        if value is None:
            continue
        known = KnownObject(mux, entry.data_type, entry.access)
        expect_write_refused(sdo, known, value or b"\0", *READ_ONLY.codes)
        if mux != ERROR_REGISTER and (found := sdo.upload(mux)) != value:
            raise sdo.breach(f"{mux} reads {shown(value)} as before", Data(found))


@must("communication.default-identifier", entry=["1005h", "1014h"])
def test_default_identifier(
    sdo: Dialogue, device: Device, parameters: Parameters, storage: Storage, entry: str
) -> None:
    """With the defaults loaded, SYNC has the CAN-ID 080h, and EMCY has 080h plus node-ID."""
    mux = COB_ID_ENTRIES[entry].mux
    value = parameters.present(mux)
    known = device.known.get(mux)
    keeps = known is not None and not known.access.writable
    if not keeps and not device.permits.at_defaults:
        found = storage.loaded_defaults().get(mux)
        if found is None:
            raise NotTestable(f"{mux} was not served when the defaults had been loaded")
        value = found
    due = SYNC_ID if mux == SYNC else EMERGENCY_BASE + device.node_id
    if number_of(value) & IDENTIFIER != due:
        raise sdo.breach(
            f"{mux} has the CAN-ID {due:03X}h by default",
            Data(value, "it", remark=" with the defaults loaded"),
        )


@must("communication.consumed-twice")
def test_consumed_twice(sdo: Dialogue, device: Device, parameters: Parameters) -> None:
    """A second entry of 1016h for one node is refused with 06040043h, and stays 0."""
    device.permits.require_write(CONSUMED.index)
    count = parameters.present(CONSUMED)
    if not count or count[0] < 2:
        raise Unimplemented(f"1016h:00 reads {shown(count)}: there are no two entries")
    used = {device.node_id, *device.neighbours}
    for sub_index in range(1, count[0] + 1):
        used |= set(sdo.upload(Multiplexer(CONSUMED.index, sub_index))[2:3])
    node_id = next((free for free in range(127, 0, -1) if free not in used), None)
    if node_id is None:
        raise NotTestable("1016h has an entry for each node-ID")
    first, second = (Multiplexer(CONSUMED.index, sub_index) for sub_index in (1, 2))
    value, again = ((node_id << 16 | time).to_bytes(4, "little") for time in LONG_TIMES)
    parameters.write_if_configurable(second, bytes(4))
    parameters.write_if_configurable(first, value)
    expect_refused(sdo, second, again, CONSUMED_TWICE)


@must("communication.sync-counter", value=[1, 241, 255])
def test_sync_counter(sdo: Dialogue, parameters: Parameters, value: int) -> None:
    """1019h refuses 1 and 241 to 255 with 06090030h, and stays."""
    sdo.device.permits.require_write(OVERFLOW.index)
    before = parameters.present(OVERFLOW)
    stop_period(sdo, parameters)
    parameters.write_if_configurable(OVERFLOW, before)
    expect_refused(sdo, OVERFLOW, bytes([value]), SYNC_COUNTER)


@must("communication.sync-counter-in-use")
def test_sync_counter_in_use(sdo: Dialogue, parameters: Parameters) -> None:
    """1019h does not change while 1006h is not 0: that is refused with 08000022h or 08000000h."""
    sdo.device.permits.require_write(OVERFLOW.index)
    before, period = parameters.present(OVERFLOW), parameters.present(PERIOD)
    stop_period(sdo, parameters)
    parameters.write_if_configurable(OVERFLOW, before)
    if not any(period):
        if number_of(parameters.present(SYNC)) & PRODUCES:
            raise NotTestable("1005h says that SYNC is produced: a period would start that")
        period = A_PERIOD
    parameters.write_if_configurable(PERIOD, period)
    other = b"\x0a" if before != b"\x0a" else b"\x14"
    expect_refused(sdo, OVERFLOW, other, SYNC_COUNTER_IN_USE)


@must("communication.error-behaviour", value={"03h": 0x03, "7Fh": 0x7F})
def test_error_behaviour(sdo: Dialogue, parameters: Parameters, value: int) -> None:
    """1029h:01 refuses a reserved behaviour with 06090030h, and stays."""
    sdo.device.permits.require_write(BEHAVIOUR.index)
    before = parameters.present(BEHAVIOUR)
    parameters.write_if_configurable(BEHAVIOUR, before)
    expect_refused(sdo, BEHAVIOUR, bytes([value]), ERROR_BEHAVIOUR)


@must("communication.configuration-date")
def test_configuration_date(
    sdo: Dialogue, device: Device, parameters: Parameters, network: Network
) -> None:
    """The date and time of the configuration (1020h) are there after storing and a reset."""
    for permission in (NMT, STORE_PARAMETERS):
        device.permits.require(permission)
    device.permits.require_write(DATE.index)
    parameters.present(DATE)
    require_command(sdo, SAVE_ALL)
    network.reset_to_stored()
    before = {mux: sdo.upload(mux) for mux in (DATE, TIME)}
    new = {mux: bytes(byte ^ 1 for byte in value) for mux, value in before.items()}
    for mux, value in new.items():
        parameters.write_if_configurable(mux, value)
    device.contents.will_lose(before)
    write_signature(sdo, SAVE_ALL)
    network.reset(NmtCommand.RESET_NODE)
    for mux, value in new.items():
        if (found := sdo.upload(mux)) != value:
            raise sdo.breach(
                f"{mux} reads {value.hex(' ')}, as it was stored", said("{}", found.hex(" "))
            )


@must(
    "communication.emergency-listed",
    "communication.latest-error-first",
)
def test_emergency_listed(
    sdo: Dialogue, device: Device, parameters: Parameters, network: Network
) -> None:
    """An error of which the device has told by an emergency, since it has booted, is in 1003h.

    With the permission nmt it is reset before: it may tell of its errors then.
    """
    parameters.present(LISTED)
    is_reset = NMT in device.permissions
    if is_reset:
        network.reset(NmtCommand.RESET_NODE)
        sdo.fence()
    heard = sdo.channel.emergency
    if heard is None:
        raise NotTestable("no emergency of the device was heard since it has booted")
    count = sdo.upload(LISTED)
    if not any(count) and CLEAR_ERRORS in device.permissions and not is_reset:
        raise NotTestable("a case may have cleared the list since the emergency was heard")
    places = [Multiplexer(LISTED.index, place) for place in range(1, min(*count, 0xFE) + 1)]
    codes = [sdo.upload(place)[:2] for place in places]
    # What came meanwhile may be listed already.
    told = {frame.data[:2] for frame in (heard, sdo.channel.emergency) if frame is not None}
    due = f"{error_code_text(heard.data[:2])} in 1003h:01, as an emergency has told"
    listed = ", ".join(map(error_code_text, codes))
    actual = Said(listed, "…") if codes else Said("an empty list")
    if told.isdisjoint(codes):
        raise sdo.breach(due, actual)
    if codes[0] not in told:
        sdo.note(Violation(LATEST_FIRST, expected=due, actual=actual))


def error_code_text(code: bytes) -> str:
    """Write an error code as texts have it."""
    return f"{number_of(code):04X}h"


def stop_period(sdo: Dialogue, parameters: Parameters) -> None:
    """Let 1006h be 0, so that 1019h may be written; it is put back after the case."""
    period = sdo.read_if_there(PERIOD)
    if period is not None and any(period):
        parameters.write_if_configurable(PERIOD, bytes(len(period)))


def expect_refused(sdo: Dialogue, mux: Multiplexer, data: bytes, rule: Rule) -> None:
    """Write a value that has to be refused by a rule, and see that the entry keeps its own."""
    before = sdo.upload(mux)
    sdo.send(DownloadInitiate.with_data(mux, data))
    sdo.expect_abort(*rule.codes, of=mux, tolerated=rule.tolerated)
    if (found := sdo.upload(mux)) != before:
        raise sdo.breach(f"{mux} reads {before.hex(' ')} as before", said("{}", found.hex(" ")))
