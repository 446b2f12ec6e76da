"""Which objects a user might let be written: by an EDS, or by how they read without one."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from conformance.device.known_objects import FIRST_OF_PROFILE, KnownObject, name_of
from conformance.device.numbers import bounds, decode_number, is_number
from conformance.proposing.finding import Found
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import TEXT_TYPES, Access, DataType

FIRST_OF_DEVICE = 0x2000
# Fewer bytes do not show whether the counters of a server overflow.
OVERFLOWING = 4100
MOST_SHOWN = 24
_BIT_RATES = frozenset(1000 * rate for rate in (10, 20, 50, 100, 125, 250, 500, 800, 1000))
_BY_LENGTH = {
    1: DataType.UNSIGNED8,
    2: DataType.UNSIGNED16,
    3: DataType.UNSIGNED24,
    4: DataType.UNSIGNED32,
    8: DataType.UNSIGNED64,
}
# So short, letters alone may be a number too.
SHORTEST_TEXT = 3


@dataclass(frozen=True, slots=True)
class Proposal:
    """An object that may be written if the user says so; ``note`` is a remark on it."""

    known: KnownObject
    note: str
    length: int | None = None


@dataclass(slots=True)
class Proposals:
    """The proposed objects, the device's own and those of its profile, and the others.

    ``never`` are objects that no run ought to write, ``left_out`` others, each with the reason.
    """

    own: list[Proposal] = field(default_factory=list)
    profile: list[Proposal] = field(default_factory=list)
    never: list[tuple[Multiplexer, str]] = field(default_factory=list)
    left_out: list[tuple[Multiplexer, str]] = field(default_factory=list)

    def add(self, proposal: Proposal) -> None:
        """Take a proposal where it belongs."""
        of_profile = proposal.known.mux.index >= FIRST_OF_PROFILE
        (self.profile if of_profile else self.own).append(proposal)

    def __iter__(self) -> Iterator[Proposal]:
        """Go through all proposals."""
        return iter((*self.own, *self.profile))

    @property
    def long_ones(self) -> list[Proposal]:
        """The domains, then the strings; the longest values first."""
        found = [one for one in self if one.known.varies and one.known.access is Access.RW]
        return sorted(
            found, key=lambda one: (-(one.length or 0), one.known.data_type is not DataType.DOMAIN)
        )


def by_eds(entries: Iterable[KnownObject], values: Mapping[Multiplexer, bytes]) -> Proposals:
    """Propose objects that an EDS calls writable; ``values`` were read from the device."""
    found = Proposals()
    for known in entries:
        if not known.access.writable or known.mux.index < FIRST_OF_DEVICE:
            continue
        value = values.get(known.mux)
        if known.refuses_download:
            found.left_out.append((known.mux, f"{known.name}: the EDS excludes it (ObjFlags)"))
        elif known.is_delicate:
            found.never.append((known.mux, known.name))
        else:
            notes = [known.name, *_limits(known), *_said_of(known, value)]
            found.add(
                Proposal(
                    known, "; ".join(filter(None, notes)), None if value is None else len(value)
                )
            )
    return found


def _limits(known: KnownObject) -> Iterator[str]:
    if known.data_type is not None and (known.low, known.high) == bounds(known.data_type):
        return
    match known.low, known.high:
        case None, None:
            return
        case low, None:
            yield f"{low} or more"
        case None, high:
            yield f"{high} at most"
        case low, high:
            yield f"{low} to {high}"


def _said_of(known: KnownObject, value: bytes | None) -> Iterator[str]:
    if value is not None:
        yield f"reads {shown(known.data_type, value)}"
    if known.floats:
        yield "the device changes it itself"
    if known.access is Access.WO:
        yield "cannot be read, so it is not restored"


def by_reading(found: Found, node_id: int) -> Proposals:
    """Propose objects that were found by reading; no read shows whether they are writable."""
    proposals = Proposals()
    counts = {Multiplexer(mux.index) for mux in found.values if mux.sub_index}
    for mux, value in found.values.items():
        if mux.index < FIRST_OF_DEVICE or mux in counts:
            continue
        data_type = type_of(value)
        number = int.from_bytes(value, "little") if data_type in _BY_LENGTH.values() else None
        if mux in found.moving:
            proposals.left_out.append((mux, "its value changes by itself: measured, or a counter"))
        elif number == node_id and len(value) == 1:
            proposals.never.append((mux, f"reads {number}: is it the node-ID?"))
        elif number in _BIT_RATES:
            proposals.never.append((mux, f"reads {number}: is it the bit rate?"))
        else:
            note = f"reads {shown(data_type, value)}"
            proposals.add(Proposal(KnownObject(mux, data_type), note, len(value)))
    proposals.left_out += [
        (mux, f'write-only: name it with its type, as in "{name_of(mux)}=unsigned32,wo"')
        for mux in found.write_only
        if mux.index >= FIRST_OF_DEVICE
    ]
    return proposals


def type_of(value: bytes) -> DataType:
    """Guess the type of a value: a text, else a number of that length, else a domain."""
    text = value.rstrip(b"\0")
    varied = len(text) >= SHORTEST_TEXT and len(set(text)) > 1
    if varied and text.isascii() and text.decode("ascii").isprintable():
        return DataType.VISIBLE_STRING
    return _BY_LENGTH.get(len(value), DataType.DOMAIN)


def shown(data_type: DataType | None, value: bytes) -> str:
    """Write a value in a few words."""
    if data_type is not None and is_number(data_type) and len(value) == data_type.length:
        return str(decode_number(data_type, value))
    if data_type in TEXT_TYPES and len(value) <= MOST_SHOWN:
        encoding = "utf-16-le" if data_type is DataType.UNICODE_STRING else "latin-1"
        return repr(value.decode(encoding, "replace").rstrip("\0"))
    return "nothing" if not value else f"{len(value)} bytes"
