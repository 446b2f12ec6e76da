"""SDO messages in words, for failures and traces."""

from collections.abc import Callable
from functools import cache, singledispatch

from conformance.sdo.abort_codes import describe_code
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
    RemoteFrame,
    Unknown,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message


def hex_bytes(data: bytes) -> str:
    """Write bytes as the field does: ``40 18 10 01``; ``no data`` for none."""
    return data.hex(" ").upper() or "no data"


def shown(data: bytes) -> str:
    """Write a value with its length; of a long one the beginning and the end."""
    if len(data) <= 32:
        return f"{len(data)} bytes: {hex_bytes(data)}"
    return f"{len(data)} bytes: {hex_bytes(data[:16])} … {hex_bytes(data[-8:])}"


def describe(message: Message | Unknown) -> str:
    """Return one line of words for a message, reserved bits that are set included."""
    words = _describing(type(message))(message)
    reserved = message.reserved_fields() if isinstance(message, Message) else []
    return "; ".join([words, *reserved]) if reserved else words


def _bytes(count: int) -> str:
    return "1 byte" if count == 1 else f"{count} bytes"


def in_words(message: Message | Unknown) -> str:
    """Return a message in words, with its bytes."""
    return f"{describe(message)} [{hex_bytes(message.encode())}]"


@singledispatch
def _words(message: Message | Unknown) -> str:
    raise TypeError(f"not an SDO message: {message!r}")


@_words.register
def _(message: DownloadInitiate) -> str:
    return f"download initiate {message.mux}, {_initiate(message)}"


@_words.register
def _(message: DownloadInitiateResponse) -> str:
    return f"download initiate response {message.mux}"


@_words.register
def _(message: UploadInitiate) -> str:
    return f"upload initiate {message.mux}"


@_words.register
def _(message: UploadInitiateResponse) -> str:
    return f"upload initiate response {message.mux}, {_initiate(message)}"


def _initiate(message: DownloadInitiate | UploadInitiateResponse) -> str:
    unused = f", n={message.unused}" if message.unused else ""
    if message.expedited:
        count = _bytes(4 - message.unused) if message.sized else f"size not indicated{unused}"
        return f"expedited, {count}: {hex_bytes(message.data)}"
    size = "size not indicated" if message.size is None else _bytes(message.size)
    return f"segmented, {size}{unused}"


@_words.register
def _(message: DownloadSegment) -> str:
    return f"download segment, {_segment(message)}"


@_words.register
def _(message: UploadSegmentResponse) -> str:
    return f"upload segment response, {_segment(message)}"


def _segment(message: DownloadSegment | UploadSegmentResponse) -> str:
    last = ", last" if message.last else ""
    return f"t={message.toggle}{last}, {_bytes(len(message.data))}: {hex_bytes(message.data)}"


@_words.register
def _(message: DownloadSegmentResponse) -> str:
    return f"download segment response, t={message.toggle}"


@_words.register
def _(message: UploadSegment) -> str:
    return f"upload segment request, t={message.toggle}"


@_words.register
def _(message: Abort) -> str:
    return f"abort {message.mux}, {describe_code(message.code)}"


@_words.register
def _(message: BlockDownloadInitiate) -> str:
    return f"block download initiate {message.mux}, {_block_initiate(message)}"


@_words.register
def _(message: BlockUploadInitiateResponse) -> str:
    return f"block upload initiate response {message.mux}, {_block_initiate(message)}"


def _block_initiate(message: BlockDownloadInitiate | BlockUploadInitiateResponse) -> str:
    size = "size not indicated" if message.size is None else _bytes(message.size)
    return f"{size}, {_crc_support(message.crc_supported)}"


def _crc_support(supported: bool) -> str:
    return "with CRC" if supported else "without CRC"


@_words.register
def _(message: BlockDownloadInitiateResponse) -> str:
    crc = _crc_support(message.crc_supported)
    return f"block download initiate response {message.mux}, blksize {message.block_size}, {crc}"


@_words.register
def _(message: BlockUploadInitiate) -> str:
    crc = _crc_support(message.crc_supported)
    size = f"blksize {message.block_size}, pst {message.threshold}"
    return f"block upload initiate {message.mux}, {size}, {crc}"


@_words.register
def _(message: BlockSegment) -> str:
    last = ", last" if message.last else ""
    return f"block segment {message.sequence}{last}: {hex_bytes(message.payload)}"


@_words.register
def _(message: BlockAck) -> str:
    return f"block acknowledgement, ackseq {message.sequence}, blksize {message.block_size}"


@_words.register
def _(message: BlockEnd) -> str:
    return f"block end, n={message.unused}, CRC {message.crc:04X}h"


@_words.register
def _(message: BlockEndResponse) -> str:
    return "block end response"


@_words.register
def _(message: BlockUploadStart) -> str:
    return "block upload start"


@_words.register
def _(message: Unknown) -> str:
    if not message.frame:
        return "frame without data"
    if len(message.frame) != FRAME_LENGTH:
        return f"{_bytes(len(message.frame))} instead of 8: {hex_bytes(message.frame)}"
    return f"command specifier {message.frame[0]:02X}h, which is not defined"


@_words.register
def _(message: RemoteFrame) -> str:
    return f"remote frame, DLC {message.dlc}"


# A look into this cache takes a third of what singledispatch takes to find a kind.
_describing: Callable[[type], Callable[[Message | Unknown], str]] = cache(_words.dispatch)
