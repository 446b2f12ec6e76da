"""Servers that are right in downloads in their own way: when they check, and when they write."""

from dataclasses import replace

from conformance.faults.own_clock import AnswersLater
from conformance.faults.registry import About, unusual
from conformance.reference.node import Node
from conformance.reference.segmented_server import Download
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import BlockSegment, DownloadInitiate, DownloadSegment, Response
from conformance.sdo.objects import DataType, Entry, Refusal

_REFUSES = AbortCode.TOGGLE_NOT_ALTERNATED.to_bytes(4, "little")


@unusual("download-toggle-error-ignored")
class ToggleErrorIgnored(Server):
    """Ignores a download segment whose toggle bit did not alternate, and goes on."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if isinstance(self.transfer, Download) and request.toggle != self.transfer.toggle:
            return []
        return super().on_download_segment(request)


@unusual("sizes-checked-at-the-end")
class SizesCheckedLate(Server):
    """Takes any announced size and looks at it with the last segment only."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Look later."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if len(request.data) > transfer.room and request.last and request.unused == 0:
            return super().segment_data(transfer, request)
        return request.data

    def finish_download(self, transfer: Download) -> None:
        if transfer.size is not None and len(transfer.data) > transfer.size:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        super().finish_download(transfer)


@unusual("access-checked-at-the-end")
class AccessCheckedLate(Server):
    """Confirms a segmented download and refuses a read-only object with the last segment."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        if request.expedited:
            return super().entry_to_write(request)
        return self.objects.find(request.mux)

    def finish_download(self, transfer: Download) -> None:
        self.objects.writable(transfer.mux)
        super().finish_download(transfer)


@unusual("no-empty-values")
class NoEmptyValues(Server):
    """Refuses to store a value without data."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if size == 0:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        super().check_announced_size(entry, size)


@unusual("22h-refused-for-short-numbers")
class UncountedShortRefused(Server):
    """Refuses an expedited download without a count to fewer than 4 bytes."""

    def expedited_data(self, request: DownloadInitiate, entry: Entry) -> bytes:
        if not request.sized and entry.longest < 4:
            raise Refusal(AbortCode.LENGTH_MISMATCH)
        return super().expedited_data(request, entry)


@unusual("n-of-last-segment-binding")
class UnusedBinding(Server):
    """Takes n = 0 in a last segment for 7 bytes, and refuses them as too many."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if len(request.data) > transfer.room:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        return request.data


@unusual("n-7-in-last-segment-refused", soft=True)
class EmptyLastRefused(Server):
    """Takes n = 0 to 6 in a last segment, and calls n = 7 no valid command."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        if request.last and not request.data:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().segment_data(transfer, request)


@unusual("n-of-last-segment-only", soft=True)
class UnusedOfLastOnly(Server):
    """Takes 7 bytes of each segment before the last, whatever n says."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        whole = request if request.last else replace(request, unused=0)
        return super().segment_data(transfer, whole)


class _WritesThrough(Server):
    """Writes each segment at once."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        data = super().segment_data(transfer, request)
        self.write(transfer.entry, bytes(transfer.data) + data)
        return data

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        super().take_block_segment(transfer, request)
        self.write(transfer.entry, bytes(transfer.data))

    def write(self, entry: Entry, data: bytes) -> None:
        """Write a string or domain."""
        if entry.data_type.length is None:
            entry.value = self.written(entry, data)

    def written(self, entry: Entry, data: bytes) -> bytes:
        """Return what an object holds then."""
        del entry
        return data


@unusual("domain-keeps-part-of-aborted-write", soft=True)
class DomainKeepsPart(_WritesThrough):
    """Has stored in a domain what came of a download when it is aborted."""

    def written(self, entry: Entry, data: bytes) -> bytes:
        return data if entry.data_type is DataType.DOMAIN else entry.value


@unusual("string-keeps-part-of-aborted-write", soft=True)
class StringKeepsPart(_WritesThrough):
    """Has stored in a string or domain what came of a download when it is aborted."""


@unusual("string-overwritten-in-place", soft=True)
class OverwrittenInPlace(_WritesThrough):
    """Overwrites a string or domain byte by byte: a shorter download leaves the old rest."""

    def written(self, entry: Entry, data: bytes) -> bytes:
        return data + entry.value[len(data) :]


@unusual("refused-segment-answered-unless-another-follows", about=About.TIME)
class KeepsLatestAnswer(AnswersLater):
    """Has one place for an answer: that to a wrong segment is lost where a request is at its heels.

    A client has to wait for each answer (CiA 301, 7.2.4.2), so that none of its requests is.
    """

    delay = 0.001

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Answer at once, but for the refusal of a segment."""
        self.held.clear()
        held = Node.receive(self, frame)
        if [answer for answer in held if _REFUSES in answer.data]:
            self.hold(held)
            return []
        return held
