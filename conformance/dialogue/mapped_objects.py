"""Which objects of a device a PDO may map, by their description, and what is wrong with one."""

from collections.abc import Iterable, Sequence

from conformance.device.device import LAST_DATA_TYPE, Device
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.parameters import CobIdEntry
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import in_words
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType
from conformance.sdo.pdos import DUMMIES, MOST_BITS, RECEIVED, RECEIVED_MAPPINGS, Mapped
from conformance.sdo.seen import Said

MISSING = (AbortCode.OBJECT_MISSING, AbortCode.SUB_INDEX_MISSING)
_TYPES = frozenset(DataType)


def unmappable(device: Device, pdo: CobIdEntry) -> Mapped:
    """Return an object that no PDO may map, and that this one could read or write.

    Raises NotTestable where the EDS names none.
    """
    found = (
        known
        for known in _numbers(device)
        if known.mappable is False and _has_access(known, received=_is_received(pdo))
    )
    return _whole(found, "an EDS with a number that no PDO may map (PDOMapping=0)")


def forbidden(device: Device, pdo: CobIdEntry) -> Mapped:
    """Return an object whose access keeps it from this PDO; if possible another may map it.

    Raises NotTestable where none is known.
    """
    received = _is_received(pdo)
    found = [known for known in _numbers(device) if not _has_access(known, received=received)]
    found.sort(key=lambda known: (known.mappable is None) + 2 * (known.mappable is False))
    kind = "read-only" if received else "write-only"
    return _whole(found, f"a number that is {kind}: name one, or an EDS that lists one")


def another_entry(device: Device, pdo: CobIdEntry, mapped: Sequence[int]) -> bytes:
    """Return what the first entry of a mapping could hold instead: 0 where nothing else is known.

    That is another of its objects, or one of the same length.
    """
    first = Mapped.of(mapped[0])
    for other in map(Mapped.of, mapped[1:]):
        if other != first and other.bits == first.bits:
            return bytes(other)
    for known in _numbers(device):
        entry = Mapped(known.mux, _bits(known))
        fits = entry != first and entry.bits == first.bits
        if fits and known.mappable and _has_access(known, received=_is_received(pdo)):
            return bytes(entry)
    return bytes(4)


def expect_mapped(sdo: Dialogue, entry: Multiplexer, mapped: Mapped) -> None:
    """Expect an entry of a mapping to name an object that may stand there, with all its bits."""
    received = entry.index in RECEIVED_MAPPINGS
    if 0 < mapped.mux.index <= LAST_DATA_TYPE:
        _expect_dummy(sdo, entry, mapped, received=received)
        return
    known = sdo.device.known.get(mapped.mux)
    if not _exists(sdo, mapped.mux, known):
        raise sdo.breach(
            f"{entry} maps an object that exists", Said(f"it maps {mapped}", "it maps … bits of")
        )
    if known is None:
        return
    mapping, kind = f"{entry} maps {known.title}", f"maps ({known.name})" if known.name else "maps"
    if known.mappable is False:
        raise sdo.breach(
            "a mapping of what the EDS lets PDOs map",
            Said(f"{mapping}, with PDOMapping=0", f"{kind}, with PDOMapping=…"),
        )
    if not _has_access(known, received=received):
        raise sdo.breach(
            f"a mapping of what can be {'written' if received else 'read'}",
            Said(f"{mapping}, which is {known.access}", f"{kind}, which is {known.access}"),
        )
    _expect_bits(sdo, entry, mapped, known.data_type)


def _expect_dummy(sdo: Dialogue, entry: Multiplexer, mapped: Mapped, *, received: bool) -> None:
    if not received or mapped.mux.index not in DUMMIES:
        sdo.info(f"{entry} maps {mapped.mux}, which is no dummy of a received PDO")
    _expect_bits(sdo, entry, mapped, _type(mapped.mux.index))


def _type(number: int) -> DataType | None:
    return DataType(number) if number in _TYPES else None


def _expect_bits(
    sdo: Dialogue, entry: Multiplexer, mapped: Mapped, data_type: DataType | None
) -> None:
    """Expect as many bits as a type has; of other types, and those of a device, nobody knows."""
    length = None if data_type is None else data_type.length
    if length is None or (data_type is DataType.BOOLEAN and mapped.bits == 1):
        return
    if mapped.bits != 8 * length:
        raise sdo.breach(
            f"{entry} maps all {8 * length} bits of {mapped.mux}", Said(f"{mapped}", "… bits of")
        )


def _exists(sdo: Dialogue, mux: Multiplexer, known: KnownObject | None) -> bool:
    """Say whether an object is there: any other refusal than one as missing is of something."""
    if known is not None and known.refuses_scan:
        return True  # the EDS asks not to read it
    try:
        sdo.read(mux)
    except ServerAborted as aborted:
        if aborted.abort.code == AbortCode.GENERAL_ERROR:
            sdo.info(f"whether {mux} exists is open: {in_words(aborted.abort)}")
        return aborted.abort.code not in MISSING
    return True


def _numbers(device: Device) -> list[KnownObject]:
    """Return what has whole bytes, no more than a PDO, and is there as far as was read."""
    return [
        known
        for known in device.objects
        if known.data_type is not DataType.BOOLEAN
        and 0 < _bits(known) <= MOST_BITS
        and (known.mux in device.values or not known.access.readable)
    ]


def _bits(known: KnownObject) -> int:
    return 8 * (known.length or 0)


def _is_received(pdo: CobIdEntry) -> bool:
    return pdo.mux.index in RECEIVED


def _has_access(known: KnownObject, *, received: bool) -> bool:
    return known.access.writable if received else known.access.readable


def _whole(found: Iterable[KnownObject], what: str) -> Mapped:
    for known in found:
        return Mapped(known.mux, _bits(known))
    raise NotTestable(f"needs {what}")
