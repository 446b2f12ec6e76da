"""What a case says to a device and what it expects back: the ``sdo`` that cases are written with.

Steps (``initiate_download``, ``upload_segment``, …) perform one exchange and hold the answer to
everything the protocol says of it: a step that is not the point of a case fails as what it is.
Expectations (``expect_abort``, ``expect_nothing``, …) are the point: they fail by the case's rule.
"""

import random
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from typing import TypeVar

from conformance.bus.channel import Channel
from conformance.device.device import Device, NotTestable
from conformance.device.objects import KnownObject
from conformance.device.safety import written_by
from conformance.run.wire import Wire
from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.checks import ResponseChecks, ServerAborted
from conformance.sdo.client import Client
from conformance.sdo.describe import describe_response, hex_bytes
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    Message,
    Request,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
    decode_request,
    decode_response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType
from conformance.sdo.rules import NOT_REFUSED, Level, Rule, Violation

Result = TypeVar("Result")
Target = Multiplexer | KnownObject
PRINTABLE = bytes(range(0x21, 0x7F))
NO_ROOM = (
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_LOW,
    AbortCode.OUT_OF_MEMORY,
)
VALUE_REFUSED = (AbortCode.VALUE_INVALID, AbortCode.VALUE_TOO_HIGH, AbortCode.VALUE_TOO_LOW)
SUBSTITUTE = Rule(
    "abort.precise-code",
    "7.2.4.3.17",
    Level.SHOULD,
    "An abort names the reason; 08000000h (general error) is for what no other code covers.",
)


def mux_of(target: Target) -> Multiplexer:
    """Return the multiplexer of an object."""
    return target.mux if isinstance(target, KnownObject) else target


