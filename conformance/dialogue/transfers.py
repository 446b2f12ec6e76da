"""What a case does with a device: single exchanges and whole transfers, strictly checked.

A step that is not the point of a case fails as what it is: a breach of the general rule that the
answer broke, not of the rule that the case is about.
"""

from collections.abc import Callable, Generator
from dataclasses import replace

from conformance.device.effort import TRIES_OF_TRANSFER
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.ended_transfers import has_left
from conformance.dialogue.exchange import Exchange, InitiateRefused
from conformance.dialogue.values import check_constant, of_another_length
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import Burst, Step
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import as_answer
from conformance.sdo.describe import hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockSegment,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import (
    NOT_REFUSED,
    SIZE,
    UPLOAD_ENDS,
    Violation,
)
from conformance.sdo.seen import Received
from conformance.sdo.stepping import Ended, Result, advance

Target = Multiplexer | KnownObject
# An upload that is refused like this met something: it must not count as missing.
EXISTS = (
    AbortCode.READ_OF_WRITE_ONLY,
    AbortCode.UNSUPPORTED_ACCESS,
    AbortCode.HARDWARE_ERROR,
    AbortCode.LOCAL_CONTROL,
    AbortCode.DEVICE_STATE,
    AbortCode.NO_DATA,
)
NOT_NOW = (
    AbortCode.VALUE_INVALID,
    AbortCode.VALUE_TOO_HIGH,
    AbortCode.VALUE_TOO_LOW,
    AbortCode.LOCAL_CONTROL,
    AbortCode.DEVICE_STATE,
)


def mux_of(target: Target) -> Multiplexer:
    """Return the multiplexer of an object."""
    return target.mux if isinstance(target, KnownObject) else target


