"""SDO server parameters, 1200h to 127Fh: which channels there are, how they are configured."""

from conformance.device.device import VENDOR_ID, Device
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Unimplemented
from conformance.dialogue.by_itself import judge_kept
from conformance.dialogue.changing import changes_by_itself
from conformance.dialogue.channels import (
    CLIENT,
    COUNT,
    DEFAULT_RECORD,
    LAST_RECORD,
    LONG_CHANNEL,
    NOT_THERE,
    REQUEST,
    RESPONSE,
    TEST_CHANNELS,
    Channels,
)
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.values import of_another_length
from conformance.run.case import may, must
from conformance.run.risks import EXTENDED
from conformance.sdo.checks import ServerAborted
from conformance.sdo.cob_id import RESTRICTED, ChannelIds, CobId
from conformance.sdo.frames import DownloadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import Access, DataType
from conformance.sdo.rules.channels import (
    CLIENT_NODE_ID,
    DEFAULT_READ_ONLY,
    ENTRY_COUNT,
    EXTENDED_IDENTIFIER,
    IDENTIFIER_BITS,
    MISSING,
    RESTRICTED_IDENTIFIER,
    SAME_IDENTIFIER,
    VALID_KEEPS_IDENTIFIER,
)
from conformance.sdo.seen import Received, Said, other_data, said

RECORD = "7.5.2.33"
HALVES = {"request": REQUEST, "response": RESPONSE}
EDGES = {f"{can_id:03X}h": can_id for edges in RESTRICTED for can_id in edges}
FIRST, SECOND = TEST_CHANNELS


def default_value(sdo: Dialogue, sub_index: int) -> bytes:
    """Read an entry of 1200h; a device that has none gets a remark and no failure."""
    mux = Multiplexer(DEFAULT_RECORD, sub_index)
    known = KnownObject(mux, DataType.UNSIGNED32 if sub_index else DataType.UNSIGNED8, Access.CONST)
    try:
        found = sdo.read(known)
    except ServerAborted as aborted:
        refused = Received(aborted.abort)
        if aborted.abort.code not in NOT_THERE:
            raise sdo.breach(f"{mux} to be served, or 06020000h", refused) from aborted
        raise Unimplemented(refused) from aborted
    if len(found) != known.length:
        raise of_another_length(known, found)
    return found


def write(sdo: Dialogue, parameters: Parameters, index: int, sub_index: int, data: bytes) -> None:
    """Send a write to an entry of a record, whose value is put back after the case."""
    mux = Multiplexer(index, sub_index)
    parameters.learn(mux)
    sdo.send(DownloadInitiate.with_data(mux, data))


def expect_cob_id(sdo: Dialogue, index: int, sub_index: int, due: CobId) -> None:
    """Expect a COB-ID of a record to read as ``due``."""
    found = Channels(sdo).cob_id(index, sub_index)
    if found != due:
        mux = Multiplexer(index, sub_index)
        raise sdo.breach(
            f"{mux} reads {bytes(due)[::-1].hex().upper()}h",
            other_data(f"{mux} reads {bytes(found)[::-1].hex().upper()}h"),
        )


# The default channel


@must("channel.default-parameter", half=HALVES)
def test_default_parameter(sdo: Dialogue, device: Device, half: int) -> None:
    """1200h tells the COB-IDs of the default channel: 600h and 580h plus node-ID, nothing else."""
    default = ChannelIds.default(device.node_id)
    due = bytes(default.request if half == REQUEST else default.response)
    found = default_value(sdo, half)
    if found != due:
        raise sdo.breach(f"1200h:{half:02X} reads {due.hex(' ')}", said("{}", found.hex(" ")))


@must("channel.default-count", "channel.default-parameter")
def test_default_count(sdo: Dialogue) -> None:
    """1200h has two entries behind its sub-index 00h."""
    found = default_value(sdo, COUNT)
    if found[:1] != b"\2":
        raise sdo.breach("1200h:00 reads 02", said("{}", found.hex(" ")))


