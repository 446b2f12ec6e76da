"""Every message of the SDO protocols, as CiA 301 clauses 7.2.4.3.3 to 7.2.4.3.17 draw them.

Requests come from the client, responses from the server. What is none of them is ``Unknown``.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

from conformance.sdo.layout import Layout, Message, Multiplexer

_SPECIFIER = 0b111_00000
_MUX = (1, 4)


@dataclass(frozen=True, slots=True)
class _Initiate(Message):
    """What download initiate and the response to upload initiate share: n, e, s and d."""

    mux: Multiplexer
    expedited: bool = False
    sized: bool = False
    unused: int = 0
    payload: bytes = bytes(4)
    reserved_bits: int = 0

    @classmethod
    def with_data(cls, mux: Multiplexer, data: bytes) -> Self:
        """Expedited, 1 to 4 bytes, their number indicated."""
        unused = 4 - len(data)
        return cls(mux, True, True, unused, bytes(data).ljust(4, b"\0"))

    @classmethod
    def with_uncounted_data(cls, mux: Multiplexer, data: bytes) -> Self:
        """Expedited, the number of bytes not indicated: the object's type decides."""
        return cls(mux, True, False, 0, bytes(data).ljust(4, b"\0"))

    @classmethod
    def with_size(cls, mux: Multiplexer, size: int | None) -> Self:
        """Segmented, with the size in bytes or, for None, without."""
        if size is None:
            return cls(mux)
        return cls(mux, sized=True, payload=size.to_bytes(4, "little"))

    @property
    def data(self) -> bytes:
        """The data of an expedited message; all 4 bytes when their number is not indicated."""
        return self.payload[: 4 - self.unused] if self.expedited and self.sized else self.payload

    @property
    def size(self) -> int | None:
        """The size in bytes that a segmented message indicates; None where it does not."""
        if self.expedited or not self.sized:
            return None
        return int.from_bytes(self.payload, "little")


@dataclass(frozen=True, slots=True)
class DownloadInitiate(_Initiate):
    """Request 20h to 3Fh (7.2.4.3.3): the client wants to write, or writes 1 to 4 bytes."""

    LAYOUT: ClassVar = Layout(
        0b001_00000,
        _SPECIFIER,
        {"reserved_bits": 0x10, "unused": 0x0C, "expedited": 0x02, "sized": 0x01},
        {"mux": _MUX, "payload": (4, 8)},
    )


@dataclass(frozen=True, slots=True)
class DownloadInitiateResponse(Message):
    """Response 60h (7.2.4.3.3)."""

    mux: Multiplexer
    reserved_bits: int = 0
    reserved: bytes = bytes(4)
    LAYOUT: ClassVar = Layout(
        0b011_00000, _SPECIFIER, {"reserved_bits": 0x1F}, {"mux": _MUX, "reserved": (4, 8)}
    )


@dataclass(frozen=True, slots=True)
class _Segment(Message):
    """What segments share in both directions: toggle, n, c and 7 bytes."""

    payload: bytes
    toggle: int = 0
    unused: int = 0
    last: bool = False
    LAYOUT: ClassVar = Layout(
        0b000_00000,
        _SPECIFIER,
        {"toggle": 0x10, "unused": 0x0E, "last": 0x01},
        {"payload": (1, 8)},
    )

    @classmethod
    def with_data(cls, data: bytes, *, toggle: int, last: bool = False) -> Self:
        """Build a segment of 0 to 7 bytes, the rest filled with 0."""
        return cls(bytes(data).ljust(7, b"\0"), toggle, 7 - len(data), last)

    @property
    def data(self) -> bytes:
        """The bytes that count."""
        return self.payload[: 7 - self.unused]


@dataclass(frozen=True, slots=True)
class DownloadSegment(_Segment):
    """Request 00h to 1Fh (7.2.4.3.4): up to 7 bytes for the server."""


@dataclass(frozen=True, slots=True)
class UploadSegmentResponse(_Segment):
    """Response 00h to 1Fh (7.2.4.3.7): up to 7 bytes from the server."""


@dataclass(frozen=True, slots=True)
class DownloadSegmentResponse(Message):
    """Response 20h or 30h (7.2.4.3.4)."""

    toggle: int = 0
    reserved_bits: int = 0
    reserved: bytes = bytes(7)
    LAYOUT: ClassVar = Layout(
        0b001_00000, _SPECIFIER, {"toggle": 0x10, "reserved_bits": 0x0F}, {"reserved": (1, 8)}
    )


