"""Servers that confirm writes and store nothing of them."""

from conformance.faults.registry import Defect, fault
from conformance.reference.server import Server
from conformance.sdo.frames import DownloadInitiate, Response
from conformance.sdo.objects import Entry


@fault("numbers-confirmed-and-not-stored", Defect.ACCESS_OR_SIZE, "download.stored")
class NumbersNotStored(Server):
    """Confirms each download to a number and stores nothing."""

    def store(self, entry: Entry, data: bytes) -> None:
        before = entry.value
        super().store(entry, data)
        if entry.data_type.length is not None:
            entry.value = before


@fault("expedited-confirmed-and-not-stored", Defect.ACCESS_OR_SIZE, "download.stored")
class ExpeditedNotStored(Server):
    """Confirms each expedited download and stores nothing."""

    is_expedited = False

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        self.is_expedited = request.expedited
        return super().on_download_initiate(request)

    def store(self, entry: Entry, data: bytes) -> None:
        before = entry.value
        super().store(entry, data)
        if self.is_expedited:
            entry.value = before
