"""What every response is held to, down to the last reserved bit (CiA 301, 7.2.4.3).

A breach that makes the response useless is raised. One that does not (a reserved bit that is set,
a byte without meaning that is not 0) is handed to ``note``, so that a device with that one flaw
can still be tested for everything else.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from conformance.sdo.abort_codes import describe_code
from conformance.sdo.decoding import CODES, as_answer, as_segment
from conformance.sdo.describe import hex_bytes
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
    Response,
    Unknown,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import FRAME_LENGTH, Message, Multiplexer
from conformance.sdo.limits import LARGEST_BLOCK, SEGMENT_LENGTH
from conformance.sdo.rules import (
    ABORT_CODE,
    BLOCK_ACK,
    BLOCK_SEQUENCE,
    BLOCK_SIZE,
    FILLER,
    FRAME_SHAPE,
    MULTIPLEXER,
    NOT_REFUSED,
    RESERVED,
    SPECIFIER,
    TOGGLE,
    UNUSED_COUNT,
    UPLOAD_ENDS,
    Rule,
    Violation,
)
from conformance.sdo.seen import Received, Said, filled

Kind = TypeVar("Kind", bound=Message)
WithMultiplexer = (
    DownloadInitiateResponse
    | UploadInitiateResponse
    | BlockDownloadInitiateResponse
    | BlockUploadInitiateResponse
    | Abort
)
# What is due, by its toggle bit.
DOWNLOAD_SEGMENT = (
    "20h, download segment response with t=0",
    "30h, download segment response with t=1",
)
UPLOAD_SEGMENT = ("upload segment response with t=0", "upload segment response with t=1")


class ServerAborted(Exception):
    """The server answered with an abort, itself well-formed."""

    def __init__(self, abort: Abort) -> None:
        """Keep the abort, for its code and its multiplexer."""
        super().__init__(f"the server aborted {abort.mux}: {describe_code(abort.code)}")
        self.abort = abort

    def as_violation(self) -> Violation:
        """Return the refusal as the breach that it is where the request has to be served."""
        seen = Received(self.abort)
        return Violation(NOT_REFUSED, expected="a positive answer", actual=seen)


def raise_violation(violation: Violation) -> None:
    """Treat a minor breach like any other."""
    raise violation


@dataclass(frozen=True, slots=True)
class ResponseChecks:
    """Holds responses to what is due; each method takes what came and what was asked.

    What a message was read as does not bind: a device that is wrong may be in another state.

    All raise Violation, and ServerAborted where the server refuses.
    """

    note: Callable[[Violation], None] = raise_violation

    def download_initiate(self, answer: Response, mux: Multiplexer) -> DownloadInitiateResponse:
        """Check the confirmation of a download initiate (7.2.4.3.3)."""
        response = self._read(
            DownloadInitiateResponse, answer, mux, "60h, download initiate response"
        )
        _check_multiplexer(response, mux)
        return response

    def download_segment(
        self, answer: Response, mux: Multiplexer, toggle: int
    ) -> DownloadSegmentResponse:
        """Check the confirmation of a download segment (7.2.4.3.4)."""
        due = DOWNLOAD_SEGMENT[toggle]
        response = self._read(DownloadSegmentResponse, answer, mux, due)
        if response.toggle != toggle:
            raise Violation(TOGGLE, expected=due, actual=Received(response))
        return response

    def upload_initiate(self, answer: Response, mux: Multiplexer) -> UploadInitiateResponse:
        """Check the answer to an upload initiate (7.2.4.3.6)."""
        response = self._read(UploadInitiateResponse, answer, mux, "4xh, upload initiate response")
        _check_multiplexer(response, mux)
        if response.unused and not (response.expedited and response.sized):
            raise Violation(UNUSED_COUNT, expected="n = 0", actual=Received(response))
        if response.expedited:
            self._zero(FILLER, response.payload[len(response.data) :], response)
        elif not response.sized:
            self._zero(RESERVED, response.payload, response)
        return response

    def upload_segment(
        self, answer: Response, mux: Multiplexer, toggle: int
    ) -> UploadSegmentResponse:
        """Check a segment of an upload (7.2.4.3.7)."""
        due = UPLOAD_SEGMENT[toggle]
        response = self._read(UploadSegmentResponse, answer, mux, due)
        if response.toggle != toggle:
            raise Violation(TOGGLE, expected=due, actual=Received(response))
        self._zero(FILLER, response.payload[SEGMENT_LENGTH - response.unused :], response)
        return response

    def block_download_initiate(
        self, answer: Response, mux: Multiplexer
    ) -> BlockDownloadInitiateResponse:
        """Check the confirmation of a block download initiate (7.2.4.3.9)."""
        due = "A0h or A4h, block download initiate response"
        response = self._read(BlockDownloadInitiateResponse, answer, mux, due)
        _check_multiplexer(response, mux)
        _check_block_size(response)
        return response

    def block_ack(self, answer: Response, mux: Multiplexer, sent: int) -> BlockAck:
        """Check the acknowledgement of a sub-block of ``sent`` segments (7.2.4.3.10)."""
        response = self._read(BlockAck, answer, mux, "A2h, block acknowledgement")
        if response.sequence > sent:
            raise Violation(BLOCK_ACK, expected=f"ackseq 0 to {sent}", actual=Received(response))
        _check_block_size(response)
        return response

    def block_end_response(self, answer: Response, mux: Multiplexer) -> BlockEndResponse:
        """Check the confirmation of the end of a block download (7.2.4.3.11)."""
        return self._read(BlockEndResponse, answer, mux, "A1h, block end response")

    def block_upload_initiate(
        self, answer: Response, mux: Multiplexer
    ) -> BlockUploadInitiateResponse:
        """Check the answer to a block upload initiate (7.2.4.3.13)."""
        due = "C0h to C6h, block upload initiate response"
        response = self._read(BlockUploadInitiateResponse, answer, mux, due)
        _check_multiplexer(response, mux)
        if not response.sized:
            self._zero(RESERVED, response.payload, response)
        return response

    def block_segment(
        self, answer: Response, mux: Multiplexer, sequence: int, *, before: int = 0
    ) -> BlockSegment:
        """Check a segment of a block upload (7.2.4.3.14).

        ``before`` is how many segments the sub-block had that came before this one.
        """
        response = as_segment(answer, mux)
        if isinstance(response, BlockSegment) and response.sequence == sequence:
            return response
        _check_length(response)
        if isinstance(response, Abort):
            self._check_abort(response, mux)
            raise ServerAborted(response)
        if isinstance(response, BlockSegment) and before and response.sequence == before + 1:
            raise Violation(
                BLOCK_SIZE,
                expected=f"{before} segments in the sub-block, as asked for",
                actual=Received(response),
            )
        if before and isinstance(end := as_answer(answer), BlockEnd):
            raise Violation(
                UPLOAD_ENDS,
                expected=f"segment {before} to be marked as the last (80h), where no more follow",
                actual=Received(end),
            )
        raise Violation(
            BLOCK_SEQUENCE,
            expected=f"segment {sequence}",
            actual=Received(response),
        )

    def block_end(self, answer: Response, mux: Multiplexer, last_payload: bytes = b"") -> BlockEnd:
        """Check the end of a block upload (7.2.4.3.15) and the unused bytes of its last segment."""
        due = "C1h to DDh, block end"
        segment = as_segment(answer, mux)
        if isinstance(segment, BlockSegment) and not isinstance(as_answer(answer), BlockEnd):
            raise Violation(SPECIFIER, expected=due, actual=Received(segment))
        response = self._read(BlockEnd, answer, mux, due)
        self._zero(FILLER, last_payload[7 - response.unused :], response)
        return response

    def abort(self, answer: Response, mux: Multiplexer | None) -> Abort:
        """Check an abort (7.2.4.3.17); for a multiplexer of None any will do."""
        response = as_answer(answer)
        if not isinstance(response, Abort):
            raise Violation(SPECIFIER, expected="80h, abort", actual=Received(response))
        self._check_abort(response, mux)
        return response

    def _check_abort(self, abort: Abort, mux: Multiplexer | None) -> None:
        if abort.code not in CODES:
            raise Violation(
                ABORT_CODE, expected="one of the 31 abort codes", actual=Received(abort)
            )
        if mux is not None and abort.mux != mux:
            # It ends the transfer nevertheless.
            self.note(_other_multiplexer(abort, mux))
        self._reserved(abort)

    def _read(self, kind: type[Kind], answer: Response, mux: Multiplexer, due: str) -> Kind:
        response = as_answer(answer)
        if isinstance(response, kind):
            self._reserved(response)
            return response
        _check_length(response)
        if isinstance(response, Abort):
            self._check_abort(response, mux)
            raise ServerAborted(response)
        raise Violation(SPECIFIER, expected=due, actual=Received(response))

    def _reserved(self, response: Message) -> None:
        for found in response.reserved_fields():
            actual = Said(f"{found} [{hex_bytes(response.encode())}]", "reserved fields")
            self.note(Violation(RESERVED, expected="0", actual=actual))

    def _zero(self, rule: Rule, rest: bytes, response: Message) -> None:
        if rest.strip(b"\0"):
            self.note(
                Violation(
                    rule,
                    expected="00 in bytes without data",
                    actual=filled(rest, response.encode()),
                )
            )


def _check_length(response: Response) -> None:
    """Raise Violation for what has not 8 bytes: any message but an unknown one has them."""
    if isinstance(response, Unknown) and len(response.frame) != FRAME_LENGTH:
        frame = response.frame
        raise Violation(
            FRAME_SHAPE,
            expected="8 data bytes",
            actual=Said(f"{len(frame)}: {hex_bytes(frame)}", "…: …"),
        )


def _check_block_size(response: BlockDownloadInitiateResponse | BlockAck) -> None:
    if not 1 <= response.block_size <= LARGEST_BLOCK:
        raise Violation(BLOCK_SIZE, expected="blksize 1 to 127", actual=Received(response))


def _check_multiplexer(response: WithMultiplexer, due: Multiplexer) -> None:
    if response.mux != due:
        raise _other_multiplexer(response, due)


def _other_multiplexer(response: WithMultiplexer, due: Multiplexer) -> Violation:
    return Violation(MULTIPLEXER, expected=f"multiplexer {due}", actual=Received(response))
