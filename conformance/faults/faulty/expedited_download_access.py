"""Servers that are wrong about which entries there are to write, and which may be written."""

from dataclasses import replace

from conformance.faults.registry import Defect, fault
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import DownloadInitiate, Response, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal

FIRST_OF_DEVICE = 0x2000


class ReadOnlyWritten(Server):
    """Writes read-only objects on one kind of transfer."""

    expedited = False

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        if request.expedited is self.expedited:
            return self.objects.find(request.mux)
        return super().entry_to_write(request)


@fault("read-only-written-expedited", Defect.ACCESS_OR_SIZE, "download.read-only")
class ReadOnlyWrittenExpedited(ReadOnlyWritten):
    """Accepts expedited downloads to read-only objects."""

    expedited = True


class _LookupForWrite(Server):
    """Changes why a download is refused."""

    codes: dict[AbortCode, AbortCode] = {}

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        try:
            return super().entry_to_write(request)
        except Refusal as refusal:
            raise Refusal(self.codes.get(refusal.code, refusal.code)) from refusal


@fault("download-read-only-code-wrong", Defect.ACCESS_OR_SIZE, "download.read-only")
class ReadOnlyCodeWrong(_LookupForWrite):
    """Says write-only where it means read-only."""

    codes = {AbortCode.WRITE_OF_READ_ONLY: AbortCode.READ_OF_WRITE_ONLY}


@fault(
    "download-missing-object-code-wrong",
    Defect.ACCESS_OR_SIZE,
    "download.object-missing",
    "segmented-download.object-missing",
)
class MissingForWriteCodeWrong(_LookupForWrite):
    """Says read-only where a download meets no object."""

    codes = {AbortCode.OBJECT_MISSING: AbortCode.WRITE_OF_READ_ONLY}


@fault(
    "download-missing-sub-index-code-wrong",
    Defect.ACCESS_OR_SIZE,
    "download.sub-index-missing",
    "segmented-download.sub-index-missing",
)
class MissingSubForWriteCodeWrong(_LookupForWrite):
    """Says that the object is missing where a download meets no sub-index."""

    codes = {AbortCode.SUB_INDEX_MISSING: AbortCode.OBJECT_MISSING}


@fault(
    "write-only-refused",
    Defect.ACCESS_OR_SIZE,
    "download.write-only",
    "segmented-download.write-only",
)
class WriteOnlyRefused(Server):
    """Refuses downloads to what cannot be read."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        entry = super().entry_to_write(request)
        if not entry.access.readable:
            raise Refusal(AbortCode.WRITE_OF_READ_ONLY)
        return entry


class _AnySubIndex(Server):
    """Takes any sub-index of a simple object for its sub-index 0, in downloads."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        """Look for sub-index 0 where there is no other."""
        index = request.mux.index
        simple = self.objects.get(Multiplexer(index, 1)) is None
        known = self.objects.get(Multiplexer(index)) is not None
        if index >= FIRST_OF_DEVICE and simple and known:
            request = replace(request, mux=Multiplexer(index))
        return super().entry_to_write(request)


@fault("variable-written-by-any-sub-index", Defect.ACCESS_OR_SIZE, "download.sub-index-of-variable")
class VariableWritten(_AnySubIndex):
    """Refuses to read a sub-index of a variable of its own, and takes a download to it."""


@fault("variable-served-by-any-sub-index", Defect.ACCESS_OR_SIZE, "download.sub-index-of-variable")
class VariableServed(_AnySubIndex):
    """Serves any sub-index of a variable of its own as the variable, reads and downloads alike."""

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        mux = Multiplexer(request.mux.index)
        missing = self.objects.get(request.mux) is None
        entry = self.objects.get(mux)
        if request.mux.index < FIRST_OF_DEVICE or not missing or entry is None:
            return super().on_upload_initiate(request)
        self.transfer = None
        return [self.start_upload(request.mux, self.value_to_read(entry))]
