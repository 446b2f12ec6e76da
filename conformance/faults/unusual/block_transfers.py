"""Servers without block transfers or CRC, or that refuse block requests in their own way."""

from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import About, unusual
from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.objects import Refusal


@unusual("no-block-crc")
class NoCrc(Server):
    """Has no CRC: A0h, C0h and C2h."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        return False


@unusual("block-crc-mirrored")
class CrcMirrored(Server):
    """Offers a CRC to a client that has one, and to no other."""

    def can_compute_crc(self, request: BlockDownloadInitiate | BlockUploadInitiate) -> bool:
        return request.crc_supported


@unusual("no-block-transfer")
class NoBlockTransfer(SegmentedServer):
    """Has no block transfer."""


@unusual("new-initiate-in-block-refused")
class NewInitiateRefused(Server):
    """Refuses an initiate in the middle of a block transfer, which ends."""

    def react(self, request: Request) -> list[Response]:
        running = self.transfer
        initiate = isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        )
        if initiate and isinstance(running, BlockDownload | BlockUpload):
            self.transfer = None
            return [Abort(running.mux, AbortCode.COMMAND_NOT_VALID)]
        return super().react(request)


@unusual("strict-about-block-requests")
class StrictAboutBlocks(Server):
    """Refuses requests of a block transfer with reserved bits set, like A6h."""

    def react(self, request: Request) -> list[Response]:
        match request:
            case (
                BlockDownloadInitiate(reserved_bits=bits)
                | BlockEnd(reserved_bits=bits)
                | BlockUploadInitiate(reserved_bits=bits)
                | BlockUploadStart(reserved_bits=bits)
                | BlockAck(reserved_bits=bits)
                | BlockEndResponse(reserved_bits=bits)
            ) if bits:
                raise Refusal(AbortCode.COMMAND_NOT_VALID)
            case _:
                return super().react(request)


@unusual("new-initiate-at-block-end-refused")
class NewInitiateAtEndRefused(Server):
    """Refuses an initiate where the end of a block transfer is due, in the initiate's own name."""

    def react(self, request: Request) -> list[Response]:
        transfer = self.transfer
        at_end = isinstance(transfer, BlockDownload | BlockUpload) and transfer.ended
        if at_end and isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        ):
            self.transfer = None
            return [Abort(request.mux, AbortCode.DEVICE_STATE)]
        return super().react(request)


@unusual("block-frames-called-not-valid", soft=True)
class BlockFramesNotValid(Server):
    """Calls a wrong block size in an acknowledgement, or a bad end frame, not valid (05040001h)."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if isinstance(request, BlockAck | BlockEnd):
            code = AbortCode.COMMAND_NOT_VALID
        return super().refuse(request, code)


@unusual("superseded-transfer-aborted")
class SupersededAborted(Server):
    """Aborts a transfer that is superseded on the bus, and serves the new initiate."""

    def react(self, request: Request) -> list[Response]:
        superseded = self.transfer
        initiate = isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        )
        if superseded is None or not initiate:
            return super().react(request)
        try:
            answers = super().react(request)
        except Refusal as refusal:
            answers = self.refuse(request, refusal.code)
        return [Abort(superseded.mux, self.code_before(answers)), *answers]

    def code_before(self, answers: list[Response]) -> int:
        """Return the code of the abort that comes before the answer to the new initiate."""
        del answers
        return AbortCode.DEVICE_STATE


class SupersededAbortedAlike(SupersededAborted):
    """Says of a superseded transfer what is wrong with the new initiate, if anything is."""

    def code_before(self, answers: list[Response]) -> int:
        answer = answers[0]
        return answer.code if isinstance(answer, Abort) else super().code_before(answers)


@unusual("superseded-transfer-aborted-then-served", about=About.TIME, server=SupersededAborted)
class AbortedThenServed(AnswersLater):
    """Aborts a transfer that is superseded at once, and serves the new initiate 2 ms later."""

    delay = 0.002

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        due = [answer for _, answer in self.held]
        self.held.clear()
        frames = Node.receive(self, frame)
        if len(frames) > 1 and Abort.matches(frames[0].data[0]):
            self.hold(frames[1:])
            frames = frames[:1]
        return due + frames


@unusual("superseded-transfer-aborted-alike", about=About.TIME, server=SupersededAbortedAlike)
class AbortedAlike(AbortedThenServed):
    """Aborts a superseded transfer by the code by which it refuses the new initiate 2 ms later."""