@must("channel.default-constant", "channel.default-read-only", sub_index=[COUNT, REQUEST, RESPONSE])
def test_default_constant(
    sdo: Dialogue, parameters: Parameters, channels: Channels, sub_index: int
) -> None:
    """No entry of 1200h can be written: the default channel can be neither disabled nor moved.

    A device that refuses its own value is then offered others.
    """
    before = default_value(sdo, sub_index)
    channels.require_parameters()
    others = (bytes([before[0] ^ 1]) + before[1:], before[:-1] + bytes([before[-1] | 0x80]))
    for value in (before, *others):
        write(sdo, parameters, DEFAULT_RECORD, sub_index, value)
        sdo.expect_abort(*DEFAULT_READ_ONLY.codes, of=Multiplexer(DEFAULT_RECORD, sub_index))
        if default_value(sdo, sub_index) != before:
            raise sdo.breach(f"1200h:{sub_index:02X} reads {before.hex(' ')} as before", "it moved")


# Further channels: are there any?


@must("channel.missing-refused", "channel.missing")
def test_missing_refused(sdo: Dialogue, channels: Channels) -> None:
    """A record that the device has not is refused as a missing object; silence is a failure."""
    found = channels.records()
    for index in dict.fromkeys((DEFAULT_RECORD + 1 + len(found), LAST_RECORD)):
        mux = Multiplexer(index, REQUEST)
        try:
            sdo.read(mux)
        except ServerAborted as aborted:
            sdo.take_abort(aborted.abort, MISSING.codes, mux)


@must("channel.count", "channel.entry-count")
def test_count(sdo: Dialogue, channels: Channels) -> None:
    """Sub-index 00h of a further record is 02h or, with a client's node-ID, 03h."""
    (index,) = channels.require_records()
    found = sdo.upload(Multiplexer(index, COUNT))
    if found[:1] not in (b"\2", b"\3"):
        raise sdo.breach(f"{index:04X}h:00 reads 02 or 03", said("{}", found.hex(" ")))
    for sub_index in range(1, found[0] + 1):
        sdo.upload(Multiplexer(index, sub_index))


@must("channel.count-constant", "channel.entry-count")
def test_count_constant(sdo: Dialogue, parameters: Parameters, channels: Channels) -> None:
    """Sub-index 00h of a further record cannot be written."""
    (index,) = channels.require()
    mux = Multiplexer(index, COUNT)
    for value in (sdo.upload(mux)[:1], b"\0", b"\x01"):
        write(sdo, parameters, index, COUNT, value)
        sdo.expect_abort(*ENTRY_COUNT.codes, of=mux)


# Configuring one


@must("channel.configured", "channel.valid-keeps-identifier")
def test_configured(sdo: Dialogue, channels: Channels) -> None:
    """A channel that was given two COB-IDs and enabled reads back so and serves, beside 1200h."""
    (index,) = channels.require()
    with channels.further() as other:
        expect_cob_id(sdo, index, REQUEST, FIRST.request)
        expect_cob_id(other, index, RESPONSE, FIRST.response)
        for mux in sdo.device.briefly_read():
            due, found = sdo.upload(mux), other.upload(mux)
            if found != due and not changes_by_itself(sdo, mux):
                raise sdo.breach(
                    f"{mux} reads {due.hex(' ')} on both channels", said("{}", found.hex(" "))
                )


@must("channel.own-identifier", "channel.independent", "response.frame", clause=RECORD)
def test_own_identifier(sdo: Dialogue, channels: Channels) -> None:
    """What was asked on a channel is answered on its own response identifier and on no other."""
    with channels.further() as other:
        other.fence()
        stray = sdo.drain()
        if stray:
            raise sdo.breach(f"nothing on {sdo.channel.ids.response}", Said(str(stray[0]), "…#…"))


@must("channel.configured-by-itself", "channel.independent", clause=RECORD)
def test_default_configured_on_other(sdo: Dialogue, channels: Channels) -> None:
    """A second channel can be configured on the first further one: all reach the same objects."""
    _, index = channels.require(2)
    with channels.further() as other:
        Channels(other).configure(index, SECOND)
        with channels.on(SECOND) as third:
            third.fence()
        expect_cob_id(sdo, index, RESPONSE, SECOND.response)


@must("channel.half-valid", "channel.valid-keeps-identifier", half=HALVES)
def test_half_valid(channels: Channels, half: int) -> None:
    """A channel exists when bit 31 is 0 in both COB-IDs: with one of them it answers nothing."""
    (index,) = channels.require()
    channels.configure(index, FIRST)
    channels.disable(Multiplexer(index, half))
    channels.expect_no_server(FIRST)


