"""Which of the listed objects a case on the object dictionary is about, and by which label.

Each function here is handed what is listed of a device and returns what to run a case for. The
labels stand in the ids of the cases, so they name objects and never count them.
"""

from collections.abc import Callable, Iterable

from conformance.device.device import IDENTITY_NAMES
from conformance.device.eds_listing import STRUCTURE_OF_OBJECT, ListedObject, Listing
from conformance.device.effort import INDICES_BESIDE
from conformance.device.known_objects import KnownObject
from conformance.device.numbers import beyond as beyond_limit
from conformance.device.numbers import is_number
from conformance.device.protected_objects import group_of
from conformance.sdo.emergency import ERROR_LIST, is_error_place
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access
from conformance.sdo.pdos import IN_ORDER, MAPPING_OF, RECEIVED, SENT, is_mapping
from conformance.sdo.storage_commands import COMMANDS

FIXED = (0x1000, 0x1008, 0x1018, 0x1200)
SERIAL_NUMBER = Multiplexer(0x1018, 4)
FIRST_INDEX, LAST_INDEX = 0x1000, 0xBFFF
RANGE = 0x1000

Entries = dict[str, KnownObject]
Choice = Callable[[KnownObject], bool]


def _entries(choice: Choice) -> Callable[[Listing], Entries]:
    def choose(listing: Listing) -> Entries:
        return {
            str(known.mux): known
            for known in listing.entries
            if known.mux.sub_index != STRUCTURE_OF_OBJECT and choice(known)
        }

    return choose


def is_read(known: KnownObject) -> bool:
    """Whether an entry has a value to read; places of the error list may be empty."""
    return known.access.readable and not known.refuses_scan and not is_error_place(known.mux)


def _is_written(known: KnownObject) -> bool:
    # The count of errors takes no value but 0, not even its own; a command takes its signature.
    plain = known.mux.index not in (ERROR_LIST, *COMMANDS)
    return known.access is Access.RW and is_read(known) and plain


def _is_plain_number(known: KnownObject) -> bool:
    """Say whether only the length of a value can be wrong: a COB-ID cut short is none either."""
    return _is_written(known) and _has_length(known) and group_of(known.mux.index) is None


def _changes(known: KnownObject) -> bool:
    """Say whether another value may be written at once: none to what is in use, as COB-IDs are."""
    return _is_written(known) and known.mux.index not in IN_ORDER


def _has_length(known: KnownObject) -> bool:
    return known.length is not None


def _is_protected(known: KnownObject) -> bool:
    return is_read(known) and not known.access.writable


def _is_fixed(known: KnownObject) -> bool:
    """Say whether an entry has the value of its EDS for ever, whatever was written.

    That are constants, and what the standard fixes however an EDS calls it; of the serial number an
    EDS knows nothing.
    """
    by_standard = known.access is Access.RO and known.mux.index in FIXED
    return (known.access is Access.CONST or by_standard) and known.mux != SERIAL_NUMBER


def _is_limited(known: KnownObject) -> bool:
    return known.is_limited and is_number(known.data_type)


def above(known: KnownObject) -> bytes | None:
    """Return a value above the high limit; None where there is no limit, or no such value."""
    if known.high is None or known.data_type is None or not is_number(known.data_type):
        return None
    return beyond_limit(known.data_type, known.high, 1)


def below(known: KnownObject) -> bytes | None:
    """Return a value below the low limit; None where there is no limit, or no such value."""
    if known.low is None or known.data_type is None or not is_number(known.data_type):
        return None
    return beyond_limit(known.data_type, known.low, -1)