class Dialogue(Wire):
    """The conversation of one case with one device."""

    def __init__(self, channel: Channel, device: Device, rule: Rule, seed: int) -> None:
        """``rule`` is what the case is about; ``seed`` decides on the bytes that it writes."""
        super().__init__(channel, device)
        self.rule = rule
        self.minor: list[Violation] = []
        self.notes: list[str] = []
        self.written: set[Multiplexer] = set()
        self.checks = ResponseChecks(self.minor.append)
        self.client = Client(self.checks)
        self._random = random.Random(f"{seed}/{rule.id}")

    def send(self, request: Message | bytes | Request) -> None:
        """Send a request, and remember what it writes to."""
        super().send(request)
        data = request if isinstance(request, bytes) else request.encode()
        target = written_by(decode_request(data))
        if target is not None:
            self.written.add(target)

    def payload(self, size: int) -> bytes:
        """Return printable bytes, others with every call and the same in every run."""
        return bytes(self._random.choices(PRINTABLE, k=size))

    # Steps: one exchange each

    def initiate_download(
        self, target: Target, size: int | None = None
    ) -> DownloadInitiateResponse:
        """Start a segmented download of ``size`` bytes; for None the size is not indicated."""
        mux = mux_of(target)
        with self._served():
            self.send(DownloadInitiate.with_size(mux, size))
            return self.checks.download_initiate(self.receive(), mux)

    def download_segment(self, data: bytes, *, toggle: int, last: bool = False) -> None:
        """Send up to 7 bytes of a segmented download."""
        mux = self._open_transfer()
        with self._served():
            self.send(DownloadSegment.with_data(data, toggle=toggle, last=last))
            self.checks.download_segment(self.receive(), mux, toggle)

    def initiate_upload(self, target: Target) -> UploadInitiateResponse:
        """Start an upload."""
        mux = mux_of(target)
        with self._served():
            self.send(UploadInitiate(mux))
            return self.checks.upload_initiate(self.receive(), mux)

    def upload_segment(self, *, toggle: int) -> UploadSegmentResponse:
        """Ask for the next segment of an upload."""
        mux = self._open_transfer()
        with self._served():
            self.send(UploadSegment(toggle))
            return self.checks.upload_segment(self.receive(), mux, toggle)

    def start_segmented_upload(self, target: Target) -> UploadInitiateResponse:
        """Start an upload of an object that is too long for one frame."""
        response = self.initiate_upload(target)
        if response.expedited:
            raise Violation(
                NOT_REFUSED,
                expected=f"40h or 41h: {mux_of(target)} is longer than 4 bytes",
                actual=describe_response(response.encode()),
            )
        return response

    # Whole transfers

    def upload(self, target: Target) -> bytes:
        """Read an object; its length is that of the type where the device does not say it."""
        with self._served():
            uploaded = self._run(self.client.upload(mux_of(target)))
        length = target.length if isinstance(target, KnownObject) else None
        return uploaded.data if uploaded.counted else uploaded.data[:length]

    def download(
        self, target: Target, data: bytes, *, segmented: bool | None = None, sized: bool = True
    ) -> None:
        """Write an object; the server has to take it."""
        with self._served():
            self._run(self.client.download(mux_of(target), data, segmented=segmented, sized=sized))

    def try_download(
        self, target: Target, data: bytes, *, segmented: bool | None = None, sized: bool = True
    ) -> Abort | None:
        """Write an object; return the abort if the server refuses."""
        try:
            self._run(self.client.download(mux_of(target), data, segmented=segmented, sized=sized))
        except ServerAborted as aborted:
            return aborted.abort
        return None

    def store(self, known: KnownObject, data: bytes, *, sized: bool = True) -> None:
        """Write ``data`` to a string or domain, segmented unless the object has no room for it.

        Raises NotTestable when the object is too small. A device that refuses this length and
        takes a longer one is at fault.
        """
        abort = self.try_download(known, data, segmented=len(data) > 4 or None, sized=sized)
        if abort is None:
            return
        longer = self.payload(len(data) + 1)
        if abort.code in NO_ROOM and self.try_download(known, longer, segmented=True) is not None:
            raise NotTestable(
                f"{known} has no room for {len(data)} bytes (refused with "
                f"{describe_code(abort.code)}): name a larger string or domain"
            )
        raise Violation(
            NOT_REFUSED,
            expected=f"a download of {len(data)} bytes to {known}, which takes a longer one",
            actual=describe_response(abort.encode()),
        )

    def _run(self, transfer: Generator[Request, bytes, Result]) -> Result:
        request = next(transfer)
        while True:
            self.send(request)
            try:
                request = transfer.send(self.receive())
            except StopIteration as done:
                return done.value  # type: ignore[no-any-return]

    @contextmanager
    def _served(self) -> Iterator[None]:
        try:
            yield
        except ServerAborted as aborted:
            raise Violation(
                NOT_REFUSED,
                expected=f"an answer to: {self._last_sent}",
                actual=describe_response(aborted.abort.encode()),
            ) from aborted

    def _open_transfer(self) -> Multiplexer:
        if self.tracker.open is None:
            raise RuntimeError("a segment needs a transfer; send() sends one without")
        return self.tracker.open

    # Expectations: the point of a case

    def expect(self, response: Message) -> None:
        """Expect exactly this response."""
        frame = self.receive()
        if frame != response.encode():
            raise self.breach(describe_response(response.encode()), describe_response(frame))

    def expect_abort(
        self,
        *codes: AbortCode,
        of: Target | None,
        tolerated: tuple[AbortCode, ...] = (AbortCode.GENERAL_ERROR,),
    ) -> Abort:
        """Expect an abort with one of the codes and the multiplexer of ``of`` (None: any).

        ``tolerated`` codes are accepted as well but count as a breach of a SHOULD.
        """
        due = "abort with " + " or ".join(describe_code(code) for code in codes)
        frame = self.receive()
        if not isinstance(decode_response(frame), Abort):
            raise self.breach(due, describe_response(frame))
        abort = self.checks.abort(frame, None if of is None else mux_of(of))
        if abort.code in codes:
            return abort
        if abort.code not in tolerated:
            raise self.breach(due, describe_response(frame))
        self.minor.append(Violation(SUBSTITUTE, expected=due, actual=describe_response(frame)))
        return abort

    def expect_nothing(self) -> None:
        """Expect that what was sent last is not answered."""
        answer = self.reaction()
        if answer is not None:
            raise self.breach("no answer", describe_response(answer))

    def expect_silence_or_abort(self, *codes: AbortCode) -> None:
        """Expect no answer, or an abort with one of the codes; without codes, with any.

        The multiplexer is not checked: no clause says which one such an abort carries.
        """
        answer = self.reaction()
        if answer is None:
            return
        named = " or ".join(describe_code(code) for code in codes) or "any abort code"
        response = decode_response(answer)
        if not isinstance(response, Abort) or (codes and response.code not in codes):
            raise self.breach(f"no answer, or an abort with {named}", describe_response(answer))
        self.checks.abort(answer, None)

    def expect_value(self, known: KnownObject, due: bytes) -> None:
        """Expect an object to read as ``due``; a string may end in 00h."""
        found = self.upload(known)
        if not same_value(known, found, due):
            raise self.breach(f"{known} reads {shown(due)}", f"{known} reads {shown(found)}")

    @contextmanager
    def unchanged(self, known: KnownObject) -> Iterator[bytes]:
        """Expect an object to keep its value; what a domain keeps of an aborted write is open."""
        before = self.upload(known)
        yield before
        self.end_transfer()
        if known.data_type is not DataType.DOMAIN:
            self.expect_value(known, before)

    def expect_clean(self, rule: Rule) -> None:
        """Expect that no response of this case broke a rule that does not stop a transfer."""
        for violation in self.minor:
            if violation.rule is rule:
                raise violation

    def info(self, note: str) -> None:
        """Record what the device does where the specification says nothing."""
        self.notes.append(note)

    def breach(self, expected: str, actual: str) -> Violation:
        """Build a breach of the case's rule."""
        return Violation(self.rule, expected=expected, actual=actual)


def same_value(known: KnownObject, found: bytes, due: bytes) -> bool:
    """Compare values: the 00h that ends a string is optional."""
    if known.data_type is DataType.VISIBLE_STRING:
        return found.rstrip(b"\0") == due.rstrip(b"\0")
    return found == due


def shown(data: bytes) -> str:
    """Write a value with its length; of a long one the beginning and the end."""
    if len(data) <= 32:
        return f"{len(data)} bytes: {hex_bytes(data)}"
    return f"{len(data)} bytes: {hex_bytes(data[:16])} … {hex_bytes(data[-8:])}"
