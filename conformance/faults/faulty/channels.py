"""Nodes that are wrong in their SDO parameter records."""

from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About, Defect
from conformance.reference.node import Node, ServerChannel
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.channel_parameters import (
    COUNT,
    FIRST_RECORD,
    REQUEST,
    RESPONSE,
    ServerParameter,
)
from conformance.sdo.cob_id import CobId
from conformance.sdo.frames import Request, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, Entry, Refusal

fault = partial(registry.fault, about=About.CHANNELS)


class _OtherDefault(AlteredNode):
    """Changes an entry of its default record."""

    def alter(self) -> None:
        self.change(self.channels[0].record.entries)
        self.defaults = self.power_on = self.present()

    def change(self, entries: dict[int, Entry]) -> None:
        """Change an entry."""


@fault(
    "channel-default-without-node-id", Defect.ACCESS_OR_SIZE, "channel.default-parameter[request]"
)
class DefaultWithoutNodeId(_OtherDefault):
    """Says 600h in 1200h:01, whatever the node-ID is."""

    def change(self, entries: dict[int, Entry]) -> None:
        entries[REQUEST].value = bytes(CobId(0x600))


@fault("channel-default-flagged", Defect.ACCESS_OR_SIZE, "channel.default-parameter[response]")
class DefaultFlagged(_OtherDefault):
    """Says in 1200h:02 that the default channel was assigned dynamically."""

    def change(self, entries: dict[int, Entry]) -> None:
        entries[RESPONSE].value = bytes(CobId(self.response_id, dynamic=True))


@fault("channel-default-count-wrong", Defect.ACCESS_OR_SIZE, "channel.default-count")
class DefaultCountWrong(_OtherDefault):
    """Says that 1200h has three entries, of which there are two."""

    def change(self, entries: dict[int, Entry]) -> None:
        """Count the client's node-ID, which 1200h has not."""
        entries[COUNT].value = b"\3"


@fault("channel-default-writable", Defect.ACCESS_OR_SIZE, "channel.default-constant")
class DefaultWritable(_OtherDefault):
    """Takes any value for the COB-IDs in 1200h."""

    def change(self, entries: dict[int, Entry]) -> None:
        entries[REQUEST].access = entries[RESPONSE].access = Access.RW


class _Stubborn(Entry):
    """Takes every value and keeps its own."""

    def __setattr__(self, name: str, value: object) -> None:
        if name != "value" or not hasattr(self, "value"):
            super().__setattr__(name, value)


@fault("channel-default-confirms-writes", Defect.ACCESS_OR_SIZE, "channel.default-constant")
class DefaultConfirms(_OtherDefault):
    """Confirms writes to 1200h:00 and ignores them."""

    def change(self, entries: dict[int, Entry]) -> None:
        count = _Stubborn(entries[COUNT].value, entries[COUNT].data_type)
        self.objects.add({Multiplexer(FIRST_RECORD, COUNT): count})


@fault("channel-missing-silent", Defect.ROBUSTNESS, "channel.missing-refused")
class MissingSilent(Node):
    """Does not answer a read of a record that it has not."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        index = int.from_bytes(frame.data[1:3], "little")
        missing = FIRST_RECORD + len(self.channels) <= index <= 0x127F
        if frame.data[:1] == b"\x40" and missing:
            return []
        return super().serve(channel, frame)


@fault("channel-missing-wrong-code", Defect.ABORT, "channel.missing-refused")
class MissingWrongCode(Server):
    """Refuses a record that it has not with the code for a value that is out of range."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        index = self.refused_multiplexer(request).index
        missing = code is AbortCode.OBJECT_MISSING and index in range(FIRST_RECORD, 0x1300)
        return super().refuse(request, AbortCode.VALUE_INVALID if missing else code)


class _OtherRecords(Node):
    """Changes its further records when it makes them."""

    def further_record(self, number: int) -> ServerParameter:
        record = super().further_record(number)
        self.change(record.entries)
        return record

    def change(self, entries: dict[int, Entry]) -> None:
        """Change an entry."""


@fault("channel-count-beyond", Defect.ACCESS_OR_SIZE, "channel.count")
class CountBeyond(_OtherRecords):
    """Says that a further record has four entries."""

    def change(self, entries: dict[int, Entry]) -> None:
        entries[COUNT].value = b"\4"


@fault("channel-count-writable", Defect.ACCESS_OR_SIZE, "channel.count-constant")
class CountWritable(_OtherRecords):
    """Takes any value for sub-index 00h of a further record."""

    def change(self, entries: dict[int, Entry]) -> None:
        entries[COUNT].access = Access.RW


