"""Servers that write a string or domain through before its download ends, as no clause forbids."""

from conformance.faults.registry import variant
from conformance.sdo.frames import BlockSegment, DownloadSegment
from conformance.sdo.objects import DataType, Entry
from conformance.sdo.segmented_server import Download
from conformance.sdo.server import BlockDownload, Server


class _WritesThrough(Server):
    """Writes each segment at once."""

    def segment_data(self, transfer: Download, request: DownloadSegment) -> bytes:
        """Write what counts of it."""
        data = super().segment_data(transfer, request)
        self.write(transfer.entry, bytes(transfer.data) + data)
        return data

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Write all of it."""
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


@variant("domain-keeps-part-of-aborted-write", soft=True)
class DomainKeepsPart(_WritesThrough):
    """Has stored in a domain what came of a download when it is aborted."""

    def written(self, entry: Entry, data: bytes) -> bytes:
        """Leave strings alone."""
        return data if entry.data_type is DataType.DOMAIN else entry.value


@variant("string-keeps-part-of-aborted-write", soft=True)
class StringKeepsPart(_WritesThrough):
    """Has stored in a string or domain what came of a download when it is aborted."""


@variant("string-overwritten-in-place", soft=True)
class OverwrittenInPlace(_WritesThrough):
    """Overwrites a string or domain byte by byte: a shorter download leaves the old rest."""

    def written(self, entry: Entry, data: bytes) -> bytes:
        """Keep the length until the end."""
        return data + entry.value[len(data) :]
