"""Block transfers in a case: single exchanges and whole transfers, strictly checked."""

from collections.abc import Callable, Generator, Sequence
from typing import Literal

from conformance.device.device import DEVICE_TYPE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue, named
from conformance.dialogue.ended_transfers import has_left
from conformance.dialogue.held_values import expect_read
from conformance.dialogue.transfers import Target, mux_of
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import same_value
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import Burst, Step, all_of_it
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Uploaded
from conformance.sdo.decoding import as_answer
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
    Response,
    UploadInitiateResponse,
)
from conformance.sdo.limits import LARGEST_BLOCK
from conformance.sdo.rules import NOT_REFUSED, Violation, accepted
from conformance.sdo.rules.block_download import WHOLE_SUB_BLOCK
from conformance.sdo.seen import Received, said
from conformance.sdo.stepping import Result, advance

NOT_THERE = (AbortCode.COMMAND_NOT_VALID, AbortCode.GENERAL_ERROR)


class Blocks:
    """Exchanges and transfers in blocks. A server without them gets ``Unimplemented``."""

    def __init__(self, sdo: Dialogue, recover: Callable[[], bool] | None = None) -> None:
        """``recover`` leaves the server idle after a refusal, whatever it may still send."""
        self._sdo = sdo
        self._recover = sdo.silence.recover if recover is None else recover

    def initiate_download(
        self, target: Target, size: int | None, *, crc: bool = True
    ) -> BlockDownloadInitiateResponse:
        """Announce a block download of ``size`` bytes; for None the size is not indicated."""
        mux = mux_of(target)
        request = BlockDownloadInitiate.with_size(mux, size, crc_supported=crc)
        try:
            self._sdo.send(request)
            return self._sdo.checks.block_download_initiate(self._sdo.receive(), mux)
        except ServerAborted as aborted:
            ordinary = BlockDownloadInitiate.with_size(mux, size)
            raise self._why_refused(aborted.abort, request, ordinary) from aborted

    def initiate_upload(
        self, target: Target, *, block_size: int = LARGEST_BLOCK, crc: bool = True
    ) -> BlockUploadInitiateResponse:
        """Ask for a block upload, which must not become an ordinary one (pst = 0)."""
        mux = mux_of(target)
        request = BlockUploadInitiate(mux, block_size, crc_supported=crc)
        try:
            self._sdo.send(request)
            response = self._sdo.receive()
            self._check_not_ordinary(response)
            return self._sdo.checks.block_upload_initiate(response, mux)
        except ServerAborted as aborted:
            ordinary = BlockUploadInitiate(mux, LARGEST_BLOCK)
            raise self._why_refused(aborted.abort, request, ordinary) from aborted

    def _check_not_ordinary(self, response: Response) -> None:
        """Raise NotTestable for a server that answers every block upload with an ordinary one.

        It has no block uploads; that it does not refuse them is for the cases on refusals to say,
        which read 1000h. A server that does so for some objects only goes on to fail.
        """
        if not isinstance(as_answer(response), UploadInitiateResponse):
            return
        self._sdo.end_transfer()
        self._sdo.send(BlockUploadInitiate(DEVICE_TYPE, LARGEST_BLOCK))
        answer = self._sdo.receive()
        self._sdo.end_transfer()
        if isinstance(as_answer(answer), UploadInitiateResponse):
            raise NotTestable(
                "the server answers block uploads with ordinary ones though pst = 0 forbids it: "
                "see specifier.block-upload"
            )

    def require_download(self) -> None:
        """Raise Unimplemented unless the server has block downloads; asks it once in a run.

        It lacks them where it refuses them of whatever object, with or without size. Which code is
        right then is for specifier.block-download to judge.
        """
        device = self._sdo.device
        if device.learned.block_download_refusal is None:
            found = [Roles(device).writable(), *Roles(device).all_writable()[-1:]]
            requests = [
                BlockDownloadInitiate.with_size(known.mux, size)
                for known in dict.fromkeys(found)
                for size in (len(device.values[known.mux]), None)
            ]
            device.learned.block_download_refusal = self._refusal_of_all(requests)
        if device.learned.block_download_refusal:
            raise Unimplemented(Received(device.learned.block_download_refusal))

    def require_upload(self) -> None:
        """Raise Unimplemented unless the server has block uploads; asks it once in a run.

        It lacks them where it refuses them of whatever object. Which code is right then is for
        specifier.block-upload to judge.
        """
        device = self._sdo.device
        if device.learned.block_upload_refusal is None:
            longest = max(
                device.values, key=lambda mux: len(device.values[mux]), default=DEVICE_TYPE
            )
            requests = [
                BlockUploadInitiate(mux, LARGEST_BLOCK, crc_supported=crc)
                for mux in dict.fromkeys((DEVICE_TYPE, longest))
                for crc in (False, True)
            ]
            device.learned.block_upload_refusal = self._refusal_of_all(requests)
        if device.learned.block_upload_refusal:
            raise Unimplemented(Received(device.learned.block_upload_refusal))

    def _refusal_of_all(self, requests: Sequence[Request]) -> Abort | Literal[False]:
        """Return the first refusal where every request is refused; False where one is not."""
        first: Abort | Literal[False] = False
        for request in requests:
            self._sdo.send(request)
            response = as_answer(self._sdo.receive())
            if self._sdo.line.open is not None:
                self._recover()  # the first abort of the run, as often as not: it may be answered
            if not isinstance(response, Abort):
                return False
            first = first or response
            if response.code in NOT_THERE:
                break
        return first

    def _why_refused(self, abort: Abort, request: Request, ordinary: Request) -> Exception:
        """Tell a server without block transfer from one that refuses just this request."""
        if isinstance(request, BlockDownloadInitiate):
            self.require_download()
        else:
            self.require_upload()
        refusal = Received(abort)
        served = False
        if abort.code in NOT_THERE and request != ordinary:
            self._sdo.send(ordinary)
            served = not isinstance(as_answer(self._sdo.receive()), Abort)
            self._sdo.end_transfer()
        if abort.code in NOT_THERE and not served:
            return Unimplemented(refusal)
        expected = "a block transfer to be served"
        return Violation(NOT_REFUSED, expected=expected, actual=refusal, asked=request)

    def send_segments(self, chunks: Sequence[bytes], *, first: int = 1, last: bool = False) -> None:
        """Send segments without a pause, numbered from ``first``; ``last`` marks the final one."""
        self.send_sub_block(
            [
                BlockSegment.with_data(
                    number, chunk, last=last and number == first + len(chunks) - 1
                )
                for number, chunk in enumerate(chunks, first)
            ]
        )

    def send_sub_block(self, segments: Sequence[BlockSegment]) -> None:
        """Send segments without a pause; none is sent to a server that has left the transfer."""
        for segment in segments:
            if has_left(self._sdo.wire):
                break
            self._sdo.send(segment)

    def acknowledged(self, target: Target, sent: int) -> BlockAck:
        """Expect the acknowledgement of a sub-block of ``sent`` segments.

        The server may have lost some: what it does not name has to be sent again.
        """
        with self._sdo.served():
            ack = self._sdo.checks.block_ack(self._sdo.receive(), mux_of(target), sent)
        if ack.sequence < sent:
            self._sdo.note(
                Violation(WHOLE_SUB_BLOCK, expected=f"ackseq {sent}", actual=Received(ack))
            )
        return ack

    def end_download(self, target: Target, *, unused: int, crc: int) -> None:
        """Send the end frame and expect its confirmation."""
        with self._sdo.served():
            self._sdo.send(BlockEnd(unused, crc))
            self._sdo.checks.block_end_response(self._sdo.receive(), mux_of(target))

    def start_upload(self, target: Target, block_size: int) -> list[BlockSegment]:
        """Start a block upload that was initiated; return its first sub-block."""
        return self.sub_block(target, BlockUploadStart(), block_size)

    def sub_block(self, target: Target, request: Request, block_size: int) -> list[BlockSegment]:
        """Send a request and return the sub-block that answers it."""
        mux = mux_of(target)
        with self._sdo.served():
            self._sdo.send(request)
            segments = [self._sdo.checks.block_segment(self._sdo.receive(), mux, 1)]
            while not segments[-1].last and len(segments) < block_size:
                due = len(segments) + 1
                segments.append(self._sdo.checks.block_segment(self._sdo.receive(), mux, due))
        return segments

    def end_of_upload(self, target: Target, ack: BlockAck) -> BlockEnd:
        """Acknowledge the last sub-block of a block upload and return the end frame."""
        with self._sdo.served():
            self._sdo.send(ack)
            return self._sdo.checks.block_end(self._sdo.receive(), mux_of(target))

    def download(
        self, target: Target, data: bytes, *, sized: bool = True, crc: bool = True
    ) -> None:
        """Write an object in blocks; what the server loses of a sub-block is sent again."""
        mux = mux_of(target)
        ordinary = BlockDownloadInitiate.with_size(mux, len(data))
        repeated = self._run_block(
            self._sdo.client.block_download(mux, data, sized=sized, crc=crc), ordinary
        )
        if repeated:
            self._sdo.note(
                Violation(
                    WHOLE_SUB_BLOCK,
                    expected="every segment to be taken, sent without a pause",
                    actual=said("{} segments had to be sent again", repeated),
                )
            )
        if self._sdo.device.learned.stores_in_blocks is None:
            self._sdo.device.learned.stores_in_blocks = True

    def try_download(self, target: Target, data: bytes) -> Abort | None:
        """Write an object in blocks; return the abort if the server refuses."""
        return self._sdo.abort_of(self._sdo.client.block_download(mux_of(target), data))

    def try_upload(self, target: Target) -> Uploaded | Abort:
        """Read an object in blocks; return the abort if the server refuses."""
        try:
            return self._sdo.run(self._sdo.client.block_upload(mux_of(target)))
        except ServerAborted as aborted:
            return aborted.abort

    def offers_crc(self, target: Target, size: int) -> bool:
        """Say whether the server offers a CRC for a download of ``size`` bytes."""
        response = self.initiate_download(target, size)
        self._sdo.end_transfer()
        return response.crc_supported

    def expect_download_refused(
        self, target: Target, data: bytes, *codes: AbortCode, size: int | None
    ) -> None:
        """Send a download that announces ``size`` bytes, None for no size, and has to be refused.

        At which moment is the server's choice, with the end frame at the latest.
        """
        self.require_download()
        transfer = self._sdo.client.block_download(
            mux_of(target), data, sized=size is not None, announced=size
        )
        abort = self._sdo.abort_of(transfer)
        if abort is None:
            raise self._sdo.breach(
                f"abort with {named(codes)}, at the end at the latest", "the end was confirmed"
            )
        self._sdo.take_abort(abort, codes, target, accepted.IMPRECISE)

    def upload(
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
        transfer = self._sdo.client.block_upload(
            mux,
            block_size=block_size,
            threshold=threshold,
            crc=crc,
            acknowledge=acknowledge,
            next_block_size=next_block_size,
        )
        return self._run_block(transfer, BlockUploadInitiate(mux, LARGEST_BLOCK))

    def expect_value(self, known: KnownObject, due: bytes) -> None:
        """Expect an object to read as ``due``: a long value in blocks, where those bring it."""
        found = ValueAccess(self._sdo).in_blocks(known.mux, due)
        if found is None or not same_value(known, found, due):
            expect_read(self._sdo, known, due)

    def _run_block(self, transfer: Generator[Step, Response, Result], ordinary: Request) -> Result:
        """Run a transfer; a refusal of its initiate may mean that there are no block transfers."""
        initiate = next(transfer)
        if isinstance(initiate, Burst):
            raise TypeError("a block transfer begins with one request")
        self._sdo.send(initiate)
        response = self._sdo.receive()
        if isinstance(initiate, BlockUploadInitiate) and not initiate.threshold:
            self._check_not_ordinary(response)
        try:
            step = advance(transfer, response)
        except ServerAborted as aborted:
            raise self._why_refused(aborted.abort, initiate, ordinary) from aborted
        with self._sdo.served():
            return self._sdo.go_on(transfer, step)
