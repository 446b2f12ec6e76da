"""Block transfers in a case: single exchanges and whole transfers, strictly checked."""

from collections.abc import Callable, Generator, Sequence

from conformance.device.device import DEVICE_TYPE
from conformance.device.lacking import NotTestable, Unimplemented
from conformance.device.objects import KnownObject
from conformance.dialogue.room import RoomSteps
from conformance.dialogue.transfers import Target, mux_of
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import LARGEST_BLOCK, Burst, Step, all_of_it
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import decode_response
from conformance.sdo.describe import describe_response
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    BlockUploadStart,
    Request,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import BLOCK_ACK, NOT_REFUSED, Violation
from conformance.sdo.stepping import Result, advance

# A server's timer may be coarse: its time-out takes up to half as long again as it is declared.
PATIENCE = 1.5
NOT_THERE = (AbortCode.COMMAND_NOT_VALID, AbortCode.GENERAL_ERROR)


def segments_of(data: bytes) -> list[bytes]:
    """Return the data in pieces of 7 bytes; of no data one empty piece."""
    return [data[start : start + 7] for start in range(0, max(len(data), 1), 7)]


class BlockSteps(RoomSteps):
    """Exchanges and transfers in blocks. A server without them gets ``Unimplemented``."""

    def initiate_block_download(
        self, target: Target, size: int | None, *, crc: bool = True
    ) -> BlockDownloadInitiateResponse:
        """Announce a block download of ``size`` bytes; for None the size is not indicated."""
        mux = mux_of(target)
        request = BlockDownloadInitiate.with_size(mux, size, crc_supported=crc)
        try:
            self.send(request)
            return self.checks.block_download_initiate(self.receive(), mux)
        except ServerAborted as aborted:
            ordinary = BlockDownloadInitiate.with_size(mux, size)
            raise self._why_refused(aborted.abort, request, ordinary) from aborted

    def initiate_block_upload(
        self, target: Target, *, block_size: int = LARGEST_BLOCK, crc: bool = True
    ) -> BlockUploadInitiateResponse:
        """Ask for a block upload, which must not become an ordinary one (pst = 0)."""
        mux = mux_of(target)
        request = BlockUploadInitiate(mux, block_size, crc_supported=crc)
        try:
            self.send(request)
            frame = self.receive()
            self._check_not_ordinary(frame)
            return self.checks.block_upload_initiate(frame, mux)
        except ServerAborted as aborted:
            ordinary = BlockUploadInitiate(mux, LARGEST_BLOCK)
            raise self._why_refused(aborted.abort, request, ordinary) from aborted

    def _check_not_ordinary(self, frame: bytes) -> None:
        """Raise NotTestable for a server that answers every block upload with an ordinary one.

        It has no block uploads; that it does not refuse them is for the cases on refusals to say,
        which read 1000h. A server that does so for some objects only goes on to fail.
        """
        if not isinstance(decode_response(frame), UploadInitiateResponse):
            return
        self.end_transfer()
        self.send(BlockUploadInitiate(DEVICE_TYPE, LARGEST_BLOCK))
        answer = self.receive()
        self.end_transfer()
        if isinstance(decode_response(answer), UploadInitiateResponse):
            raise NotTestable(
                "the server answers block uploads with ordinary ones though pst = 0 forbids it: "
                "see specifier.block-upload"
            )

    def require_block_download(self) -> None:
        """Raise Unimplemented unless the server has block downloads; asks it once in a run.

        It lacks them where it refuses them of whatever object, with or without size. Which code is
        right then is for specifier.block-download to judge.
        """
        device = self.device
        if device.block_download_refusal is None:
            found = [device.writable(), *device.all_writable()[-1:]]
            requests = [
                BlockDownloadInitiate.with_size(known.mux, size)
                for known in dict.fromkeys(found)
                for size in (len(device.values[known.mux]), None)
            ]
            device.block_download_refusal = self._refusal_of_all(requests)
        if device.block_download_refusal:
            raise Unimplemented(device.block_download_refusal)

    def require_block_upload(self) -> None:
        """Raise Unimplemented unless the server has block uploads; asks it once in a run.

        It lacks them where it refuses them of whatever object. Which code is right then is for
        specifier.block-upload to judge.
        """
        device = self.device
        if device.block_upload_refusal is None:
            longest = max(
                device.values, key=lambda mux: len(device.values[mux]), default=DEVICE_TYPE
            )
            requests = [
                BlockUploadInitiate(mux, LARGEST_BLOCK, crc_supported=crc)
                for mux in dict.fromkeys((DEVICE_TYPE, longest))
                for crc in (False, True)
            ]
            device.block_upload_refusal = self._refusal_of_all(requests)
        if device.block_upload_refusal:
            raise Unimplemented(device.block_upload_refusal)

    def _refusal_of_all(self, requests: Sequence[Request]) -> str:
        """Return the first refusal where every request is refused; empty where one is not."""
        first = ""
        for request in requests:
            self.send(request)
            frame = self.receive()
            response = decode_response(frame)
            if self.tracker.open is not None:
                self.recover()  # the first abort of the run, as often as not: it may be answered
            if not isinstance(response, Abort):
                return ""
            first = first or describe_response(frame)
            if response.code in NOT_THERE:
                break
        return first

    def _why_refused(self, abort: Abort, request: Request, ordinary: Request) -> Exception:
        """Tell a server without block transfer from one that refuses just this request."""
        if isinstance(request, BlockDownloadInitiate):
            self.require_block_download()
        else:
            self.require_block_upload()
        shown = describe_response(abort.encode())
        served = False
        if abort.code in NOT_THERE and request != ordinary:
            self.send(ordinary)
            served = not isinstance(decode_response(self.receive()), Abort)
            self.end_transfer()
        if abort.code in NOT_THERE and not served:
            return Unimplemented(shown)
        refused = Violation(NOT_REFUSED, expected="a block transfer to be served", actual=shown)
        refused.request = request
        return refused

    def send_segments(self, chunks: Sequence[bytes], *, first: int = 1, last: bool = False) -> None:
        """Send segments without a pause, numbered from ``first``; ``last`` marks the final one.

        None is sent to a server that has left the transfer.
        """
        for number, chunk in enumerate(chunks):
            if self.has_left():
                break
            final = last and number == len(chunks) - 1
            self.send(BlockSegment.with_data(first + number, chunk, last=final))

    def acknowledged(self, target: Target, sequence: int) -> BlockAck:
        """Expect the acknowledgement of the segments up to ``sequence``."""
        with self._served():
            frame = self.receive()
            ack = self.checks.block_ack(frame, mux_of(target), LARGEST_BLOCK)
        if ack.sequence != sequence:
            raise Violation(
                BLOCK_ACK, expected=f"ackseq {sequence}", actual=describe_response(frame)
            )
        return ack

    def gap_acknowledged(self, target: Target, sequence: int) -> BlockAck | None:
        """Expect the acknowledgement of the segments before a gap, up to ``sequence``.

        When it comes is the server's choice: at once, at the end of the sub-block, or with its
        time-out, when it may as well give up. Where that time is declared it is waited for; where
        it is not, silence is recorded. Returns None, and no transfer runs, if there is none.
        """
        declared, seconds = self.device.server_timeout, self.channel.response_timeout
        data = self.wait(seconds + PATIENCE * (declared or 0))
        if data is None and declared is None:
            self.notes.append(
                f"a gap is not acknowledged within {seconds * 1000:g} ms: declare the time after "
                "which the device acknowledges it, or gives up, with --sdo-server-timeout=SECONDS"
            )
            self.end_transfer()
            return None
        if data is None:
            raise Violation(
                BLOCK_ACK,
                expected=f"ackseq {sequence}, with the declared time-out at the latest",
                actual=f"nothing within {seconds + PATIENCE * (declared or 0):.3g} s",
            )
        response = decode_response(data)
        if declared and isinstance(response, Abort) and response.code == AbortCode.TIMED_OUT:
            self.checks.abort(data, mux_of(target))
            self.notes.append("a gap is not acknowledged: the server gives up")
            return None
        with self._served():
            ack = self.checks.block_ack(data, mux_of(target), LARGEST_BLOCK)
        if ack.sequence != sequence:
            raise Violation(
                BLOCK_ACK, expected=f"ackseq {sequence}", actual=describe_response(data)
            )
        return ack

    def end_block_download(self, target: Target, *, unused: int, crc: int) -> None:
        """Send the end frame and expect its confirmation."""
        with self._served():
            self.send(BlockEnd(unused, crc))
            self.checks.block_end_response(self.receive(), mux_of(target))

    def start_block_upload(self, target: Target, block_size: int) -> list[BlockSegment]:
        """Start a block upload that was initiated; return its first sub-block."""
        return self.sub_block(target, BlockUploadStart(), block_size)

    def sub_block(self, target: Target, request: Request, block_size: int) -> list[BlockSegment]:
        """Send a request and return the sub-block that answers it."""
        mux = mux_of(target)
        with self._served():
            self.send(request)
            segments = [self.checks.block_segment(self.receive(), mux, 1)]
            while not segments[-1].last and len(segments) < block_size:
                due = len(segments) + 1
                segments.append(self.checks.block_segment(self.receive(), mux, due))
        return segments

    def end_of_block_upload(self, target: Target, ack: BlockAck) -> BlockEnd:
        """Acknowledge the last sub-block of a block upload and return the end frame."""
        with self._served():
            self.send(ack)
            return self.checks.block_end(self.receive(), mux_of(target))

    def block_download(
        self, target: Target, data: bytes, *, sized: bool = True, crc: bool = True
    ) -> None:
        """Write an object in blocks: every segment has to be taken at once."""
        mux = mux_of(target)
        ordinary = BlockDownloadInitiate.with_size(mux, len(data))
        repeated = self._run_block(
            self.client.block_download(mux, data, sized=sized, crc=crc), ordinary
        )
        if repeated:
            raise Violation(
                BLOCK_ACK,
                expected="every segment to be taken, sent without a gap",
                actual=f"{repeated} segments had to be sent again",
            )

    def try_block_download(self, target: Target, data: bytes) -> Abort | None:
        """Write an object in blocks; return the abort if the server refuses."""
        return self.abort_of(self.client.block_download(mux_of(target), data))

    def try_block_upload(self, target: Target) -> Uploaded | Abort:
        """Read an object in blocks; return the abort if the server refuses."""
        try:
            return self._run(self.client.block_upload(mux_of(target)))
        except ServerAborted as aborted:
            return aborted.abort

    def attempt(self, transfer: Generator[Step, bytes, Result]) -> Result | Abort:
        """Run a transfer that the server may refuse at its initiate; return its result or abort.

        Which multiplexer such an abort carries is for the caller to check.
        """
        initiate = next(transfer)
        if isinstance(initiate, Burst):
            raise TypeError("a transfer begins with one request")
        superseded = self.tracker.open
        self.send(initiate)
        frame = self.receive()
        response = decode_response(frame)
        if isinstance(response, Abort):
            self.checks.abort(frame, None)
            served = self.behind_superseded(response, superseded) if superseded else None
            if served is None:
                return response
            frame = served
        step = advance(transfer, frame)
        with self._served():
            return self._go_on(transfer, step)

    def behind_superseded(self, abort: Abort, superseded: Multiplexer) -> bytes | None:
        """Return the answer to a new initiate that follows an abort of the superseded transfer.

        None where there is none: the server has refused the new one.
        """
        if abort.mux != superseded:
            return None
        frame = self.wait(self.channel.pace.soon(self.channel.response_timeout))
        if frame is not None:
            self.notes.append("the superseded transfer is aborted, and the new one is served")
        return frame

    def block_crc_supported(self, known: KnownObject) -> bool:
        """Say whether the server offers a CRC for a block download to a string or domain."""
        response = self.initiate_block_download(known, self.fit(known, 14))
        self.end_transfer()
        return response.crc_supported

    def block_upload(
        self,
        target: Target,
        *,
        block_size: int = LARGEST_BLOCK,
        crc: bool = True,
        threshold: int = 0,
        acknowledge: Callable[[int], int] = all_of_it,
        next_block_size: Callable[[int], int] | None = None,
    ) -> Uploaded:
        """Read an object in blocks."""
        mux = mux_of(target)
        transfer = self.client.block_upload(
            mux,
            block_size=block_size,
            threshold=threshold,
            crc=crc,
            acknowledge=acknowledge,
            next_block_size=next_block_size,
        )
        return self._run_block(transfer, BlockUploadInitiate(mux, LARGEST_BLOCK))

    def _run_block(self, transfer: Generator[Step, bytes, Result], ordinary: Request) -> Result:
        """Run a transfer; a refusal of its initiate may mean that there are no block transfers."""
        initiate = next(transfer)
        if isinstance(initiate, Burst):
            raise TypeError("a block transfer begins with one request")
        self.send(initiate)
        frame = self.receive()
        if isinstance(initiate, BlockUploadInitiate) and not initiate.threshold:
            self._check_not_ordinary(frame)
        try:
            step = advance(transfer, frame)
        except ServerAborted as aborted:
            raise self._why_refused(aborted.abort, initiate, ordinary) from aborted
        with self._served():
            return self._go_on(transfer, step)
