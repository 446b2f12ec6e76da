"""Transfers in a log, followed to their ends: each in a line of words.

Of a transfer little is kept, however long it is: counts, the CRC so far, and the sub-block that is
on its way.
"""

from dataclasses import dataclass, field

from conformance.sdo.abort_codes import describe_code
from conformance.sdo.crc import crc16
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
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer

SEGMENT = 7


@dataclass(slots=True)
class Transfer:
    """A transfer with segments: what it is, what was announced, and what has come over so far.

    ``crc`` is None where client and server do not both compute one. ``held`` are the bytes of the
    last segment, of which the end of a block transfer says how many count. ``sent`` counts the
    segments of a sub-block, ``in_order`` are those that the other side can take. Once it has all,
    the transfer is ``complete``: what is sent then are the last segment and its acknowledgement
    again.
    """

    word: str
    mux: Multiplexer
    begun: float
    in_blocks: bool
    announced: int | None = None
    size: int = 0
    segments: int = 0
    again: int = 0
    sub_blocks: int = 0
    crc: int | None = 0
    sent: int = 0
    in_order: list[BlockSegment] = field(default_factory=list)
    complete: bool = False
    held: bytes = b""
    end: BlockEnd | None = None

    def confirm(self, data: bytes) -> None:
        """Take a segment that was confirmed."""
        self.segments += 1
        self.size += len(data)

    def send(self, segment: BlockSegment) -> None:
        """Take a segment of a sub-block, which is still to be acknowledged."""
        if self.complete:
            self.again += 1
            return
        self.sent += 1
        if segment.sequence == len(self.in_order) + 1:
            self.in_order.append(segment)

    def acknowledge(self, sequence: int) -> None:
        """Take that the first segments of a sub-block have come over; the others come again."""
        if self.complete:
            return
        self.sub_blocks += 1
        self.again += max(0, self.sent - sequence)
        for segment in self.in_order[:sequence]:
            if self.crc is not None:
                self.crc = crc16(self.held, self.crc)
            self.held = segment.payload
            self.confirm(segment.payload)
            self.complete = segment.last
        self.sent = 0
        self.in_order.clear()

    def ended(self, now: float) -> str:
        """Describe the transfer; the time is in seconds."""
        size = self.size - (self.end.unused if self.end else 0)
        parts = [f"{self.word} of {_counted(size, 'byte')} {self._whose}"]
        parts[0] += f" in {self._steps}"
        if self.announced not in (None, size):
            parts.append(f"{self.announced} were announced")
        if self.again:
            parts.append(f"{_counted(self.again, 'segment')} sent again")
        if self.in_blocks:
            parts.append(self._crc)
        return f"{', '.join(parts)}, {_milliseconds(now - self.begun)}"

    def broken_off(self, why: str, now: float) -> str:
        """Say how far it came."""
        all_of = "" if self.announced is None else f" of {_counted(self.announced, 'byte')}"
        came = _counted(self.segments, "segment") if self.segments else "the initiate"
        time = _milliseconds(now - self.begun)
        return f"{self.word}{all_of} {self._whose} {why} behind {came}, {time}"

    @property
    def is_under_way(self) -> bool:
        """Whether a segment was sent; before that the answer to the initiate says all."""
        return bool(self.segments or self.sent)

    @property
    def _whose(self) -> str:
        return f"{'to' if self.word.endswith('download') else 'from'} {self.mux}"

    @property
    def _steps(self) -> str:
        if self.in_blocks:
            return _counted(self.sub_blocks, "sub-block")
        return _counted(self.segments, "segment")

    @property
    def _crc(self) -> str:
        if self.crc is None or self.end is None:
            return "without CRC"
        due = crc16(self.held[: SEGMENT - self.end.unused], self.crc)
        if due == self.end.crc:
            return "CRC right"
        return f"CRC wrong ({self.end.crc:04X}h instead of {due:04X}h)"


class Transfers:
    """Follows one channel; one that the log has not seen from its beginning is not told."""

    def __init__(self) -> None:
        """Start outside any transfer."""
        self._open: Transfer | None = None
        self._segment: DownloadSegment | None = None

    def request(self, message: Request, now: float) -> str:
        """Take a message of the client; describe the transfer that it ends, empty if none."""
        told = ""
        match message:
            case (
                DownloadInitiate()
                | UploadInitiate()
                | BlockDownloadInitiate()
                | BlockUploadInitiate()
            ):
                told = self._left(now)
                self._open = _begun(message, now)
            case Abort():
                told = self._aborted(message, "client", now)
            case DownloadSegment():
                self._segment = message
            case BlockSegment() if self._open is not None:
                self._open.send(message)
            case BlockAck() if self._open is not None:
                self._open.acknowledge(message.sequence)
            case BlockEnd() if self._open is not None:
                self._open.end = message
            case BlockEndResponse():
                told = self._ended(now)
        return told

    def response(self, message: Response, now: float) -> str:
        """Take a message of the server; describe the transfer that it ends, empty if none."""
        transfer = self._open
        told = ""
        match message:
            case Abort():
                told = self._aborted(message, "server", now)
            case _ if transfer is None:
                pass
            case UploadInitiateResponse() if message.expedited:
                self._open = None
            case UploadInitiateResponse():
                # It may answer a block upload initiate as well.
                transfer.in_blocks, transfer.word = False, "upload"
                transfer.announced = message.size
            case DownloadSegmentResponse() if self._segment is not None:
                segment, self._segment = self._segment, None
                transfer.confirm(segment.data)
                told = self._ended(now) if segment.last else ""
            case UploadSegmentResponse():
                transfer.confirm(message.data)
                told = self._ended(now) if message.last else ""
            case BlockDownloadInitiateResponse():
                transfer.crc = transfer.crc if message.crc_supported else None
            case BlockUploadInitiateResponse():
                transfer.announced = message.size
                transfer.crc = transfer.crc if message.crc_supported else None
            case BlockSegment():
                transfer.send(message)
            case BlockAck():
                transfer.acknowledge(message.sequence)
            case BlockEnd():
                transfer.end = message
            case BlockEndResponse():
                told = self._ended(now)
        return told

    def _ended(self, now: float) -> str:
        transfer, self._open = self._open, None
        return "" if transfer is None else transfer.ended(now)

    def _aborted(self, abort: Abort, by: str, now: float) -> str:
        transfer, self._open, self._segment = self._open, None, None
        if transfer is None or not transfer.is_under_way:
            return ""
        ended = transfer.broken_off(f"aborted by the {by}", now)
        return f"{ended}: {describe_code(abort.code)}"

    def _left(self, now: float) -> str:
        transfer, self._open, self._segment = self._open, None, None
        if transfer is None or not transfer.is_under_way:
            return ""
        return transfer.broken_off("left by the client", now)


def _begun(
    message: DownloadInitiate | UploadInitiate | BlockDownloadInitiate | BlockUploadInitiate,
    now: float,
) -> Transfer | None:
    """Return the transfer that a request begins; None if its answer ends it."""
    match message:
        case DownloadInitiate():
            if message.expedited:
                return None
            return Transfer("download", message.mux, now, False, message.size)
        case UploadInitiate():
            return Transfer("upload", message.mux, now, False)
        case BlockDownloadInitiate():
            transfer = Transfer("block download", message.mux, now, True, message.size)
        case BlockUploadInitiate():
            transfer = Transfer("block upload", message.mux, now, True)
    transfer.crc = 0 if message.crc_supported else None
    return transfer


def _counted(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _milliseconds(seconds: float) -> str:
    return f"{seconds * 1000:.1f} ms"