class Transfers(Exchange):
    """Exchanges and transfers of one case on one channel of a device."""

    # One exchange each

    def initiate_download(
        self, target: Target, size: int | None = None
    ) -> DownloadInitiateResponse:
        """Start a segmented download of ``size`` bytes; for None the size is not indicated."""
        mux = mux_of(target)
        with self.served():
            self.send(DownloadInitiate.with_size(mux, size))
            return self.checks.download_initiate(self.receive(), mux)

    def download_segment(self, data: bytes, *, toggle: int, last: bool = False) -> None:
        """Send up to 7 bytes of a segmented download."""
        mux = self._open_transfer()
        with self.served():
            self.send(DownloadSegment.with_data(data, toggle=toggle, last=last))
            self.checks.download_segment(self.receive(), mux, toggle)

    def download_segments(self, data: bytes, *, first: int = 0) -> None:
        """Send what is left of a segmented download of ``data``, segments counted from 0."""
        chunks = [data[start : start + 7] for start in range(0, len(data), 7)]
        for number, chunk in enumerate(chunks[first:], first):
            self.download_segment(chunk, toggle=number % 2, last=number == len(chunks) - 1)

    def initiate_upload(self, target: Target) -> UploadInitiateResponse:
        """Start an upload."""
        mux = mux_of(target)
        with self.served():
            self.send(UploadInitiate(mux))
            return self.checks.upload_initiate(self.receive(), mux)

    def upload_segment(self, *, toggle: int) -> UploadSegmentResponse:
        """Ask for the next segment of an upload; raises Violation where the last one has come."""
        if self.line.open is None and self.line.latest is not None:
            raise Violation(
                SIZE,
                expected=f"a further segment of {self.line.latest}",
                actual="the last one came before all that was announced",
            )
        mux = self._open_transfer()
        with self.served():
            self.send(UploadSegment(toggle))
            return self.checks.upload_segment(self.receive(), mux, toggle)

    def start_segmented_upload(self, target: Target) -> UploadInitiateResponse:
        """Start an upload of an object that is too long for one frame."""
        response = self.initiate_upload(target)
        if response.expedited:
            raise Violation(
                NOT_REFUSED,
                expected=f"40h or 41h: {mux_of(target)} is longer than 4 bytes",
                actual=Received(response),
            )
        return response

    # Whole transfers

    def again_if_aborted(self, attempt: Callable[[], Result]) -> Result:
        """Return the result of an attempt that the server did not abort early.

        It may abort a running transfer at any time. After some tries the last one counts.
        """
        for rest in reversed(range(TRIES_OF_TRANSFER)):
            try:
                found = attempt()
            except (Violation, ServerAborted):
                if self.record.early.met is None or not rest:
                    raise
            else:
                if self.record.early.met is None:
                    break
            self.silence.recover(crossed=True)
        return found

    def upload(self, target: Target) -> bytes:
        """Read an object; its length is that of the type where the device does not say it."""
        with self.served():
            uploaded = self.run(self.client.upload(mux_of(target)))
        data = self.of_its_length(target, uploaded)
        check_constant(self.device, mux_of(target), data)
        self.device.contents.current[mux_of(target)] = data
        return data

    def upload_while(self, target: Target, due: bytes) -> bytes:
        """Read an object as long as it reads as ``due``.

        Of another value it returns the beginning up to the first segment that differs, and leaves
        the transfer open there: that saves thousands of requests on a very long one.
        """
        with self.served():
            try:
                return self.run(_while(self.client.upload(mux_of(target)), due))
            except _OtherData as other:
                return other.begun

    def of_its_length(self, target: Target, uploaded: Uploaded) -> bytes:
        """Return the bytes that a value of this type has; what came behind them is a breach."""
        known = target if isinstance(target, KnownObject) else self.device.known.get(target)
        data = uploaded.data
        if known is None or known.length is None or len(data) <= known.length:
            return data
        if uploaded.counted:
            self.note(of_another_length(known, data))
            self.device.learn(known, replace(known.habits, too_long=True))
        return data[: known.length]

    def read(self, target: Target) -> bytes:
        """Read an object that the server may refuse; raises ServerAborted then."""
        return self.of_its_length(target, self.run(self.client.upload(mux_of(target))))

    def read_if_there(self, mux: Multiplexer) -> bytes | None:
        """Read an object; return None where the server refuses it as missing.

        Raises Violation where it refuses for another reason: it is there then.
        """
        try:
            return self.read(mux)
        except ServerAborted as aborted:
            if aborted.abort.code not in EXISTS:
                return None
            raise self.breach(
                f"{mux} to be refused as missing", Received(aborted.abort)
            ) from aborted

    def download(
        self, target: Target, data: bytes, *, segmented: bool | None = None, sized: bool = True
    ) -> None:
        """Write an object; the server has to take it."""
        with self.served():
            self.run(self.client.download(mux_of(target), data, segmented=segmented, sized=sized))

    def try_download(
        self, target: Target, data: bytes, *, segmented: bool | None = None, sized: bool = True
    ) -> Abort | None:
        """Write an object; return the abort if the server refuses."""
        return self.abort_of(
            self.client.download(mux_of(target), data, segmented=segmented, sized=sized)
        )

    def abort_of(self, transfer: Generator[Step, Response, object]) -> Abort | None:
        """Run a transfer; return the abort that ends it, or None when it is served."""
        try:
            self.run(transfer)
        except ServerAborted as aborted:
            return aborted.abort
        return None

    def write_number(self, known: KnownObject, **how: bool) -> bytes:
        """Write another value than the present one to a number, and return it.

        Every byte changes where the object allows that, else only the lowest bit. Raises
        NotTestable when the object refuses both values.
        """
        before = self.upload(known)
        changed = bytes(byte ^ 1 for byte in before)
        for value in (changed, changed[:1] + before[1:]):
            abort = self.try_download(known, value, **how)
            if abort is None:
                return value
            if abort.code not in NOT_NOW:
                raise Violation(
                    NOT_REFUSED,
                    expected=f"a download of {hex_bytes(value)} to {known} to be confirmed",
                    actual=Received(abort),
                )
        raise NotTestable(
            f"{known} takes no value near its present one ({hex_bytes(before)}): name another"
        )

    def finish_upload(self, target: Target, response: UploadInitiateResponse) -> bytes:
        """Take what is left of an upload after the answer to its initiate."""
        if response.expedited:
            uploaded = Uploaded(response.data, response.sized)
        else:
            with self.served():
                rest = self.client.upload_segments(mux_of(target), response.size)
                uploaded = self.run(rest)
        return self.of_its_length(target, uploaded)

    def attempt(self, transfer: Generator[Step, Response, Result]) -> Result | Abort:
        """Run a transfer that the server may refuse at its initiate; return its result or abort.

        Which multiplexer such an abort carries is for the caller to check.
        """
        initiate = next(transfer)
        if isinstance(initiate, Burst):
            raise TypeError("a transfer begins with one request")
        try:
            with self.superseding():
                self.send(initiate)
                response = as_answer(self.receive())
        except InitiateRefused as refused:
            return refused.abort
        if isinstance(response, Abort):
            self.checks.abort(response, None)
            return response
        step = advance(transfer, response)
        with self.served():
            return self.go_on(transfer, step)

    # What transfers are made of

    def run(self, transfer: Generator[Step, Response, Result]) -> Result:
        """Run a transfer and return its result; raises ServerAborted for one that is refused."""
        return self.go_on(transfer, next(transfer))

    def go_on(
        self, transfer: Generator[Step, Response, Result], step: Step | Ended[Result]
    ) -> Result:
        """Run what is left of a transfer, from one of its steps on."""
        try:
            while not isinstance(step, Ended):
                response = self.receive() if self.ask(step) else None
                if isinstance(step, Burst) and response is not None and step.segments > 1:
                    step.more.extend(self.wire.arrived_segments(response, step.segments - 1))
                step = advance(transfer, response)
        except Violation as breach:
            self.device.contents.endless += breach.rule is UPLOAD_ENDS
            raise
        return step.result

    def ask(self, step: Step) -> bool:
        """Send the requests of a step; say whether a response has to come behind them."""
        if not isinstance(step, Burst):
            self.send(step)
            return True
        for request in step.requests:
            if isinstance(request, BlockSegment) and has_left(self.wire):
                break
            self.send(request)
        return step.awaited

    def _open_transfer(self) -> Multiplexer:
        if self.line.open is None:
            raise RuntimeError("a segment needs a transfer; send() sends one without")
        return self.line.open


class _OtherData(Exception):
    """An upload has brought something else than what is due; it has ``begun`` so."""

    def __init__(self, begun: bytes) -> None:
        super().__init__()
        self.begun = begun


def _while(
    upload: Generator[Step, Response, Uploaded], due: bytes
) -> Generator[Step, Response, bytes]:
    """Hand on an upload as long as its segments bring what is ``due``; raises _OtherData."""
    step, length = advance(upload), 0
    while not isinstance(step, Ended):
        answer = yield step
        if isinstance(segment := as_answer(answer), UploadSegmentResponse):
            begin, length = length, length + len(segment.data)
            due_here = due[begin:length]
            if not segment.data.startswith(due_here):
                raise _OtherData(due[:begin] + segment.data)
        step = advance(upload, answer)
    return step.result.data
