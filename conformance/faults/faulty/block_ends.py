"""Servers with which a block transfer goes on that is over."""

from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import Defect, fault
from conformance.reference.node import Node
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, BlockEnd, BlockEndResponse, Response
from conformance.sdo.objects import Entry


@fault("block-download-end-stored-again", Defect.STATE, "block-download.end-repeated")
class EndStoredAgain(Server):
    """Confirms the end of a block download that comes again, and stores its data once more."""

    latest: tuple[BlockEnd, Entry, bytes] | None = None

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        transfer = self.transfer
        if transfer is None and self.latest is not None and request == self.latest[0]:
            _, entry, data = self.latest
            self.store(entry, data)
            return [BlockEndResponse()]
        responses = super().on_block_end(request)
        if isinstance(transfer, BlockDownload):
            self.latest = request, transfer.entry, transfer.entry.value
        return responses


@fault("block-download-end-confirmed-again", Defect.STATE, "block-download.end-repeated")
class EndConfirmedAgain(Server):
    """Confirms the end of a block download that comes again."""

    ended = False

    def on_block_end(self, request: BlockEnd) -> list[Response]:
        if self.transfer is None and self.ended:
            return [BlockEndResponse()]
        responses = super().on_block_end(request)
        self.ended = True
        return responses


@fault(
    "block-upload-abort-before-start-ignored",
    Defect.ABORT,
    "block-upload.client-abort-then-start",
)
class AbortBeforeStartIgnored(Server):
    """Ignores an abort between the initiate and the start of a block upload."""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, BlockUpload) and not self.transfer.sent:
            return []
        return super().on_abort(request)


@fault("block-upload-abort-inside-ignored", Defect.ABORT, "block-upload.client-abort-inside")
class AbortInsideIgnored(AnswersLater):
    """Goes on with a sub-block, segment by segment, when the client aborts inside it.

    Meanwhile it serves what it is asked.
    """

    apart = 0.0011
    """Seconds from one segment to the next."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        frames = Node.receive(self, frame)
        for number, segment in enumerate(frames[1:], 1):
            self.held.append((self.now + self.apart * number, segment))
        return frames[:1]
