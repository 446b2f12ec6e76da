"""Servers that abort a segmented download, or are told to, and go on with it all the same."""

from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import Download
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
)
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.objects import Refusal


class _LivesOn(Server):
    """Aborts a download, and goes on with it all the same."""

    code: AbortCode
    on_segments = True

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        running = self.transfer
        responses = super().refuse(request, code)
        concerns = isinstance(request, DownloadSegment) is self.on_segments
        if isinstance(running, Download) and concerns and code == self.code:
            self.transfer = running
        return responses


@fault("toggle-refused-and-download-lives-on", Defect.STATE, "segmented-download.toggle")
class ToggleLivesOn(_LivesOn):
    """Goes on with a download that it has aborted for a toggle bit that did not alternate."""

    code = AbortCode.TOGGLE_NOT_ALTERNATED


@fault(
    "too-many-refused-and-download-lives-on",
    Defect.STATE,
    "segmented-download.too-many",
)
class TooManyLivesOn(_LivesOn):
    """Goes on with a download that it has aborted because more came than was announced."""

    code = AbortCode.LENGTH_TOO_HIGH


@fault("too-few-refused-and-download-lives-on", Defect.STATE, "segmented-download.too-few")
class TooFewLivesOn(_LivesOn):
    """Goes on with a download that it has aborted because less came than was announced."""

    code = AbortCode.LENGTH_TOO_LOW


@fault("too-few-not-counted-and-download-lives-on", Defect.STATE, "segmented-download.too-few")
class TooFewNotCounted(TooFewLivesOn):
    """Forgets a last segment that came too early, aborts the download, and goes on with it."""

    def finish_download(self, transfer: Download) -> None:
        before = len(transfer.data) - (len(transfer.data) - 1) % SEGMENT_LENGTH - 1
        try:
            super().finish_download(transfer)
        except Refusal:
            del transfer.data[before:]
            raise


@fault(
    "foreign-request-refused-and-download-lives-on",
    Defect.STATE,
    "segmented-download.foreign[",
    "segmented-download.foreign-later[",
)
class ForeignLivesOn(_LivesOn):
    """Goes on with a download that it has aborted for a request that has no place in it."""

    code = AbortCode.COMMAND_NOT_VALID
    on_segments = False


@fault(
    "abort-ignored-before-first-segment",
    Defect.ABORT,
    "segmented-download.client-abort-then-segment[segmented-download-first]",
)
class IgnoredBeforeFirst(Server):
    """Goes on with a download that the client has aborted before its first segment."""

    def on_abort(self, request: Abort) -> list[Response]:
        waits = isinstance(self.transfer, Download) and not self.transfer.data
        return [] if waits else super().on_abort(request)


@fault(
    "read-only-refused-and-begun",
    Defect.STATE,
    "segmented-download.read-only",
    "od.read-only-in-segments",
)
class ReadOnlyBegun(Server):
    """Aborts a segmented download to a read-only object, and takes its segments all the same."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        entry = self.objects.get(request.mux)
        if request.expedited or entry is None or entry.access.writable:
            return super().on_download_initiate(request)
        self.transfer = self.start_download(request, entry)
        return [Abort(request.mux, AbortCode.WRITE_OF_READ_ONLY)]
