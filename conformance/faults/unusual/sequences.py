"""Servers that refuse, ignore or abort in the middle of transfers, as they may at any time."""

from conformance.faults.registry import unusual
from conformance.reference.segmented_server import NO_MULTIPLEXER, Transfer
from conformance.reference.server import BlockDownload, BlockUpload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
    UploadInitiate,
    UploadSegment,
)

PERIOD = 7
NOT_WITHIN = (
    Abort,
    DownloadInitiate,
    UploadInitiate,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    BlockEndResponse,
)


@unusual("new-initiate-refused", soft=True)
class NewInitiateRefused(Server):
    """Refuses an initiate in the middle of a transfer, which ends."""

    def react(self, request: Request) -> list[Response]:
        initiate = isinstance(request, UploadInitiate | DownloadInitiate)
        if initiate and self.transfer is not None:
            mux = self.transfer.mux
            self.transfer = None
            return [Abort(mux, AbortCode.COMMAND_NOT_VALID)]
        return super().react(request)


@unusual("silent-when-idle")
class SilentWhenIdle(Server):
    """Keeps silent about frames that belong to a transfer when there is none."""

    def react(self, request: Request) -> list[Response]:
        if self.transfer is None and isinstance(request, DownloadSegment | UploadSegment):
            return []
        return super().react(request)


class _LeavesSeventh(Server):
    """Counts the transfers, and has had enough in every seventh."""

    begun = 0

    def react(self, request: Request) -> list[Response]:
        """Look for a transfer that begins, and for one that is to end."""
        before = self.transfer
        if before is not None and self.leaves and not isinstance(request, NOT_WITHIN):
            return self.within(before, request)
        responses = super().react(request)
        if self.transfer is not None and self.transfer is not before:
            self.begun += 1
            if self.leaves:
                responses += self.behind_initiate(self.transfer)
        return responses

    @property
    def leaves(self) -> bool:
        """Whether it is a seventh one."""
        return self.begun % PERIOD == 0

    def leave(self, transfer: Transfer) -> Abort:
        """End it."""
        self.transfer = None
        return Abort(transfer.mux, AbortCode.DEVICE_STATE)

    def behind_initiate(self, transfer: Transfer) -> list[Response]:
        """Go on for now."""
        del transfer
        return []

    def within(self, transfer: Transfer, request: Request) -> list[Response]:
        """End it instead of an answer."""
        del request
        return [self.leave(transfer)]


@unusual("seventh-transfer-aborted")
class SeventhAborted(_LeavesSeventh):
    """Aborts every seventh transfer, instead of the answer to its first segment."""


@unusual("seventh-transfer-aborted-unasked")
class SeventhAbortedUnasked(_LeavesSeventh):
    """Aborts every seventh transfer between its first two requests, unasked."""

    def behind_initiate(self, transfer: Transfer) -> list[Response]:
        return [self.leave(transfer)]


@unusual("seventh-transfer-aborted-crosswise")
class SeventhAbortedCrosswise(_LeavesSeventh):
    """Aborts every seventh transfer while a request of it is on the way, and refuses that."""

    def within(self, transfer: Transfer, request: Request) -> list[Response]:
        del request  # an idle server has no place for it
        return [self.leave(transfer), Abort(NO_MULTIPLEXER, AbortCode.COMMAND_NOT_VALID)]


@unusual("seventh-transfer-aborted-in-blocks")
class SeventhAbortedInBlocks(_LeavesSeventh):
    """Aborts every seventh transfer in the middle of a sub-block, or instead of its end."""

    def within(self, transfer: Transfer, request: Request) -> list[Response]:
        responses = Server.react(self, request)
        if self.transfer is not transfer:
            return responses
        match transfer:
            case BlockUpload() if transfer.ended:
                return [self.leave(transfer)]
            case BlockUpload() if len(responses) > 1 and self.begun % 2:
                return [*responses[: len(responses) // 2], self.leave(transfer)]
            case BlockDownload() if isinstance(request, BlockEnd) or transfer.ended:
                return [self.leave(transfer)]
            case BlockDownload() if any(isinstance(answer, BlockAck) for answer in responses):
                return [self.leave(transfer)]
        return responses
