"""How an SDO message lies in its 8 bytes, as data: one table a message, one codec for all.

Byte 0 holds the command specifier, a few fields of some bits each, and reserved bits; the bytes
behind it hold whole fields. A layout names them all, so that nothing of a frame gets lost:
what is reserved is decoded into ``reserved_bits`` and ``reserved`` like any other field.
The tables are compiled once: each of the 256 values of byte 0 is looked up, the rest is a struct.
"""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from operator import attrgetter, itemgetter
from typing import Any, ClassVar, NamedTuple, Self

FRAME_LENGTH = 8


def whole_frame(data: bytes) -> bytes:
    """Return what a frame of another length would be with 8 bytes: cut off, or filled with 00h."""
    return data[:FRAME_LENGTH].ljust(FRAME_LENGTH, b"\0")


class Multiplexer(NamedTuple):
    """Index and sub-index: which entry of the object dictionary a transfer is about."""

    index: int  # type: ignore[assignment]  # it hides a method of tuples, which none needs here
    sub_index: int = 0

    def __str__(self) -> str:
        return f"{self.index:04X}h:{self.sub_index:02X}"


@dataclass(frozen=True, slots=True)
class Layout:
    """Where the fields of one message are.

    ``specifier`` and ``mask`` tell the message from others by its byte 0; ``bits`` maps a field
    to its mask in byte 0; ``body`` maps a field to the bytes that it takes, first and behind
    last.
    """

    specifier: int
    mask: int
    bits: dict[str, int]
    body: dict[str, tuple[int, int]]
    shifts: dict[str, int] = field(init=False)

    def __post_init__(self) -> None:
        shifts = {name: (mask & -mask).bit_length() - 1 for name, mask in self.bits.items()}
        object.__setattr__(self, "shifts", shifts)


@dataclass(frozen=True, slots=True)
class Message:
    """One SDO message. Subclasses add their fields and say in ``LAYOUT`` where these are."""

    LAYOUT: ClassVar[Layout]

    def encode(self) -> bytes:
        """Return the 8 bytes of the message.

        Raises ValueError when a field does not fit into its place.
        """
        return _codecs[type(self)].encode(self)

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Read the message from its 8 bytes; the caller has matched byte 0 already."""
        return cls(*_codecs[cls].decode(frame))

    @classmethod
    def matches(cls, command: int) -> bool:
        """Say whether a byte 0 belongs to this message."""
        return command & cls.LAYOUT.mask == cls.LAYOUT.specifier

    def reserved_fields(self) -> list[str]:
        """Say which reserved bits and bytes are not 0, though always sent as 0 (CiA 301, 7.2.4.3).

        >>> from conformance.sdo.frames import DownloadSegmentResponse
        >>> DownloadSegmentResponse(reserved_bits=3).reserved_fields()
        ['reserved bits of byte 0 are 03h']
        """
        layout = self.LAYOUT
        found = []
        bits = getattr(self, "reserved_bits", 0)
        if bits:
            place = bits << layout.shifts["reserved_bits"]
            found.append(f"reserved bits of byte 0 are {place:02X}h")
        rest: bytes = getattr(self, "reserved", b"")
        if rest.strip(b"\0"):
            start, stop = layout.body["reserved"]
            shown = rest.hex(" ").upper()
            found.append(f"reserved bytes {start} to {stop - 1} are {shown}")
        return found


_FLAGS = {"expedited", "sized", "last", "crc_supported"}
_RAW = {"payload", "reserved"}
_NUMBERS = {1: "B", 2: "H", 4: "I"}


class _Codec:
    """A layout compiled for one class: what byte 0 means is looked up, the rest is one struct."""

    def __init__(self, kind: type[Message]) -> None:
        layout = kind.LAYOUT
        self._layout = layout
        places = [(layout.shifts[name], mask, name in _FLAGS) for name, mask in layout.bits.items()]
        self._bits_of = tuple(
            tuple(
                bool(command & mask) if flag else (command & mask) >> shift
                for shift, mask, flag in places
            )
            for command in range(256)
        )
        self._command_of = {
            bits: command for command, bits in enumerate(self._bits_of) if kind.matches(command)
        }
        self._struct = struct.Struct(
            "<B" + "".join(_format(*field) for field in layout.body.items())
        )
        self._has_mux = "mux" in layout.body
        parts = [
            part
            for name in layout.body
            for part in (("mux.index", "mux.sub_index") if name == "mux" else (name,))
        ]
        lengths = {name: stop - start for name, (start, stop) in layout.body.items()}
        named = [*layout.bits, *parts]
        self._raw = [(named.index(name), lengths[name]) for name in parts if name in _RAW]
        self._values = _getter(named)
        self._body = len(layout.bits)  # where the values of the body begin
        found = [*layout.bits, *layout.body]
        self._in_order = _picker([found.index(field.name) for field in fields(kind)])

    def encode(self, message: Message) -> bytes:
        """Return the 8 bytes of a message; raises ValueError."""
        values, body = self._values(message), self._body
        for position, size in self._raw:  # a struct would cut or fill what has another length
            if len(values[position]) != size:
                raise ValueError(self._misfit(message))
        try:
            return self._struct.pack(self._command_of[values[:body]], *values[body:])
        except (struct.error, KeyError) as error:
            raise ValueError(self._misfit(message)) from error

    def decode(self, frame: bytes) -> Sequence[Any]:
        """Return the values of the fields in the order in which the class takes them."""
        found = self._struct.unpack(frame)
        bits = self._bits_of[found[0]]
        if self._has_mux:
            return self._in_order((*bits, Multiplexer(found[1], found[2]), *found[3:]))
        return self._in_order(bits + found[1:])

    def _misfit(self, message: Message) -> str:
        """Say which field does not fit into its place."""
        layout = self._layout
        for name, mask in layout.bits.items():
            value = getattr(message, name)
            if int(value) << layout.shifts[name] & ~mask:
                return f"{name}={value} does not fit into {mask:02X}h"
        for name in _RAW & layout.body.keys():
            start, stop = layout.body[name]
            length = len(getattr(message, name))
            if length != stop - start:
                return f"{name} takes {stop - start} bytes, not {length}"
        numbers = {name: getattr(message, name) for name in layout.body if name not in _RAW}
        shown = ", ".join(f"{name}={value}" for name, value in numbers.items())
        return f"{shown} does not fit into its bytes"


class _Codecs(dict[type[Message], _Codec]):
    """The codecs of classes, each compiled when it is first needed."""

    def __missing__(self, kind: type[Message]) -> _Codec:
        codec = self[kind] = _Codec(kind)
        return codec


_codecs = _Codecs()


def _format(name: str, place: tuple[int, int]) -> str:
    size = place[1] - place[0]
    if name == "mux":
        return "HB"
    return f"{size}s" if name in _RAW else _NUMBERS[size]


def _getter(names: list[str]) -> Callable[[object], tuple[Any, ...]]:
    """Return what gets these attributes as a tuple, also a single one."""
    get: Callable[[object], Any] = attrgetter(*names)
    return get if len(names) > 1 else lambda message: (get(message),)


def _picker(positions: list[int]) -> Callable[[Sequence[Any]], Sequence[Any]]:
    """Return what puts values into another order."""
    return itemgetter(*positions) if len(positions) > 1 else lambda values: values