@must("channel.disabled", "channel.valid-keeps-identifier")
def test_disabled(channels: Channels) -> None:
    """A channel that was disabled answers nothing any more, and serves again when enabled."""
    (index,) = channels.require()
    with channels.further() as other:
        other.fence()
        channels.disable_channel(index)
        channels.expect_no_server(FIRST)
        channels.configure(index, FIRST)


@must("channel.moved", "channel.valid-keeps-identifier")
def test_moved(channels: Channels) -> None:
    """A channel that got other COB-IDs serves on these and on the old ones no more."""
    (index,) = channels.require()
    with channels.further() as other:
        other.fence()
        channels.configure(index, SECOND)
        with channels.on(SECOND):
            channels.expect_no_server(FIRST)
        channels.configure(index, FIRST)


@must("channel.moved-while-valid", "channel.valid-keeps-identifier", half=HALVES)
def test_moved_while_valid(
    sdo: Dialogue, parameters: Parameters, channels: Channels, half: int
) -> None:
    """The CAN-ID of a channel in use cannot be changed: it has to be disabled before."""
    (index,) = channels.require()
    with channels.further() as other:
        wanted = SECOND.request if half == REQUEST else SECOND.response
        before = FIRST.request if half == REQUEST else FIRST.response
        write(sdo, parameters, index, half, bytes(wanted))
        sdo.expect_abort(*VALID_KEEPS_IDENTIFIER.codes, of=Multiplexer(index, half))
        expect_cob_id(sdo, index, half, before)
        other.fence()


@may("channel.same-value-while-valid", "channel.same-identifier")
def test_same_value_while_valid(sdo: Dialogue, channels: Channels) -> None:
    """A COB-ID in use may be written with its own value; it may also be refused. It stays."""
    (index,) = channels.require()
    with channels.further() as other:
        abort = channels.try_cob_id(index, REQUEST, FIRST.request)
        if abort is not None and abort.code not in SAME_IDENTIFIER.codes:
            raise sdo.breach("a confirmation or 06090030h", Received(abort))
        expect_cob_id(sdo, index, REQUEST, FIRST.request)
        other.fence()


@must("channel.stray-bits", "channel.identifier-bits", bit=[11, 20, 28])
def test_stray_bits(sdo: Dialogue, parameters: Parameters, channels: Channels, bit: int) -> None:
    """Bits 28 to 11 of a COB-ID with an 11-bit CAN-ID are 0: others are refused."""
    (index,) = channels.require()
    channels.disable_channel(index)
    before = channels.cob_id(index, REQUEST)
    write(
        sdo, parameters, index, REQUEST, bytes(CobId(FIRST.request.can_id | 1 << bit, valid=False))
    )
    sdo.expect_abort(*IDENTIFIER_BITS.codes, of=Multiplexer(index, REQUEST))
    expect_cob_id(sdo, index, REQUEST, before)
    write(sdo, parameters, index, REQUEST, bytes(CobId(FIRST.request.can_id | 1 << bit)))
    sdo.expect_abort(*IDENTIFIER_BITS.codes, of=Multiplexer(index, REQUEST))
    expect_cob_id(sdo, index, REQUEST, before)


@must("channel.restricted", "channel.restricted-identifier", can_id=EDGES)
def test_restricted(sdo: Dialogue, parameters: Parameters, channels: Channels, can_id: int) -> None:
    """A CAN-ID of another service cannot be put into use, neither at once nor in two steps."""
    (index,) = channels.require()
    channels.disable_channel(index)
    for sub_index in (REQUEST, RESPONSE):
        write(sdo, parameters, index, sub_index, bytes(CobId(can_id)))
        sdo.expect_abort(*RESTRICTED_IDENTIFIER.codes, of=Multiplexer(index, sub_index))
        write(sdo, parameters, index, sub_index, bytes(CobId(can_id, valid=False)))
        if not channels.refused_value(index, sub_index):
            write(sdo, parameters, index, sub_index, bytes(CobId(can_id)))
            sdo.expect_abort(*RESTRICTED_IDENTIFIER.codes, of=Multiplexer(index, sub_index))
        if channels.cob_id(index, sub_index).valid:
            raise sdo.breach(f"{can_id:03X}h not in use", "bit 31 is 0 though it was refused")


