"""SDO server parameter records, 1200h to 127Fh: where a channel of the reference server listens."""

from collections.abc import Callable
from dataclasses import dataclass, field

from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry

FIRST_RECORD = 0x1200
COUNT, REQUEST, RESPONSE, CLIENT = range(4)
UNUSED = bytes(CobId(0, valid=False))

Check = Callable[[bytes, bytes], None]


def anything(old: bytes, new: bytes) -> None:
    """Allow every change."""


@dataclass(slots=True)
class CheckedEntry(Entry):
    """An entry that asks before it changes: ``check`` takes the old and the new value."""

    check: Check = field(default=anything)

    def check_limits(self, data: bytes) -> None:
        """Refuse what the check refuses."""
        self.check(self.value, data)


@dataclass(frozen=True, slots=True)
class ServerParameter:
    """One record: its entries by sub-index, in the object dictionary of the node."""

    index: int
    entries: dict[int, Entry]

    @classmethod
    def default(cls, ids: ChannelIds) -> "ServerParameter":
        """Return 1200h, which only tells what the node-ID decides."""
        entries = {
            COUNT: _unsigned(2),
            REQUEST: Entry(bytes(ids.request), DataType.UNSIGNED32, Access.CONST),
            RESPONSE: Entry(bytes(ids.response), DataType.UNSIGNED32, Access.CONST),
        }
        return cls(FIRST_RECORD, entries)

    @classmethod
    def further(
        cls, number: int, check: Check, check_client: Check | None = None
    ) -> "ServerParameter":
        """Return 1200h plus ``number``, not in use until it is configured.

        ``check`` allows COB-IDs; with ``check_client`` there is a sub-index 03h, the client's
        node-ID.
        """
        entries: dict[int, Entry] = {
            COUNT: _unsigned(RESPONSE if check_client is None else CLIENT),
            REQUEST: CheckedEntry(UNUSED, DataType.UNSIGNED32, check=check),
            RESPONSE: CheckedEntry(UNUSED, DataType.UNSIGNED32, check=check),
        }
        if check_client is not None:
            entries[CLIENT] = CheckedEntry(b"\1", DataType.UNSIGNED8, check=check_client)
        return cls(FIRST_RECORD + number, entries)

    @property
    def request(self) -> CobId:
        """The COB-ID from client to server."""
        return CobId.from_bytes(self.entries[REQUEST].value)

    @property
    def response(self) -> CobId:
        """The COB-ID from server to client."""
        return CobId.from_bytes(self.entries[RESPONSE].value)

    @property
    def is_valid(self) -> bool:
        """Whether the channel exists: bit 31 is 0 in both COB-IDs."""
        return self.request.valid and self.response.valid

    def by_multiplexer(self) -> dict[Multiplexer, Entry]:
        """Return the entries as an object dictionary has them."""
        return {Multiplexer(self.index, sub): entry for sub, entry in self.entries.items()}


def _unsigned(value: int) -> Entry:
    return Entry(bytes((value,)), DataType.UNSIGNED8, Access.CONST)
