"""Servers that abort block downloads wrongly, or are aborted wrongly in them."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, BlockSegment, Request, Response
from conformance.sdo.layout import Multiplexer

INSIDE = "block-download.too-many-inside"


class _OnAbort(Server):
    """Does something of its own with the abort of a block download."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Pass it to ``on_download_abort``."""
        transfer = self.transfer
        if not isinstance(transfer, BlockDownload):
            return super().on_abort(request)
        self.transfer = None
        return self.on_download_abort(transfer, request)

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        del transfer, request
        return []


@fault("block-download-abort-echoed", Defect.ABORT, "block-download.client-abort")
class AbortEchoed(_OnAbort):
    """Sends the abort of a block download back."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        return [request]


@fault("block-download-abort-taken-for-segment", Defect.ABORT, "block-download.client-abort")
class AbortAsSegment(_OnAbort):
    """Takes an abort between the segments for a segment with number 0, and refuses it."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        if transfer.ended:
            return []
        return [Abort(transfer.mux, AbortCode.INVALID_SEQUENCE_NUMBER)]


@fault("block-download-abort-ignored-at-end", Defect.ABORT, "block-download.client-abort-then-end")
class AbortIgnoredAtEnd(_OnAbort):
    """Goes on with a block download that is aborted where its end is due."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        self.transfer = transfer if transfer.ended else None
        return []


@fault("block-download-abort-ignored", Defect.ABORT, "block-download.client-abort")
class AbortIgnored(_OnAbort):
    """Goes on with a block download that is aborted once between its segments."""

    ignored: BlockDownload | None = None

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        if transfer.data and not transfer.ended and self.ignored is not transfer:
            self.ignored = self.transfer = transfer
        return []


@fault("block-download-abort-commits", Defect.ABORT, "block-download.number-kept")
class AbortCommits(_OnAbort):
    """Stores what has come of a block download that the client aborts."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        if transfer.data:
            transfer.entry.value = bytes(transfer.data)[: transfer.entry.longest]
        return []


@fault(
    "block-download-abort-acknowledged",
    Defect.ABORT,
    "block-download.client-abort",
    "matrix.block-download-first",
    "matrix.block-download-inside",
    "matrix.block-download-between",
)
class AbortAcknowledged(_OnAbort):
    """Acknowledges what has come of a block download that the client aborts."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        return [self.acknowledge(transfer)]


class _LongSubBlock(Server):
    """Aborts otherwise when too much has come inside a sub-block of which many segments came."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        transfer = self.transfer
        many = isinstance(transfer, BlockDownload) and transfer.due > 1
        responses = super().refuse(request, code)
        if not many or not isinstance(request, BlockSegment):
            return responses
        return [self.spoilt(found) for found in responses if isinstance(found, Abort)]

    def spoilt(self, abort: Abort) -> Abort:
        """Return the abort as it is sent."""
        return abort


@fault("block-download-abort-inside-code-private", Defect.ABORT, INSIDE)
class InsidePrivate(_LongSubBlock):
    """Aborts with a code of its own inside a sub-block."""

    def spoilt(self, abort: Abort) -> Abort:
        return replace(abort, code=0x0607_0099)


@fault("block-download-abort-inside-multiplexer-foreign", Defect.ABORT, INSIDE)
class InsideForeign(_LongSubBlock):
    """Names another object in an abort inside a sub-block."""

    def spoilt(self, abort: Abort) -> Abort:
        return replace(abort, mux=Multiplexer(0x1018, 1))


@fault("block-download-deaf-when-aborted", Defect.ABORT, "block-download.client-abort")
class DeafWhenAborted(Server):
    """Knows nothing but the segment that is due within a sub-block, not even an abort."""

    def on_abort(self, request: Abort) -> list[Response]:
        if isinstance(self.transfer, BlockDownload) and not self.transfer.ended:
            return []
        return super().on_abort(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and request.sequence != transfer.due:
            return []
        return super().on_block_segment(request)