readable = _entries(is_read)
of_fixed_length = _entries(lambda known: is_read(known) and _has_length(known))
fixed = _entries(lambda known: _is_fixed(known) and known.default is not None and is_read(known))
parameters = _entries(
    lambda known: _is_written(known) and known.is_steady and known.default is not None
)
configured = _entries(lambda known: known.configured is not None and is_read(known))
limited = _entries(lambda known: is_read(known) and _is_limited(known))
writable = _entries(_is_written)
writable_numbers = _entries(_is_plain_number)
longer_than_a_byte = _entries(lambda known: _is_plain_number(known) and (known.length or 0) > 1)
with_low_limit = _entries(
    lambda known: _changes(known) and _is_limited(known) and known.low is not None
)
with_high_limit = _entries(
    lambda known: _changes(known) and _is_limited(known) and known.high is not None
)
exceedable = _entries(lambda known: _changes(known) and above(known) is not None)
undercuttable = _entries(lambda known: _changes(known) and below(known) is not None)
protected = _entries(_is_protected)
write_only = _entries(lambda known: known.access is Access.WO)
error_places = _entries(lambda known: is_error_place(known.mux))


def _objects(listing: Listing) -> Iterable[ListedObject]:
    """Return objects of which all sub-indices are known."""
    return listing.objects.values() if listing.is_complete else ()


def structured(listing: Listing) -> dict[str, ListedObject]:
    """Choose arrays and records: their sub-index 0 says how far they go."""
    return {
        f"{listed.index:04X}h": listed
        for listed in _objects(listing)
        if listed.is_structured
        and 0 in listed.entries
        and 0 not in listed.unclear
        and is_read(listed.entries[0])
    }


def mappings(listing: Listing) -> dict[str, int]:
    """Choose what PDOs map; of a device without an EDS the first in each direction.

    A mapping that contradicts the rest of the EDS is not chosen.
    """
    first = (SENT.start + MAPPING_OF, RECEIVED.start + MAPPING_OF)
    clear = [index for index, listed in listing.objects.items() if 0 not in listed.unclear]
    indices = sorted(clear) if listing.is_complete else sorted(first)
    return {f"{index:04X}h": index for index in indices if is_mapping(index)}


def listed_objects(listing: Listing) -> dict[str, ListedObject]:
    """Choose all objects of which the type is known."""
    return {
        f"{listed.index:04X}h": listed
        for listed in _objects(listing)
        if STRUCTURE_OF_OBJECT not in listed.unclear
    }


def gaps(listing: Listing) -> dict[str, Multiplexer]:
    """Choose the sub-indices that are left out between others."""
    return {
        str(Multiplexer(listed.index, sub)): Multiplexer(listed.index, sub)
        for listed in _objects(listing)
        for sub in listed.gaps
    }


def beyond(listing: Listing) -> dict[str, Multiplexer]:
    """Choose the first sub-index behind the last of each object."""
    return {
        f"{listed.index:04X}h": Multiplexer(listed.index, listed.highest + 1)
        for listed in _objects(listing)
        if listed.entries and listed.highest + 1 < STRUCTURE_OF_OBJECT
    }


def unlisted(listing: Listing) -> dict[str, Multiplexer]:
    """Choose indices beside those that are listed, from all over the dictionary."""
    beside = [
        index + 1
        for index in sorted(listing.objects)
        if FIRST_INDEX <= index < LAST_INDEX and index + 1 not in listing.objects
    ]
    step = -(-len(beside) // INDICES_BESIDE) or 1
    return {f"{index:04X}h": Multiplexer(index) for index in beside[::step] if listing.is_complete}


def identity(listing: Listing) -> dict[str, tuple[Multiplexer, int]]:
    """Choose what the EDS says of the identity of the device."""
    return {
        IDENTITY_NAMES[sub]: (Multiplexer(0x1018, sub), number)
        for sub, number in listing.identity.items()
        if listing.find(Multiplexer(0x1018, sub)) is not None
    }


def ranges(listing: Listing) -> dict[str, range]:
    """Choose all indices, in parts, where the user asked to scan them."""
    if not listing.to_scan:
        return {}
    return {
        f"{first:04X}h-{first + RANGE - 1:04X}h": range(max(first, 1), first + RANGE)
        for first in range(0, 0x10000, RANGE)
    }