@fault("channel-count-refused-as-value", Defect.ABORT, "channel.count-constant")
class CountRefusedAsValue(Node):
    """Refuses a write to sub-index 00h as if another value would do."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        is_count = frame.data[2:4] == b"\x12\0" and frame.data[1:2] != b"\0"
        read_only = AbortCode.WRITE_OF_READ_ONLY.to_bytes(4, "little")
        invalid = AbortCode.VALUE_INVALID.to_bytes(4, "little")
        if not is_count:
            return responses
        return [data.replace(read_only, invalid) for data in responses]


@fault("channel-moved-while-valid", Defect.STATE, "channel.moved-while-valid")
class MovedWhileValid(Node):
    """Moves a channel that is in use."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        """Do not ask whether it is."""


@fault("channel-response-moved-while-valid", Defect.STATE, "channel.moved-while-valid[response]")
class ResponseMovedWhileValid(Node):
    """Lets the response identifier of a channel in use be changed."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        """Ask for requests alone, which have the lower identifiers here."""
        if before.can_id < 0x6A0:
            super().check_in_use(before, wanted)


@fault("channel-refused-but-moved", Defect.STATE, "channel.moved-while-valid")
class RefusedButMoved(Node):
    """Refuses to move a channel in use, and moves it."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        try:
            super().check_in_use(before, wanted)
        except Refusal:
            for channel in self.channels[1:]:
                for entry in channel.record.entries.values():
                    if entry.value == bytes(before):
                        entry.value = bytes(wanted)
            raise


@fault("channel-move-refused-as-missing", Defect.ABORT, "channel.moved-while-valid")
class MoveRefusedWithOtherCode(Node):
    """Refuses to move a channel in use as if there were no such object."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        try:
            super().check_in_use(before, wanted)
        except Refusal:
            raise Refusal(AbortCode.OBJECT_MISSING) from None


@fault("channel-same-value-disables", Defect.STATE, "channel.same-value-while-valid")
class SameValueDisables(Node):
    """Disables a channel in use when its COB-ID is written once more."""

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        super().check_in_use(before, wanted)
        if before.valid and before == wanted:
            for channel in self.channels[1:]:
                for entry in channel.record.entries.values():
                    if entry.value == bytes(before):
                        entry.value = bytes(before.disabled())
            raise Refusal(AbortCode.VALUE_INVALID)


@fault("channel-stray-bits-taken", Defect.FIELD_WIDTH, "channel.stray-bits")
class StrayBitsTaken(Node):
    """Takes bits 28 to 11 of a COB-ID without bit 29."""

    def check_format(self, wanted: CobId) -> None:
        """Take them."""


@fault("channel-stray-bits-cut", Defect.FIELD_WIDTH, "channel.stray-bits[28]")
class StrayBitsCut(Node):
    """Looks at bits 27 to 11 of a COB-ID without bit 29, but not at bit 28."""

    def check_format(self, wanted: CobId) -> None:
        super().check_format(CobId(wanted.can_id & ~(1 << 28), wanted.extended))


@fault("channel-restricted-taken", Defect.ACCESS_OR_SIZE, "channel.restricted")
class RestrictedTaken(Node):
    """Takes any CAN-ID for a channel."""

    def check_restricted(self, wanted: CobId) -> None:
        """Take it."""


@fault("channel-restricted-off-by-one", Defect.ACCESS_OR_SIZE, "channel.restricted[180h]")
class RestrictedOffByOne(Node):
    """Takes the last CAN-ID of each restricted range."""

    def check_restricted(self, wanted: CobId) -> None:
        super().check_restricted(CobId(wanted.can_id + 1, wanted.extended, wanted.valid))


@fault("channel-restricted-in-two-steps", Defect.STATE, "channel.restricted")
class RestrictedInTwoSteps(Node):
    """Enables a restricted CAN-ID that was written while the channel was disabled."""

    def check_cob_id(self, old: bytes, new: bytes) -> None:
        if CobId.from_bytes(old).can_id != CobId.from_bytes(new).can_id:
            super().check_cob_id(old, new)


@fault("channel-client-node-id-any", Defect.ACCESS_OR_SIZE, "channel.client-node-id")
class ClientAny(Node):
    """Takes any number for the node-ID of a client."""

    def check_client(self, old: bytes, new: bytes) -> None:
        """Take it."""


@fault("channel-client-node-id-zero", Defect.ACCESS_OR_SIZE, "channel.client-node-id[0]")
class ClientZero(Node):
    """Takes 0 for the node-ID of a client."""

    def check_client(self, old: bytes, new: bytes) -> None:
        super().check_client(old, new if new[0] else b"\1")


@fault("channel-client-node-id-small", Defect.ACCESS_OR_SIZE, "channel.client-node-id")
class ClientSmall(Node):
    """Refuses node-IDs of clients beyond 63."""

    def check_client(self, old: bytes, new: bytes) -> None:
        if new[0] > 63:
            raise Refusal(AbortCode.VALUE_TOO_HIGH)
        super().check_client(old, new)


@fault("channel-dynamic-lost", Defect.ACCESS_OR_SIZE, "channel.dynamic")
class DynamicLost(Node):
    """Confirms bit 30 of a COB-ID and forgets it."""

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        responses = super().serve(channel, frame)
        for other in self.channels[1:]:
            for sub_index in (REQUEST, RESPONSE):
                entry = other.record.entries[sub_index]
                entry.value = entry.value[:3] + bytes((entry.value[3] & 0xBF,))
        return responses


@fault("channel-survives-reset", Defect.STATE, "channel.reset-restores")
class SurvivesReset(Node):
    """Keeps the COB-IDs of further channels over a reset of the communication."""

    def restore(self, *, communication_only: bool) -> None:
        kept = [
            (entry, entry.value)
            for channel in self.channels[1:]
            for entry in channel.record.entries.values()
        ]
        super().restore(communication_only=communication_only)
        for entry, value in kept:
            entry.value = value
