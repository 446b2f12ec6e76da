"""Servers that refuse a value of a wrong length, and write a part of it all the same."""

from conformance.faults.registry import Defect, fault
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.objects import Entry, Refusal


class _WritesWrongLength(Server):
    """Refuses a value of a wrong length for a number behind a part of it was written."""

    code: AbortCode

    def check(self, entry: Entry, data: bytes) -> None:
        """Refuse a value, but not before it is written."""
        try:
            entry.check_length(len(data))
        except Refusal as refusal:
            number = entry.data_type.length is not None
            if number and data and refusal.code == self.code:
                self.write(entry, data)
            raise

    def write(self, entry: Entry, data: bytes) -> None:
        """Write what there is room for."""
        kept = data[: len(entry.value)]
        entry.value = kept + entry.value[len(kept) :]

    def store(self, entry: Entry, data: bytes) -> None:
        self.check(entry, data)
        super().store(entry, data)

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Look at it when the data are there."""


@fault("too-long-refused-and-written", Defect.ACCESS_OR_SIZE, "download.too-long")
class TooLongWritten(_WritesWrongLength):
    """Refuses too long a value for a number, and writes what there is room for."""

    code = AbortCode.LENGTH_TOO_HIGH


@fault(
    "too-short-refused-and-written",
    Defect.ACCESS_OR_SIZE,
    "download.too-short",
    "segmented-download.number-too-short",
)
class TooShortWritten(_WritesWrongLength):
    """Refuses too short a value for a number, and writes its bytes."""

    code = AbortCode.LENGTH_TOO_LOW


@fault(
    "too-long-refused-and-neighbour-written", Defect.ACCESS_OR_SIZE, "download.too-long[4-into-1]"
)
class NeighbourWritten(_WritesWrongLength):
    """Refuses too long a value for a number, and writes the rest of it into the next number."""

    code = AbortCode.LENGTH_TOO_HIGH

    def write(self, entry: Entry, data: bytes) -> None:
        ordered = sorted(self.objects.items(), key=lambda item: item[0])
        at = next(place for place, (_, one) in enumerate(ordered) if one is entry)
        for _, one in ordered[at + 1 :]:
            if one.access.writable and one.data_type.length is not None:
                rest = data[len(entry.value) :][: len(one.value)]
                one.value = rest + one.value[len(rest) :]
                return