@dataclass(frozen=True, slots=True)
class UploadInitiate(Message):
    """Request 40h (7.2.4.3.6): the client wants to read."""

    mux: Multiplexer
    reserved_bits: int = 0
    reserved: bytes = bytes(4)
    LAYOUT: ClassVar = Layout(
        0b010_00000, _SPECIFIER, {"reserved_bits": 0x1F}, {"mux": _MUX, "reserved": (4, 8)}
    )


@dataclass(frozen=True, slots=True)
class UploadInitiateResponse(_Initiate):
    """Response 40h to 5Fh (7.2.4.3.6): the data, or the size of what comes in segments."""

    LAYOUT: ClassVar = Layout(
        0b010_00000,
        _SPECIFIER,
        {"reserved_bits": 0x10, "unused": 0x0C, "expedited": 0x02, "sized": 0x01},
        {"mux": _MUX, "payload": (4, 8)},
    )


@dataclass(frozen=True, slots=True)
class UploadSegment(Message):
    """Request 60h or 70h (7.2.4.3.7): the client asks for the next segment."""

    toggle: int = 0
    reserved_bits: int = 0
    reserved: bytes = bytes(7)
    LAYOUT: ClassVar = Layout(
        0b011_00000, _SPECIFIER, {"toggle": 0x10, "reserved_bits": 0x0F}, {"reserved": (1, 8)}
    )


@dataclass(frozen=True, slots=True)
class Abort(Message):
    """Either side ends a transfer with a reason (7.2.4.3.17)."""

    mux: Multiplexer
    code: int
    reserved_bits: int = 0
    LAYOUT: ClassVar = Layout(
        0b100_00000, _SPECIFIER, {"reserved_bits": 0x1F}, {"mux": _MUX, "code": (4, 8)}
    )


@dataclass(frozen=True, slots=True)
class _BlockInitiate(Message):
    """What announces a block transfer's data, from the client or from the server."""

    mux: Multiplexer
    crc_supported: bool = True
    sized: bool = False
    payload: bytes = bytes(4)
    reserved_bits: int = 0
    LAYOUT: ClassVar = Layout(
        0b110_00000,
        0b111_00001,
        {"reserved_bits": 0x18, "crc_supported": 0x04, "sized": 0x02},
        {"mux": _MUX, "payload": (4, 8)},
    )

    @classmethod
    def with_size(cls, mux: Multiplexer, size: int | None, *, crc_supported: bool = True) -> Self:
        """Announce a size in bytes or, for None, none."""
        if size is None:
            return cls(mux, crc_supported)
        return cls(mux, crc_supported, sized=True, payload=size.to_bytes(4, "little"))

    @property
    def size(self) -> int | None:
        """The size in bytes; None where it is not indicated."""
        return int.from_bytes(self.payload, "little") if self.sized else None


@dataclass(frozen=True, slots=True)
class BlockDownloadInitiate(_BlockInitiate):
    """Request C0h, C2h, C4h or C6h (7.2.4.3.9)."""


@dataclass(frozen=True, slots=True)
class BlockUploadInitiateResponse(_BlockInitiate):
    """Response C0h, C2h, C4h or C6h (7.2.4.3.13)."""


@dataclass(frozen=True, slots=True)
class BlockDownloadInitiateResponse(Message):
    """Response A0h or A4h (7.2.4.3.9): the server says how many segments a sub-block may have."""

    mux: Multiplexer
    block_size: int
    crc_supported: bool = True
    reserved_bits: int = 0
    reserved: bytes = bytes(3)
    LAYOUT: ClassVar = Layout(
        0b101_00000,
        0b111_00011,
        {"reserved_bits": 0x18, "crc_supported": 0x04},
        {"mux": _MUX, "block_size": (4, 5), "reserved": (5, 8)},
    )


@dataclass(frozen=True, slots=True)
class BlockSegment(Message):
    """A segment of a sub-block, in either direction (7.2.4.3.10, 7.2.4.3.14): always 7 bytes.

    How many bytes of the last one count stands in the frame that ends the transfer.
    """

    sequence: int
    payload: bytes
    last: bool = False
    LAYOUT: ClassVar = Layout(0, 0, {"last": 0x80, "sequence": 0x7F}, {"payload": (1, 8)})

    @classmethod
    def with_data(cls, sequence: int, data: bytes, *, last: bool = False) -> Self:
        """Build a segment of 0 to 7 bytes, the rest filled with 0."""
        return cls(sequence, bytes(data).ljust(7, b"\0"), last)

    @classmethod
    def decode(cls, frame: bytes) -> Self:
        """Read a segment without the table: most frames of a long transfer are segments."""
        return cls(frame[0] & 0x7F, frame[1:], frame[0] > 0x7F)


