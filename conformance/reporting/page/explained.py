"""The bytes of an SDO frame, part by part, for readers of a diagram."""

from collections.abc import Iterator
from dataclasses import dataclass

from conformance.sdo.describe import hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message

# By the names that the lines of a trace have.
KINDS: dict[str, type[Message]] = {
    kind.__name__: kind
    for kind in (
        Abort,
        BlockAck,
        BlockDownloadInitiate,
        BlockDownloadInitiateResponse,
        BlockEnd,
        BlockEndResponse,
        BlockSegment,
        BlockUploadInitiate,
        BlockUploadInitiateResponse,
        BlockUploadStart,
        DownloadInitiate,
        DownloadInitiateResponse,
        DownloadSegment,
        DownloadSegmentResponse,
        UploadInitiate,
        UploadInitiateResponse,
        UploadSegment,
        UploadSegmentResponse,
    )
}
# The letters of CiA 301 for the fields of byte 0.
_LETTERS = {
    "crc_supported": "crc",
    "expedited": "e",
    "last": "c",
    "reserved_bits": "reserved",
    "sequence": "seqno",
    "sized": "s",
    "toggle": "t",
    "unused": "n",
}
_SPECIFIER_SHIFT = 5


@dataclass(frozen=True, slots=True)
class Part:
    """Bytes of a frame that belong together, in hexadecimal, and their meaning."""

    data: str
    meaning: str


def parts_of(kind: str, data: bytes) -> list[Part]:
    """Take a frame apart that is an SDO message of a kind."""
    if kind not in KINDS or len(data) != FRAME_LENGTH:
        return [Part(hex_bytes(data), "")]
    message = KINDS[kind].decode(data)
    fields = sorted(message.LAYOUT.body.items(), key=lambda field: field[1])
    return [
        Part(hex_bytes(data[:1]), ", ".join(_command(message, data[0]))),
        *(
            Part(hex_bytes(data[start:stop]), _meaning(message, field))
            for field, (start, stop) in fields
        ),
    ]


def _command(message: Message, command: int) -> Iterator[str]:
    """Yield the fields of byte 0; a segment of a sub-block has no command specifier."""
    if not isinstance(message, BlockSegment):
        yield f"cs {command >> _SPECIFIER_SHIFT}"
    for field in message.LAYOUT.bits:
        value = int(getattr(message, field))
        if value or field != "reserved_bits":
            yield f"{_LETTERS[field]} {value}"


def _meaning(message: Message, field: str) -> str:
    value = getattr(message, field)
    match field:
        case "mux":
            return str(value)
        case "payload":
            return _payload(message)
        case "reserved":
            return "reserved, not 0" if any(value) else "reserved"
        case "code":
            return f"code {value:08X}h"
        case "crc":
            return f"CRC {value:04X}h"
        case "block_size":
            return f"blksize {value}"
        case "threshold":
            return f"pst {value}"
        case _:
            return f"ackseq {value}"


def _payload(message: Message) -> str:
    match message:
        case DownloadInitiate() | UploadInitiateResponse() if message.expedited:
            return "data"
        case DownloadInitiate() | UploadInitiateResponse():
            size = message.size
        case BlockDownloadInitiate() | BlockUploadInitiateResponse():
            size = message.size
        case DownloadSegment() | UploadSegmentResponse():
            return f"{len(message.data)} bytes of data"
        case _:
            return "data"
    return "no size" if size is None else f"size {size}"
