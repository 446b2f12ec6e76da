"""Access, lengths and existence in the other NMT state in which a server serves (CiA 301, 7.3.2).

Most cases run in Pre-operational. A server may check requests there, and not in Operational, where
it has other code in use. Each case here goes there once, for a few objects of all kinds; where a
device serves more in Operational, and the other cases run there, these run in Pre-operational.
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress

from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.effort import SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.network import Network
from conformance.dialogue.object_expectations import (
    codes_of_refusal,
    expect_kept,
    expect_write_refused,
    expect_written_back,
    may_be_probed,
    may_be_written,
    value_of,
)
from conformance.dialogue.values import of_another_length, same_value
from conformance.model_cases.conversations.conversation import Kind
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.model_cases.elsewhere import CONVERSATIONS, LONG, expect_carried, require_writes
from conformance.model_cases.matrix.field import perform_stimulus
from conformance.model_cases.matrix.sample import Field, risk_of, sample
from conformance.run import object_choices as choose
from conformance.run.case import must
from conformance.run.risks import LOST_SEGMENT
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import shown
from conformance.sdo.frames import BlockUploadInitiate, DownloadInitiate, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import MISSING_REFUSED
from conformance.sdo.rules.download_initiates import TOO_LONG, TOO_SHORT
from conformance.sdo.rules.idle import READ_ONLY, SUB_INDEX_MISSING, WRITE_ONLY
from conformance.sdo.seen import Data

STATES = ("nmt.operational", "nmt.pre-operational")
# So many objects of a kind each, and of a few kinds, stand for all.
MOST_KINDS = 6
EXPEDITED = 4


def some(device: Device, entries: Iterable[KnownObject]) -> list[KnownObject]:
    """Return an entry of each type, of a few types, that was read and is short."""
    kinds: dict[object, KnownObject] = {}
    for entry in entries:
        if 0 < len(device.values.get(entry.mux, b"")) <= SHORT_VALUE:
            kinds.setdefault((entry.data_type, entry.mux.index >> 12), entry)
    return list(kinds.values())[:MOST_KINDS]


def permitted(
    device: Device,
    entries: Iterable[KnownObject],
    check: Callable[[Device, KnownObject], None],
) -> Sequence[KnownObject]:
    """Return some of the entries that ``check`` permits; raises NotTestable for none."""
    refusals: list[NotTestable] = []
    found: list[KnownObject] = []
    for entry in entries:
        try:
            check(device, entry)
        except NotTestable as refusal:
            refusals.append(refusal)
        else:
            found.append(entry)
    if not found:
        raise refusals[0] if refusals else NotTestable("needs objects of this kind: none is listed")
    return some(device, found)


def expect_refused(
    sdo: Dialogue, blocks: Blocks, entry: KnownObject, data: bytes, *codes: AbortCode
) -> None:
    """Expect a download to be refused by each protocol, and the value to stay."""
    value = sdo.upload(entry)
    codes = codes_of_refusal(entry, data, *codes)
    expect_write_refused(sdo, entry, data, *codes)
    if len(data) <= EXPEDITED:  # else it went in segments
        sdo.expect_download_refused(entry, data, *codes, size=len(data))
    with suppress(Unimplemented):
        blocks.expect_download_refused(entry, data, *codes, size=len(data))
    expect_kept(sdo, entry, value)


@must("other-state.read", "dictionary.access", *STATES, "data.type-length", "block-upload.end")
def test_read(sdo: Dialogue, blocks: Blocks, device: Device, network: Network) -> None:
    """What reads in one state reads in the other, with the length of its type, and in blocks."""
    entries = some(device, choose.readable(device.listing).values())
    with network.in_other_state():
        for entry in entries:
            found, due = sdo.upload(entry), value_of(device, entry)
            if entry.length not in (None, len(found)):
                raise of_another_length(entry, found)
            constant = device.is_constant(entry.mux)
            if constant and not same_value(entry, found, due):
                raise sdo.breach(f"{entry} reads {shown(due)}", Data(found, entry))
            with suppress(Unimplemented):
                blocks.require_upload()
                in_blocks = sdo.of_its_length(entry, blocks.upload(entry))
                if entry.is_steady and not same_value(entry, in_blocks, found):
                    raise sdo.breach(f"{entry} reads {shown(found)}", Data(in_blocks))


@must("other-state.write-back", "dictionary.access", *STATES)
def test_write_back(sdo: Dialogue, device: Device, network: Network) -> None:
    """A writable entry takes the value that it has."""
    entries = permitted(device, choose.writable(device.listing).values(), may_be_written)
    with network.in_other_state():
        for entry in entries:
            value = sdo.upload(entry)
            expect_written_back(sdo, entry, sdo.try_download(entry, value), value)


@must("other-state.read-only", "object.read-only", *STATES)
def test_read_only(sdo: Dialogue, blocks: Blocks, device: Device, network: Network) -> None:
    """A read-only entry refuses even the value that it has, by each protocol."""
    entries = permitted(device, choose.protected(device.listing).values(), may_be_probed)
    with network.in_other_state():
        for entry in entries:
            expect_refused(sdo, blocks, entry, sdo.upload(entry), *READ_ONLY.codes)


@must("other-state.write-only", "object.write-only", *STATES)
def test_write_only(
    sdo: Dialogue, blocks: Blocks, network: Network, write_only: KnownObject
) -> None:
    """The upload of a write-only entry is aborted as such, by each protocol."""
    with network.in_other_state():
        sdo.send(UploadInitiate(write_only.mux))
        sdo.expect_abort(*WRITE_ONLY.codes, of=write_only)
        with suppress(Unimplemented):
            blocks.require_upload()
            sdo.send(BlockUploadInitiate(write_only.mux, 127))
            sdo.expect_abort(*WRITE_ONLY.codes, of=write_only)


@must("other-state.too-long", "download.too-long", *STATES)
def test_too_long(sdo: Dialogue, blocks: Blocks, device: Device, network: Network) -> None:
    """One byte more than the type has is refused, and the value stays."""
    entries = permitted(device, choose.writable_numbers(device.listing).values(), may_be_written)
    with network.in_other_state():
        for entry in entries:
            expect_refused(sdo, blocks, entry, sdo.upload(entry) + b"\0", *TOO_LONG.codes)


@must("other-state.too-short", "download.too-short", *STATES)
def test_too_short(sdo: Dialogue, blocks: Blocks, device: Device, network: Network) -> None:
    """One byte less than the type has is refused, and the value stays."""
    entries = permitted(device, choose.longer_than_a_byte(device.listing).values(), may_be_written)
    with network.in_other_state():
        for entry in entries:
            expect_refused(sdo, blocks, entry, sdo.upload(entry)[:-1], *TOO_SHORT.codes)


@must("other-state.limits", "object.limits", *STATES)
def test_limits(sdo: Dialogue, device: Device, network: Network) -> None:
    """What is beyond a limit is refused, and the value stays."""
    limited = choose.exceedable(device.listing) | choose.undercuttable(device.listing)
    entries = permitted(device, limited.values(), may_be_written)
    codes = (AbortCode.VALUE_TOO_HIGH, AbortCode.VALUE_TOO_LOW, AbortCode.VALUE_INVALID)
    with network.in_other_state():
        for entry in entries:
            value = sdo.upload(entry)
            for data in (choose.above(entry), choose.below(entry)):
                if data is not None:
                    expect_write_refused(sdo, entry, data, *codes)
            expect_kept(sdo, entry, value)


@must("other-state.object-missing", "object.missing-refused", *STATES)
def test_object_missing(sdo: Dialogue, blocks: Blocks, network: Network) -> None:
    """An object that the device lacks is refused as missing, whatever is asked of it."""
    missing = missing_object(sdo)
    with network.in_other_state():
        _expect_missing(sdo, blocks, missing, *MISSING_REFUSED.codes)


@must("other-state.sub-index-missing", "object.sub-index-missing", *STATES)
def test_sub_index_missing(sdo: Dialogue, blocks: Blocks, network: Network) -> None:
    """A sub-index that an object lacks is refused as missing, whatever is asked of it."""
    missing = missing_sub_index(sdo, DEVICE_TYPE.index)
    with network.in_other_state():
        _expect_missing(sdo, blocks, missing, *SUB_INDEX_MISSING.codes)


def _expect_missing(sdo: Dialogue, blocks: Blocks, missing: Multiplexer, *codes: AbortCode) -> None:
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*codes, of=missing)
    with suppress(Unimplemented):
        blocks.require_upload()
        sdo.send(BlockUploadInitiate(missing, 127))
        sdo.expect_abort(*codes, of=missing)
    sdo.send(DownloadInitiate.with_data(missing, bytes(4)))
    sdo.expect_abort(*codes, of=missing)


# Transfers, right and wrong ones


@must(
    "other-state.frame",
    "response.specifier",
    "response.answered",
    "server.idle-afterwards",
    *STATES,
    risk=risk_of,
    field=sample(turn=0),
)
def test_frame(sdo: Dialogue, text: KnownObject, network: Network, field: Field) -> None:
    """In the other NMT state, a frame in a state of the server gets an answer allowed there."""
    with network.in_other_state():
        require_writes(sdo)
        perform_stimulus(field.state, field.stimulus, sdo, text)


@must("other-state.long", "upload.size", "block-upload.next-sub-block", *STATES, protocol=LONG)
def test_long(
    sdo: Dialogue, room: Room, variable: KnownObject, network: Network, protocol: int
) -> None:
    """In the other NMT state, a long value is written and read, in segments and in blocks."""
    data = sdo.payload(room.fit(variable, protocol, least=8))
    with network.in_other_state():
        require_writes(sdo)
        expect_carried(sdo, variable, data, in_blocks=protocol == LONG["block"])


@must(
    "other-state.conversation",
    "upload.size",
    "server.idle-afterwards",
    "server.value-kept",
    *STATES,
    risk=LOST_SEGMENT,
    kind=CONVERSATIONS,
)
def test_conversation(
    sdo: Dialogue, conversations: ConversationSearch, network: Network, kind: Kind
) -> None:
    """In the other NMT state, random transfers carry their values, disturbed or not."""
    with network.in_other_state():
        require_writes(sdo)
        conversations.run(kind)
