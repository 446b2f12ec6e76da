"""What the bytes of an SDO frame are, part by part, for people who read a diagram."""

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

# How ``describe`` begins for each message; a name that begins like another stands before it.
KINDS: dict[str, type[Message]] = {
    "abort": Abort,
    "block acknowledgement": BlockAck,
    "block download initiate response": BlockDownloadInitiateResponse,
    "block download initiate": BlockDownloadInitiate,
    "block end response": BlockEndResponse,
    "block end": BlockEnd,
    "block segment": BlockSegment,
    "block upload initiate response": BlockUploadInitiateResponse,
    "block upload initiate": BlockUploadInitiate,
    "block upload start": BlockUploadStart,
    "download initiate response": DownloadInitiateResponse,
    "download initiate": DownloadInitiate,
    "download segment response": DownloadSegmentResponse,
    "download segment": DownloadSegment,
    "upload initiate response": UploadInitiateResponse,
    "upload initiate": UploadInitiate,
    "upload segment request": UploadSegment,
    "upload segment response": UploadSegmentResponse,
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
    """Bytes of a frame that belong together, in hexadecimal, and what they mean."""

    data: str
    meaning: str


def parts_of(words: str, data: bytes) -> list[Part]:
    """Take a frame apart that ``describe`` has put into words."""
    name = next((name for name in KINDS if words.startswith(name)), None)
    if name is None or len(data) != FRAME_LENGTH:
        return [Part(hex_bytes(data), "")]
    message = KINDS[name].decode(data)
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
