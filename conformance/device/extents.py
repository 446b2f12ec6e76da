"""How many bytes an object can hold at the most: an upload that brings more has no end.

What the type says, what the object read when the run began, and what was written to it since. Of an
object that the device itself changes, or that was not read yet, that is not known: there a text is
taken for no book, and anything else may have a mebibyte; less once the device was seen to bring
data without an end.
"""

from conformance.device.known_objects import KnownObject
from conformance.sdo.client import MOST_UPLOADED
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
    Request,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.objects import TEXT_TYPES

# A device may have one length for its strings, and fill up with 00h what is shorter; one that was
# seen to bring data without an end is given less.
PADDING, LITTLE = 1024, 64
# After this number of uploads without an end it is what the device does.
ENOUGH = 3
# What a text is allowed that was not read yet, where the EDS states a value and where it does not.
STATED, TEXT = 1 << 14, 1 << 17
# What is allowed where nothing is known, behind none, one to three, and more uploads without end.
ALLOWED = ((0, MOST_UPLOADED), (ENOUGH, 1 << 14), (1 << 32, 1 << 10))


class Extents:
    """What has been sent to the objects of a device, by object, and how it has served uploads.

    ``endless`` counts uploads that had no end.
    """

    def __init__(self) -> None:
        """Nothing was sent yet."""
        self.endless = 0
        self._most: dict[Multiplexer, int] = {}
        self._latest: dict[Multiplexer, int] = {}
        self._open: Multiplexer | None = None
        self._bytes = 0

    def request(self, request: Request) -> None:
        """Take a request that goes out: whatever a device takes of it, it is not more."""
        match request:
            case DownloadInitiate() | BlockDownloadInitiate():
                self._open, self._bytes = request.mux, 0
            case DownloadSegment() | BlockSegment():
                self._bytes += SEGMENT_LENGTH
            case _:
                return
        if self._open is not None:
            self._latest[self._open] = self._bytes
            self._most[self._open] = max(self._most.get(self._open, 0), self._bytes)

    def longest(self, known: KnownObject | None, value: bytes | None) -> int:
        """Return the most bytes that an upload may bring of an object with a ``value`` at first.

        An object of one length may bring a segment more before it is stopped: that its value is too
        long is then for others to say.
        """
        if known is not None and known.length is not None:
            return known.length + SEGMENT_LENGTH
        allowed = next(most for endless, most in ALLOWED if self.endless <= endless)
        if known is None:
            return allowed
        stated, kept = known.stated or b"", value or b""
        if value is not None and known.is_steady and self.endless > ENOUGH:
            return max(self._latest.get(known.mux, len(value)), known.habits.filled) + LITTLE
        least = max(len(kept), len(stated), known.habits.filled, self._most.get(known.mux, 0))
        if value is not None and known.is_steady:
            return least + PADDING
        if known.data_type in TEXT_TYPES:
            allowed = min(allowed, STATED if stated else TEXT)
        return least + allowed
