"""What every response is held to, down to the last reserved bit (CiA 301, 7.2.4.3).

A breach that makes the response useless is raised. One that does not (a reserved bit that is set,
a byte without meaning that is not 0) is handed to ``note``, so that a device with that one flaw
can still be tested for everything else.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.decoding import decode_response, decode_segment
from conformance.sdo.describe import describe, describe_response, hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiateResponse,
    DownloadInitiateResponse,
    DownloadSegmentResponse,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer
from conformance.sdo.rules import (
    ABORT_CODE,
    BLOCK_ACK,
    BLOCK_SEQUENCE,
    BLOCK_SIZE,
    FILLER,
    FRAME_SHAPE,
    MULTIPLEXER,
    RESERVED,
    SPECIFIER,
    TOGGLE,
    UNUSED_COUNT,
    Rule,
    Violation,
)

Kind = TypeVar("Kind", bound=Message)
LARGEST_BLOCK = 127
_KNOWN_CODES = frozenset(AbortCode)


class ServerAborted(Exception):
    """The server answered with an abort, itself well-formed."""

    def __init__(self, abort: Abort) -> None:
        """Keep the abort, for its code and its multiplexer."""
        super().__init__(f"the server aborted {abort.mux}: {describe_code(abort.code)}")
        self.abort = abort


def raise_violation(violation: Violation) -> None:
    """Treat a minor breach like any other."""
    raise violation


@dataclass(frozen=True, slots=True)
class ResponseChecks:
    """Reads responses strictly; each method takes a frame's data bytes and what was asked.

    All raise Violation, and ServerAborted where the server refuses.
    """

    note: Callable[[Violation], None] = raise_violation

    def download_initiate(self, frame: bytes, mux: Multiplexer) -> DownloadInitiateResponse:
        """Check the confirmation of a download initiate (7.2.4.3.3)."""
        response = self._read(
            DownloadInitiateResponse, frame, mux, "60h, download initiate response"
        )
        self._same_multiplexer(response.mux, mux, frame)
        return response

    def download_segment(
        self, frame: bytes, mux: Multiplexer, toggle: int
    ) -> DownloadSegmentResponse:
        """Check the confirmation of a download segment (7.2.4.3.4)."""
        due = f"{0x20 | toggle << 4:02X}h, download segment response with t={toggle}"
        response = self._read(DownloadSegmentResponse, frame, mux, due)
        if response.toggle != toggle:
            raise Violation(TOGGLE, expected=due, actual=describe_response(frame))
        return response

    def upload_initiate(self, frame: bytes, mux: Multiplexer) -> UploadInitiateResponse:
        """Check the answer to an upload initiate (7.2.4.3.6)."""
        response = self._read(UploadInitiateResponse, frame, mux, "4xh, upload initiate response")
        self._same_multiplexer(response.mux, mux, frame)
        if response.unused and not (response.expedited and response.sized):
            raise Violation(UNUSED_COUNT, expected="n = 0", actual=describe_response(frame))
        if response.expedited:
            self._zero(FILLER, response.payload[len(response.data) :], frame)
        elif not response.sized:
            self._zero(RESERVED, response.payload, frame)
        return response

    def upload_segment(self, frame: bytes, mux: Multiplexer, toggle: int) -> UploadSegmentResponse:
        """Check a segment of an upload (7.2.4.3.7)."""
        due = f"upload segment response with t={toggle}"
        response = self._read(UploadSegmentResponse, frame, mux, due)
        if response.toggle != toggle:
            raise Violation(TOGGLE, expected=due, actual=describe_response(frame))
        self._zero(FILLER, response.payload[len(response.data) :], frame)
        return response

    def block_download_initiate(
        self, frame: bytes, mux: Multiplexer
    ) -> BlockDownloadInitiateResponse:
        """Check the confirmation of a block download initiate (7.2.4.3.9)."""
        due = "A0h or A4h, block download initiate response"
        response = self._read(BlockDownloadInitiateResponse, frame, mux, due)
        self._same_multiplexer(response.mux, mux, frame)
        self._block_size(response.block_size, frame)
        return response

    def block_ack(self, frame: bytes, mux: Multiplexer, sent: int) -> BlockAck:
        """Check the acknowledgement of a sub-block of so many segments (7.2.4.3.10)."""
        response = self._read(BlockAck, frame, mux, "A2h, block acknowledgement")
        if response.sequence > sent:
            raise Violation(
                BLOCK_ACK, expected=f"ackseq 0 to {sent}", actual=describe_response(frame)
            )
        self._block_size(response.block_size, frame)
        return response

    def block_end_response(self, frame: bytes, mux: Multiplexer) -> BlockEndResponse:
        """Check the confirmation of the end of a block download (7.2.4.3.11)."""
        return self._read(BlockEndResponse, frame, mux, "A1h, block end response")

    def block_upload_initiate(self, frame: bytes, mux: Multiplexer) -> BlockUploadInitiateResponse:
        """Check the answer to a block upload initiate (7.2.4.3.13)."""
        due = "C0h to C6h, block upload initiate response"
        response = self._read(BlockUploadInitiateResponse, frame, mux, due)
        self._same_multiplexer(response.mux, mux, frame)
        if not response.sized:
            self._zero(RESERVED, response.payload, frame)
        return response

    def block_segment(
        self, frame: bytes, mux: Multiplexer, sequence: int, *, before: int = 0
    ) -> BlockSegment:
        """Check a segment of a block upload (7.2.4.3.14).

        ``before`` is how many segments the sub-block had that came before this one.
        """
        response = decode_segment(frame)
        if isinstance(response, BlockSegment) and response.sequence == sequence:
            return response
        if len(frame) != FRAME_LENGTH:
            raise Violation(
                FRAME_SHAPE, expected="8 data bytes", actual=f"{len(frame)}: {hex_bytes(frame)}"
            )
        if isinstance(response, Abort):
            self._check_abort(response, mux, frame)
            raise ServerAborted(response)
        if isinstance(response, BlockSegment) and before and response.sequence == before + 1:
            raise Violation(
                BLOCK_SIZE,
                expected=f"{before} segments in the sub-block, as asked for",
                actual=f"{describe(response)} [{hex_bytes(frame)}]",
            )
        raise Violation(
            BLOCK_SEQUENCE,
            expected=f"segment {sequence}",
            actual=f"{describe(response)} [{hex_bytes(frame)}]",
        )

    def block_end(self, frame: bytes, mux: Multiplexer, last_payload: bytes = b"") -> BlockEnd:
        """Check the end of a block upload (7.2.4.3.15) and the unused bytes of its last segment."""
        due = "C1h to DDh, block end"
        segment = decode_segment(frame)
        if isinstance(segment, BlockSegment) and not BlockEnd.matches(frame[0]):
            # Where segments have been on their way, only exactly 80h is an abort.
            actual = f"{describe(segment)} [{hex_bytes(frame)}]"
            raise Violation(SPECIFIER, expected=due, actual=actual)
        response = self._read(BlockEnd, frame, mux, due)
        self._zero(FILLER, last_payload[7 - response.unused :], frame)
        return response

    def _block_size(self, block_size: int, frame: bytes) -> None:
        if not 1 <= block_size <= LARGEST_BLOCK:
            raise Violation(
                BLOCK_SIZE, expected="blksize 1 to 127", actual=describe_response(frame)
            )

    def abort(self, frame: bytes, mux: Multiplexer | None) -> Abort:
        """Check an abort (7.2.4.3.17); for a multiplexer of None any will do."""
        response = decode_response(frame)
        if not isinstance(response, Abort):
            raise Violation(SPECIFIER, expected="80h, abort", actual=describe_response(frame))
        self._check_abort(response, mux, frame)
        return response

    def _check_abort(self, abort: Abort, mux: Multiplexer | None, frame: bytes) -> None:
        if abort.code not in _KNOWN_CODES:
            raise Violation(
                ABORT_CODE, expected="one of the 31 abort codes", actual=describe_response(frame)
            )
        if mux is not None and abort.mux != mux:
            # It ends the transfer all the same.
            self.note(_other_multiplexer(mux, frame))
        self._reserved(abort, frame)

    def _read(self, kind: type[Kind], frame: bytes, mux: Multiplexer, due: str) -> Kind:
        if len(frame) != FRAME_LENGTH:
            raise Violation(
                FRAME_SHAPE, expected="8 data bytes", actual=f"{len(frame)}: {hex_bytes(frame)}"
            )
        response = decode_response(frame)
        if isinstance(response, Abort):
            self._check_abort(response, mux, frame)
            raise ServerAborted(response)
        if not isinstance(response, kind):
            raise Violation(SPECIFIER, expected=due, actual=describe_response(frame))
        self._reserved(response, frame)
        return response

    def _same_multiplexer(self, found: Multiplexer, due: Multiplexer, frame: bytes) -> None:
        if found != due:
            raise _other_multiplexer(due, frame)

    def _reserved(self, response: Message, frame: bytes) -> None:
        for found in response.reserved_fields():
            self.note(Violation(RESERVED, expected="0", actual=f"{found} [{hex_bytes(frame)}]"))

    def _zero(self, rule: Rule, rest: bytes, frame: bytes) -> None:
        if any(rest):
            actual = f"{hex_bytes(rest)} in bytes without data [{hex_bytes(frame)}]"
            self.note(Violation(rule, expected="00 in bytes without data", actual=actual))


def _other_multiplexer(due: Multiplexer, frame: bytes) -> Violation:
    return Violation(MULTIPLEXER, expected=f"multiplexer {due}", actual=describe_response(frame))
