"""Servers that are wrong about aborts and foreign requests in a block download."""

from dataclasses import replace

from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    BlockEndResponse,
    BlockSegment,
    Request,
    Response,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.server import BlockDownload, Server

ABORT = DefectClass.ABORT
STATE = DefectClass.STATE
INSIDE = "block-download.too-many-inside"


class _DuringDownload(Server):
    """Minds a request of another service in a block download no more than it says."""

    def on_unexpected(self, request: Request) -> list[Response]:
        """Ask ``on_foreign`` within a block download."""
        if isinstance(self.transfer, BlockDownload):
            return self.on_foreign()
        return super().on_unexpected(request)

    def on_foreign(self) -> list[Response]:
        """Return what is sent."""
        return []


@fault("block-download-foreign-ignored", STATE, "block-download.foreign-at-end")
class ForeignIgnored(_DuringDownload):
    """Ignores a request of another service where the end of a block download is due."""


@fault("block-download-foreign-taken-for-end", STATE, "block-download.foreign-at-end")
class ForeignAsEnd(_DuringDownload):
    """Confirms a block download on any request where its end is due."""

    def on_foreign(self) -> list[Response]:
        """Confirm."""
        self.transfer = None
        return [BlockEndResponse()]


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
        """Return what is sent."""
        del transfer, request
        return []


@fault("block-download-abort-echoed", ABORT, "block-download.client-abort")
class AbortEchoed(_OnAbort):
    """Sends the abort of a block download back."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        """Echo it."""
        return [request]


@fault("block-download-abort-taken-for-segment", ABORT, "block-download.client-abort")
class AbortAsSegment(_OnAbort):
    """Takes an abort between the segments for a segment with number 0, and refuses it."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        """Look at the number."""
        if transfer.ended:
            return []
        return [Abort(transfer.mux, AbortCode.INVALID_SEQUENCE_NUMBER)]


@fault("block-download-abort-ignored-at-end", ABORT, "block-download.client-abort-then-end")
class AbortIgnoredAtEnd(_OnAbort):
    """Goes on with a block download that is aborted where its end is due."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        """Keep the transfer."""
        self.transfer = transfer if transfer.ended else None
        return []


@fault("block-download-abort-ignored", ABORT, "block-download.client-abort")
class AbortIgnored(_OnAbort):
    """Goes on with a block download that is aborted once between its segments."""

    ignored: BlockDownload | None = None

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        """Mind the second one."""
        if transfer.data and not transfer.ended and self.ignored is not transfer:
            self.ignored = self.transfer = transfer
        return []


@fault("block-download-abort-commits", ABORT, "block-download.number-kept")
class AbortCommits(_OnAbort):
    """Stores what has come of a block download that the client aborts."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        """Commit."""
        if transfer.data:
            transfer.entry.value = bytes(transfer.data)[: transfer.entry.longest]
        return []


@fault("block-download-abort-acknowledged", ABORT, "block-download.client-abort")
class AbortAcknowledged(_OnAbort):
    """Acknowledges what has come of a block download that the client aborts."""

    def on_download_abort(self, transfer: BlockDownload, request: Abort) -> list[Response]:
        """Send A2h once more."""
        return [self.acknowledge(transfer)]


class _LongSubBlock(Server):
    """Aborts otherwise when too much has come inside a sub-block of which many segments came."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Abort otherwise."""
        transfer = self.transfer
        many = isinstance(transfer, BlockDownload) and transfer.due > 1
        responses = super().refuse(request, code)
        if not many or not isinstance(request, BlockSegment):
            return responses
        return [self.spoilt(found) for found in responses if isinstance(found, Abort)]

    def spoilt(self, abort: Abort) -> Abort:
        """Return the abort as it is sent."""
        return abort


@fault("block-download-abort-inside-code-private", ABORT, INSIDE)
class InsidePrivate(_LongSubBlock):
    """Aborts with a code of its own inside a sub-block."""

    def spoilt(self, abort: Abort) -> Abort:
        """Replace the code."""
        return replace(abort, code=0x0607_0099)


@fault("block-download-abort-inside-multiplexer-foreign", ABORT, INSIDE)
class InsideForeign(_LongSubBlock):
    """Names another object in an abort inside a sub-block."""

    def spoilt(self, abort: Abort) -> Abort:
        """Replace the object."""
        return replace(abort, mux=Multiplexer(0x1018, 1))


@fault("block-download-deaf-when-aborted", ABORT, "block-download.client-abort")
class DeafWhenAborted(Server):
    """Knows nothing but the segment that is due within a sub-block, not even an abort."""

    def on_abort(self, request: Abort) -> list[Response]:
        """Wait for the segment."""
        if isinstance(self.transfer, BlockDownload) and not self.transfer.ended:
            return []
        return super().on_abort(request)

    def on_block_segment(self, request: BlockSegment) -> list[Response]:
        """Wait for the number that is due."""
        transfer = self.transfer
        if isinstance(transfer, BlockDownload) and request.sequence != transfer.due:
            return []
        return super().on_block_segment(request)