@dataclass(frozen=True, slots=True)
class BlockAck(Message):
    """A2h from the receiver of a sub-block (7.2.4.3.10, 7.2.4.3.14)."""

    sequence: int
    block_size: int
    reserved_bits: int = 0
    reserved: bytes = bytes(5)
    LAYOUT: ClassVar = Layout(
        0b101_00010,
        0b111_00011,
        {"reserved_bits": 0x1C},
        {"sequence": (1, 2), "block_size": (2, 3), "reserved": (3, 8)},
    )


@dataclass(frozen=True, slots=True)
class BlockEnd(Message):
    """C1h to DDh from the sender of the data (7.2.4.3.11, 7.2.4.3.15): n and the CRC."""

    unused: int
    crc: int = 0
    reserved_bits: int = 0
    reserved: bytes = bytes(5)
    LAYOUT: ClassVar = Layout(
        0b110_00001,
        0b111_00001,
        {"unused": 0x1C, "reserved_bits": 0x02},
        {"crc": (1, 3), "reserved": (3, 8)},
    )


@dataclass(frozen=True, slots=True)
class BlockEndResponse(Message):
    """A1h from the receiver of the data (7.2.4.3.11, 7.2.4.3.15)."""

    reserved_bits: int = 0
    reserved: bytes = bytes(7)
    LAYOUT: ClassVar = Layout(
        0b101_00001, 0b111_00011, {"reserved_bits": 0x1C}, {"reserved": (1, 8)}
    )


@dataclass(frozen=True, slots=True)
class BlockUploadInitiate(Message):
    """Request A0h or A4h (7.2.4.3.13). ``threshold`` is pst: a value of
    pst bytes or fewer may come as an ordinary upload; 0 forbids that."""

    mux: Multiplexer
    block_size: int
    threshold: int = 0
    crc_supported: bool = True
    reserved_bits: int = 0
    reserved: bytes = bytes(2)
    LAYOUT: ClassVar = Layout(
        0b101_00000,
        0b111_00011,
        {"reserved_bits": 0x18, "crc_supported": 0x04},
        {"mux": _MUX, "block_size": (4, 5), "threshold": (5, 6), "reserved": (6, 8)},
    )


@dataclass(frozen=True, slots=True)
class BlockUploadStart(Message):
    """Request A3h (7.2.4.3.13): the client is ready for the segments."""

    reserved_bits: int = 0
    reserved: bytes = bytes(7)
    LAYOUT: ClassVar = Layout(
        0b101_00011, 0b111_00011, {"reserved_bits": 0x1C}, {"reserved": (1, 8)}
    )


@dataclass(frozen=True, slots=True)
class Unknown:
    """A frame that no clause defines: a command specifier without a meaning, or not 8 bytes."""

    frame: bytes

    def encode(self) -> bytes:
        """Return the bytes as they came."""
        return self.frame


@dataclass(frozen=True, slots=True)
class RemoteFrame(Unknown):
    """A remote frame on the COB-ID of the requests: it has a DLC and no data, so no request."""

    dlc: int = 0


RequestMessage = (
    DownloadInitiate
    | DownloadSegment
    | UploadInitiate
    | UploadSegment
    | Abort
    | BlockDownloadInitiate
    | BlockSegment
    | BlockEnd
    | BlockUploadInitiate
    | BlockUploadStart
    | BlockAck
    | BlockEndResponse
)
ResponseMessage = (
    DownloadInitiateResponse
    | DownloadSegmentResponse
    | UploadInitiateResponse
    | UploadSegmentResponse
    | Abort
    | BlockDownloadInitiateResponse
    | BlockAck
    | BlockEndResponse
    | BlockUploadInitiateResponse
    | BlockSegment
    | BlockEnd
)
Request = RequestMessage | Unknown
Response = ResponseMessage | Unknown
INITIATES = (UploadInitiate, DownloadInitiate, BlockUploadInitiate, BlockDownloadInitiate)
"""The requests that begin a transfer."""
