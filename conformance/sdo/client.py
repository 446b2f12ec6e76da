"""The reference client: whole transfers as generators, without a bus and without a clock.

A transfer yields requests and is sent each response:

    transfer = client.upload(Multiplexer(0x1008))
    request = next(transfer)
    ...
    request = transfer.send(response)        # StopIteration.value is the result

Every response is held to ``checks``; a breach is raised as Violation, a refusal of the server as
ServerAborted. After either the caller decides whether an abort is due to the server.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass, field

from conformance.sdo.checks import ResponseChecks
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH, SEGMENT_LENGTH
from conformance.sdo.rules import SIZE, UPLOAD_ENDS, Violation
from conformance.sdo.seen import Said, said

# The most bytes that an upload may bring of which nothing is known: what is longer is endless.
MOST_UPLOADED = (1 << 20) + (1 << 16)
# As many as those take in full segments; there may be bytes in each segment but few.
MOST_SEGMENTS = MOST_UPLOADED // SEGMENT_LENGTH
MOST_EMPTY_SEGMENTS = 16


@dataclass(frozen=True, slots=True)
class Uploaded:
    """What an upload brought.

    ``counted`` is False for an expedited answer that does not say how many of its 4 bytes count;
    ``segments`` is 0 for an expedited one.
    """

    data: bytes
    counted: bool = True
    announced: int | None = None
    segments: int = 0


def unknown_length(mux: Multiplexer) -> int:
    """Return the most bytes that an upload of any object may bring."""
    del mux
    return MOST_UPLOADED


@dataclass(frozen=True, slots=True)
class Client:
    """One SDO client; ``checks`` judge the responses.

    ``longest`` says how many bytes an upload of an object may bring before it is endless.
    """

    checks: ResponseChecks = field(default_factory=ResponseChecks)
    longest: Callable[[Multiplexer], int] = unknown_length

    def upload(self, mux: Multiplexer) -> Generator[Request, Response, Uploaded]:
        """Read an object, expedited or in segments as the server decides."""
        answer = yield UploadInitiate(mux)
        response = self.checks.upload_initiate(answer, mux)
        if response.expedited:
            return Uploaded(response.data, counted=response.sized)
        return (yield from self.upload_segments(mux, response.size))

    def upload_segments(
        self, mux: Multiplexer, announced: int | None
    ) -> Generator[Request, Response, Uploaded]:
        """Read all segments of an upload that was initiated."""
        data = bytearray()
        limit = self.longest(mux) if announced is None else min(announced, self.longest(mux))
        toggle = segments = empty = 0
        last = False
        while not last:
            answer = yield UploadSegment(toggle)
            response = self.checks.upload_segment(answer, mux, toggle)
            brought = response.data
            data += brought
            last = response.last
            segments += 1
            empty += not brought
            toggle ^= 1
            if announced is not None and (len(data) > announced or last) and len(data) != announced:
                raise Violation(
                    SIZE,
                    expected=f"{announced} bytes, as announced",
                    actual=Said(
                        f"{len(data)} bytes, the last in {in_words(response)}",
                        "… bytes, the last in upload segment response",
                    ),
                )
            too_many = segments > MOST_SEGMENTS or empty > MOST_EMPTY_SEGMENTS
            if not last and (len(data) > limit or too_many):
                raise Violation(
                    UPLOAD_ENDS,
                    expected=f"a last segment within {limit} bytes",
                    actual=said(
                        "{} segments with {} bytes and none marked as last", segments, len(data)
                    ),
                )
        return Uploaded(bytes(data), True, announced, segments)

    def download(
        self,
        mux: Multiplexer,
        data: bytes,
        *,
        segmented: bool | None = None,
        sized: bool = True,
    ) -> Generator[Request, Response, None]:
        """Write an object: expedited where it fits, else in segments.

        ``segmented`` chooses one or the other; ``sized`` says whether the size is indicated.
        Raises ValueError when the data cannot go as asked.
        """
        if segmented is None:
            segmented = not 1 <= len(data) <= EXPEDITED_LENGTH
        if segmented:
            yield from self._download_segments(mux, data, sized=sized)
            return
        if not 1 <= len(data) <= EXPEDITED_LENGTH:
            raise ValueError(f"an expedited download carries 1 to 4 bytes, not {len(data)}")
        make = DownloadInitiate.with_data if sized else DownloadInitiate.with_uncounted_data
        self.checks.download_initiate((yield make(mux, data)), mux)

    def _download_segments(
        self, mux: Multiplexer, data: bytes, *, sized: bool
    ) -> Generator[Request, Response, None]:
        answer = yield DownloadInitiate.with_size(mux, len(data) if sized else None)
        self.checks.download_initiate(answer, mux)
        toggle = 0
        for start in range(0, max(len(data), 1), SEGMENT_LENGTH):
            chunk = data[start : start + SEGMENT_LENGTH]
            last = start + SEGMENT_LENGTH >= len(data)
            answer = yield DownloadSegment.with_data(chunk, toggle=toggle, last=last)
            self.checks.download_segment(answer, mux, toggle)
            toggle ^= 1
