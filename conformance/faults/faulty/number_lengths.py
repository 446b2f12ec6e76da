"""Servers that hold numbers of 5, 6 or 7 bytes as if they had 8."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.objects import Entry, Refusal

fault = partial(registry.fault, about=About.LENGTHS)
ODD_LENGTHS = range(5, 8)
WHOLE = 8


@fault("numbers-of-5-to-7-bytes-read-as-8", Defect.FIELD_WIDTH, "upload.length[5]")
class ReadAsWhole(Server):
    """Reads numbers of 5 to 7 bytes with 8."""

    def value_to_read(self, entry: Entry) -> bytes:
        odd = entry.data_type.length in ODD_LENGTHS
        return entry.value.ljust(WHOLE, b"\0") if odd else entry.value


@fault(
    "numbers-of-5-to-7-bytes-take-8",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.number-too-long[7]",
    "block-download.number-too-long[7]",
)
class TakesWhole(Server):
    """Takes 8 bytes for a number of 5 to 7, and cuts them."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if not self.is_cut(entry, size):
            super().check_announced_size(entry, size)

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data[: entry.longest] if self.is_cut(entry, len(data)) else data)

    def is_cut(self, entry: Entry, size: int | None) -> bool:
        """Say whether it takes more bytes than the type has."""
        return entry.data_type.length in ODD_LENGTHS and size == WHOLE


@fault(
    "numbers-of-5-to-7-bytes-refused",
    Defect.ACCESS_OR_SIZE,
    "segmented-download.number[5]",
    "block-download.number[6]",
)
class RefusesOdd(Server):
    """Refuses any size but 8 for a number of 5 to 7 bytes."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if entry.data_type.length in ODD_LENGTHS and size not in (None, WHOLE):
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        super().check_announced_size(entry, size)
