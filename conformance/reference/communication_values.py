"""The reference node's objects for SYNC, heartbeats and errors that refuse some values.

The node neither produces SYNC nor consumes heartbeats; it only checks what is written.
"""

from collections.abc import Sequence

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import Check, CheckedEntry
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, Refusal

CYCLE_PERIOD, COUNTER_OVERFLOW = Multiplexer(0x1006), Multiplexer(0x1019)
CONSUMED, CONFIGURATION, ERROR_BEHAVIOUR = 0x1016, 0x1020, 0x1029
RESERVED_OVERFLOWS = (1, *range(241, 256))
RESERVED_BEHAVIOURS = range(0x03, 0x80)
CONSUMED_NODES = 2
BEHAVES_BY_ITSELF = b"\x01"


def value_entries() -> dict[Multiplexer, Entry]:
    """Return 1006h, 1016h, 1019h, 1020h and 1029h, of which nothing is in use."""
    period = CheckedEntry(bytes(4), DataType.UNSIGNED32)
    nodes = [CheckedEntry(bytes(4), DataType.UNSIGNED32) for _ in range(CONSUMED_NODES)]
    for node in nodes:
        node.check = consumer_check([other for other in nodes if other is not node])
    behaviour = CheckedEntry(BEHAVES_BY_ITSELF, DataType.UNSIGNED8, check=check_behaviour)
    dates = [Entry(bytes(4), DataType.UNSIGNED32) for _ in range(2)]
    return {
        CYCLE_PERIOD: period,
        COUNTER_OVERFLOW: CheckedEntry(bytes(1), DataType.UNSIGNED8, check=overflow_check(period)),
        **_array(CONSUMED, nodes),
        **_array(CONFIGURATION, dates),
        **_array(ERROR_BEHAVIOUR, [behaviour]),
    }


def overflow_check(period: Entry) -> Check:
    """Return what refuses a counter overflow: a reserved one, and any while there is a period."""

    def check(old: bytes, new: bytes) -> None:
        if new[0] in RESERVED_OVERFLOWS:
            raise Refusal(AbortCode.VALUE_INVALID)
        if new != old and any(period.value):
            raise Refusal(AbortCode.DEVICE_STATE)

    return check


def consumer_check(others: Sequence[Entry]) -> Check:
    """Return what refuses a node whose heartbeat another entry waits for."""

    def check(old: bytes, new: bytes) -> None:
        waits = any(new[:2]) and any(
            other.value[:2] != bytes(2) and other.value[2] == new[2] for other in others
        )
        if waits:
            raise Refusal(AbortCode.PARAMETER_INCOMPATIBLE)

    return check


def check_behaviour(old: bytes, new: bytes) -> None:
    """Refuse a reserved behaviour on an error."""
    if new[0] in RESERVED_BEHAVIOURS:
        raise Refusal(AbortCode.VALUE_INVALID)


def _array(index: int, entries: Sequence[Entry]) -> dict[Multiplexer, Entry]:
    count = Entry(bytes([len(entries)]), DataType.UNSIGNED8, Access.CONST)
    numbered = {Multiplexer(index, sub): entry for sub, entry in enumerate(entries, 1)}
    return {Multiplexer(index): count} | numbered