@may("channel.dynamic", "channel.dynamic-bit")
def test_dynamic(sdo: Dialogue, parameters: Parameters, channels: Channels) -> None:
    """Bit 30 (assigned dynamically, once reserved) may be taken or refused; the channel serves."""
    (index,) = channels.require()
    channels.disable_channel(index)
    wanted = CobId(FIRST.request.can_id, valid=False, dynamic=True)
    write(sdo, parameters, index, REQUEST, bytes(wanted))
    if not channels.refused_value(index, REQUEST):
        expect_cob_id(sdo, index, REQUEST, wanted)
        write(sdo, parameters, index, REQUEST, bytes(CobId(FIRST.request.can_id, valid=False)))
        channels.refused_value(index, REQUEST)
    channels.configure(index, FIRST)
    with channels.on(FIRST) as other:
        other.fence()


@must("channel.extended", "channel.extended-identifier", risk=EXTENDED)
def test_extended(sdo: Dialogue, parameters: Parameters, channels: Channels) -> None:
    """A channel with 29-bit CAN-IDs serves on these; a device that cannot refuses bit 29."""
    (index,) = channels.require()
    channels.disable_channel(index)
    write(sdo, parameters, index, REQUEST, bytes(LONG_CHANNEL.request.disabled()))
    if (refused := channels.take_confirmation(index, REQUEST)) is not None:
        sdo.take_abort(refused, EXTENDED_IDENTIFIER.codes, Multiplexer(index, REQUEST))
        raise Unimplemented(Received(refused))
    channels.configure(index, LONG_CHANNEL)
    with channels.on(LONG_CHANNEL) as other:
        known, data = Room(other).long_object()
        sdo.expect_value(known, data)
        expect_cob_id(other, index, REQUEST, LONG_CHANNEL.request)


@must("channel.extended-is-another", "channel.extended-ignored", clause=RECORD, risk=EXTENDED)
def test_extended_is_another(sdo: Dialogue, channels: Channels) -> None:
    """A 29-bit frame with the number of an 11-bit request identifier is no request of it."""
    with channels.further() as other:
        request = FIRST.request
        extended = ChannelIds(CobId(request.can_id, True), FIRST.response)
        with channels.listen_on(extended) as wrong:
            wrong.send(UploadInitiate(VENDOR_ID.mux))
        stray = other.fence()
        if stray:
            raise sdo.breach("no answer to the 29-bit frame", Received(stray[0]))


@must("channel.client-node-id", value={"0": 0, "128": 128, "255": 255})
def test_client_node_id(
    sdo: Dialogue, parameters: Parameters, channels: Channels, value: int
) -> None:
    """Sub-index 03h takes node-IDs from 1 to 127 and nothing else."""
    index = channels.require_client_entry()
    mux = Multiplexer(index, CLIENT)
    parameters.learn(mux)
    for good in (127, 1):
        sdo.download(mux, bytes((good,)))
    write(sdo, parameters, index, CLIENT, bytes((value,)))
    sdo.expect_abort(*CLIENT_NODE_ID.codes, of=mux)
    if (found := sdo.upload(mux)[:1]) != b"\1":
        raise sdo.breach(f"{mux} reads 01 as before", said("{}", found.hex()))


@must("channel.reset-restores", "channel.after-reset")
def test_reset_restores(sdo: Dialogue, network: Network, channels: Channels) -> None:
    """After a reset of the communication the records hold their power-on values.

    Those of a device that stores them by itself are what was written last.
    """
    (index,) = channels.require()
    network.reset(NmtCommand.RESET_COMMUNICATION)

    def present() -> list[CobId]:
        return [channels.cob_id(index, half) for half in (REQUEST, RESPONSE)]

    due = present()
    channels.configure(index, FIRST if due[0].can_id != FIRST.request.can_id else SECOND)
    new = present()
    network.reset(NmtCommand.RESET_COMMUNICATION)
    if present() == new:
        expected = f"{index:04X}h as before it was configured"
        judge_kept(
            sdo, network, lambda: present() == new, expected, said("{} is kept", f"{index:04X}h")
        )
        return
    for half, value in zip((REQUEST, RESPONSE), due, strict=True):
        expect_cob_id(sdo, index, half, value)
