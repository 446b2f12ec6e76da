"""How an SDO message lies in its 8 bytes, as data: one table a message, one codec for all.

Byte 0 holds the command specifier, a few fields of some bits each, and reserved bits; the bytes
behind it hold whole fields. A layout names them all, so that nothing of a frame gets lost:
what is reserved is decoded into ``reserved_bits`` and ``reserved`` like any other field.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

FRAME_LENGTH = 8


@dataclass(frozen=True, slots=True, order=True)
class Multiplexer:
    """Index and sub-index: which entry of the object dictionary a transfer is about."""

    index: int
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
        frame = bytearray(FRAME_LENGTH)
        frame[0] = self.LAYOUT.specifier
        for name, mask in self.LAYOUT.bits.items():
            value = int(getattr(self, name)) << self.LAYOUT.shifts[name]
            if value & ~mask:
                raise ValueError(f"{name}={getattr(self, name)} does not fit into {mask:02X}h")
            frame[0] |= value
        for name, (start, stop) in self.LAYOUT.body.items():
            try:
                frame[start:stop] = _to_bytes(name, getattr(self, name), stop - start)
            except OverflowError as error:
                value = getattr(self, name)
                raise ValueError(f"{name}={value} does not fit into its bytes") from error
        return bytes(frame)

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Read the message from its 8 bytes; the caller has matched byte 0 already."""
        values: dict[str, Any] = {}
        for name, mask in cls.LAYOUT.bits.items():
            value = (frame[0] & mask) >> cls.LAYOUT.shifts[name]
            values[name] = bool(value) if name in _FLAGS else value
        for name, (start, stop) in cls.LAYOUT.body.items():
            values[name] = _from_bytes(name, bytes(frame[start:stop]))
        return cls(**values)

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
        if any(rest):
            start, stop = layout.body["reserved"]
            shown = rest.hex(" ").upper()
            found.append(f"reserved bytes {start} to {stop - 1} are {shown}")
        return found


_FLAGS = {"expedited", "sized", "last", "crc_supported"}
_RAW = {"payload", "reserved"}


def _to_bytes(name: str, value: Any, length: int) -> bytes:
    if name == "mux":
        return int(value.index).to_bytes(2, "little") + int(value.sub_index).to_bytes(1, "little")
    if name in _RAW:
        if len(value) != length:
            raise ValueError(f"{name} takes {length} bytes, not {len(value)}")
        return bytes(value)
    return int(value).to_bytes(length, "little")


def _from_bytes(name: str, raw: bytes) -> Any:
    if name == "mux":
        return Multiplexer(raw[0] | raw[1] << 8, raw[2])
    return raw if name in _RAW else int.from_bytes(raw, "little")
