"""What a case does with a device: single exchanges and whole transfers, strictly checked.

A step that is not the point of a case fails as what it is: a breach of the general rule that the
answer broke, not of the rule that the case is about.
"""

import random
from collections.abc import Generator, Iterator
from contextlib import contextmanager

from conformance.bus.channel import Channel
from conformance.device.device import Device
from conformance.device.lacking import NotTestable
from conformance.device.objects import KnownObject
from conformance.device.safety import IDENTITY, written_by
from conformance.dialogue.causes import Cause, Causes, cause_of
from conformance.dialogue.payload import MOST_PLAIN, text
from conformance.dialogue.wire import Wire
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import BlockClient, Burst, Step
from conformance.sdo.checks import ResponseChecks, ServerAborted
from conformance.sdo.client import EXPEDITED_LENGTH
from conformance.sdo.describe import describe, describe_response, hex_bytes
from conformance.sdo.frames import (
    Abort,
    BlockSegment,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    Request,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import same_data
from conformance.sdo.rules import (
    CONSTANT,
    MISSING_REFUSED,
    NOT_REFUSED,
    UPLOAD_ENDS,
    Rule,
    Violation,
)
from conformance.sdo.rules.idle import SUB_INDEX_MISSING
from conformance.sdo.rules.sizes import VARIABLE_LENGTH
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
# Indices that CiA 301 and the common profiles leave free and that no permission guards, and
# sub-indices that few objects reach.
MISSING_INDICES = (0x0F00, 0x5FF7, 0xBFF7)
MISSING_SUB_INDICES = (0xFE, 0xFD, 0x7F)


def mux_of(target: Target) -> Multiplexer:
    """Return the multiplexer of an object."""
    return target.mux if isinstance(target, KnownObject) else target


class Steps(Wire):
    """Exchanges and transfers of one case with one device."""

    def __init__(
        self,
        channel: Channel,
        device: Device,
        rule: Rule,
        seed: int,
        causes: Causes | None = None,
    ) -> None:
        """``rule`` is what the case is about; ``seed`` decides on the bytes that it writes."""
        super().__init__(channel, device, causes)
        self.rule = rule
        self.notes: list[str] = []
        self.written: set[Multiplexer] = set()
        # What objects read since anything was sent that might have changed one.
        self.seen: dict[Multiplexer, bytes] = {}
        self.checks = ResponseChecks(self.note)
        self.client = BlockClient(self.checks, device.longest)
        self._random = random.Random(f"{seed}/{rule.id}")

    def about_to_send(self, request: Request) -> None:
        """Remember what a request writes to, before an interruption could come in between."""
        super().about_to_send(request)
        self.device.extents.request(request)
        if not isinstance(request, UploadInitiate | UploadSegment):
            self.seen.clear()
        target = written_by(request)
        if target is not None:
            self.device.will_change(target)
            self.written.add(target)

    def payload(self, size: int) -> bytes:
        """Return printable bytes, others with every call and the same in every run.

        Raises NotTestable for what might be written elsewhere (see ``payload``).
        """
        nowhere = self.device.nowhere
        if size > MOST_PLAIN and not nowhere:
            raise NotTestable(
                f"needs an object that the device lacks, to write {size} bytes that do no harm "
                "where the device takes them for requests: it was not seen to refuse any"
            )
        return text(self._random, size, nowhere)

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

    def download_segments(self, data: bytes, *, first: int = 0) -> None:
        """Send what is left of a segmented download of ``data``, segments counted from 0."""
        chunks = [data[start : start + 7] for start in range(0, len(data), 7)]
        for number, chunk in enumerate(chunks[first:], first):
            self.download_segment(chunk, toggle=number % 2, last=number == len(chunks) - 1)

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
        data = uploaded.data if uploaded.counted else uploaded.data[:length]
        self._check_constant(mux_of(target), data)
        self.seen[mux_of(target)] = data
        return data

    def _check_constant(self, mux: Multiplexer, data: bytes) -> None:
        due = self.device.values.get(mux)
        # Without its type, an answer that does not count its bytes may be longer than the value.
        if due is not None and self.device.is_constant(mux) and not data.startswith(due):
            raise Violation(
                CONSTANT,
                expected=f"{mux} reads {shown(due)}, as at the beginning",
                actual=f"{mux} reads {shown(data)}",
            )

    def read(self, mux: Multiplexer) -> bytes:
        """Read an object that the server may refuse; raises ServerAborted then."""
        return self._run(self.client.upload(mux)).data

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
                f"{mux} to be refused as missing", describe_response(aborted.abort.encode())
            ) from aborted

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
        return self.abort_of(
            self.client.download(mux_of(target), data, segmented=segmented, sized=sized)
        )

    def abort_of(self, transfer: Generator[Step, bytes, object]) -> Abort | None:
        """Run a transfer; return the abort that ends it, or None when it is served."""
        try:
            self._run(transfer)
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
                    actual=describe_response(abort.encode()),
                )
        raise NotTestable(
            f"{known} takes no value near its present one ({hex_bytes(before)}): name another"
        )

    def finish_upload(self, target: Target, response: UploadInitiateResponse) -> bytes:
        """Take what is left of an upload after the answer to its initiate."""
        if response.expedited:
            length = target.length if isinstance(target, KnownObject) else None
            return response.data if response.sized else response.data[:length]
        with self._served():
            rest = self.client.upload_segments(mux_of(target), response.size)
            return self._run(rest).data

    def missing_object(self) -> Multiplexer:
        """Return the multiplexer of an object that the device refuses to read."""
        mux = self._refused([Multiplexer(index) for index in MISSING_INDICES])
        if mux is None:
            raise Violation(
                MISSING_REFUSED,
                expected="an abort: few devices have "
                + ", ".join(f"{index:04X}h" for index in MISSING_INDICES),
                actual="each of them is served",
            )
        return mux

    def missing_sub_index(self, index: int) -> Multiplexer:
        """Return a multiplexer of an existing object that the device refuses to read.

        Raises NotTestable for an object of the user's own that seems to have all sub-indices.
        """
        mux = self._refused([Multiplexer(index, sub) for sub in MISSING_SUB_INDICES])
        if mux is not None:
            return mux
        names = ", ".join(f"{sub:02X}h" for sub in MISSING_SUB_INDICES)
        if index in IDENTITY:
            raise Violation(
                MISSING_REFUSED,
                expected=f"an abort: {index:04X}h has no sub-indices {names}",
                actual="each of them is served",
            )
        variable = self.device.known.get(Multiplexer(index))
        if variable is not None and self.device.is_variable(variable):
            raise Violation(
                SUB_INDEX_MISSING,
                expected=f"an abort: {index:04X}h is a variable, without sub-indices {names}",
                actual="each of them is served",
            )
        raise NotTestable(f"{index:04X}h serves the sub-indices {names}: name a simple object")

    def _refused(self, candidates: list[Multiplexer]) -> Multiplexer | None:
        for mux in candidates:
            if self.device.policy.is_missing(mux):
                return mux  # it was asked for before
            try:
                self._run(self.client.upload(mux))
            except ServerAborted as aborted:
                if aborted.abort.code in EXISTS:
                    continue
                self.device.policy.allow_missing(mux)
                return mux
        return None

    def cause_of(self, violation: Violation) -> Cause:
        """Return the cause of a breach: what was sent last counts, if nobody took note of more."""
        return cause_of(violation, violation.rule, violation.request or self.last_sent)

    def shift(self, transfers: int) -> None:
        """Read an object some times, for a server that does something every so many transfers."""
        values = self.device.values
        long = [mux for mux in values if len(values[mux]) > EXPEDITED_LENGTH]
        for _ in range(transfers if long else 0):
            try:
                self.read(min(long, key=lambda mux: len(values[mux])))
            except (Violation, ServerAborted):
                self.recover()

    def is_known(self, error: BaseException | None) -> bool:
        """Say whether a breach has a cause that was met before."""
        return isinstance(error, Violation) and self.causes.get(self.cause_of(error)) is not None

    def breach(self, expected: str, actual: str) -> Violation:
        """Build a breach of the case's rule."""
        return Violation(self.rule, expected=expected, actual=actual)

    def _run(self, transfer: Generator[Step, bytes, Result]) -> Result:
        return self._go_on(transfer, next(transfer))

    def _go_on(
        self, transfer: Generator[Step, bytes, Result], step: Step | Ended[Result]
    ) -> Result:
        try:
            while not isinstance(step, Ended):
                awaited = self.ask(step)
                step = advance(transfer, self.receive() if awaited else None)
        except Violation as breach:
            self.device.extents.endless += breach.rule is UPLOAD_ENDS
            raise
        return step.result

    def ask(self, step: Step) -> bool:
        """Send the requests of a step; say whether a response has to come behind them."""
        burst = step if isinstance(step, Burst) else Burst((step,))
        for request in burst.requests:
            if isinstance(request, BlockSegment) and self.has_left():
                break
            self.send(request)
        return burst.awaited

    @contextmanager
    def _served(self) -> Iterator[None]:
        try:
            yield
        except ServerAborted as aborted:
            refused = Violation(
                NOT_REFUSED,
                expected=f"an answer to: {describe(self._last_sent)}",
                actual=describe_response(aborted.abort.encode()),
            )
            refused.request = self._last_sent
            raise refused from aborted

    def _open_transfer(self) -> Multiplexer:
        if self.tracker.open is None:
            raise RuntimeError("a segment needs a transfer; send() sends one without")
        return self.tracker.open


def same_value(known: KnownObject, found: bytes, due: bytes) -> bool:
    """Compare values: the 00h that ends a string is optional.

    So is that with which the device is known to fill up values: it is told so elsewhere.
    """
    return same_data(known.data_type, found, due, known.filled)


def filled_up(known: KnownObject, due: bytes, found: bytes) -> Violation:
    """Build the breach that a value was filled up with 00h."""
    return Violation(
        VARIABLE_LENGTH,
        expected=f"{known} to take values of {len(due)} bytes",
        actual=f"shorter values are filled up with 00h, {len(found)} bytes in all",
    )


def shown(data: bytes) -> str:
    """Write a value with its length; of a long one the beginning and the end."""
    if len(data) <= 32:
        return f"{len(data)} bytes: {hex_bytes(data)}"
    return f"{len(data)} bytes: {hex_bytes(data[:16])} … {hex_bytes(data[-8:])}"
