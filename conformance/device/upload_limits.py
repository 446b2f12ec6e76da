"""How many bytes an object can hold at the most: an upload that brings more has no end.

What the type says, what the object read when the run began, and what was written to it since. Of an
object that the device itself changes, or that was not read yet, that is not known: there a text is
taken for no book, and anything else may have a mebibyte; less once the device was seen to bring
data without an end.
"""

from collections import defaultdict
from dataclasses import dataclass

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


@dataclass(slots=True)
class _Sent:
    """How many bytes the latest download to an object has brought at the most, and any of them.

    ``is_empty`` as long as the latest has brought none.
    """

    latest: int = 0
    most: int = 0
    is_empty: bool = False


class Extents:
    """What has been sent to the objects of a device, by object, and how it has served uploads.

    ``endless`` counts uploads that had no end.
    """

    def __init__(self) -> None:
        """Nothing was sent yet."""
        self.endless = 0
        self._sent: defaultdict[Multiplexer, _Sent] = defaultdict(_Sent)
        # To the object of the latest download: that of none as long as there was no download.
        self._open = _Sent()

    def request(self, request: Request) -> None:
        """Take a request that goes out: whatever a device takes of it, it is not more."""
        match request:
            case BlockSegment() | DownloadSegment():
                no_data = isinstance(request, DownloadSegment) and not request.data
                self._open.is_empty = self._open.is_empty and no_data
                latest = self._open.latest = self._open.latest + SEGMENT_LENGTH
                if latest > self._open.most:
                    self._open.most = latest
            case DownloadInitiate() | BlockDownloadInitiate():
                self._open = self._sent[request.mux]
                self._open.latest = 0
                self._open.is_empty = not (
                    isinstance(request, DownloadInitiate) and request.expedited
                )

    def latest(self, mux: Multiplexer) -> int:
        """Return how many bytes the latest download to an object has brought at the most."""
        return self._sent[mux].latest if mux in self._sent else 0

    def may_be_empty(self, mux: Multiplexer) -> bool:
        """Say whether the latest download to an object has brought no byte."""
        return mux in self._sent and self._sent[mux].is_empty

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
        sent = self._sent.get(known.mux)
        is_cut = known.is_steady and not known.habits.keeps_tails
        if value is not None and is_cut and self.endless > ENOUGH:
            latest = len(value) if sent is None else sent.latest
            return max(latest, known.habits.filled) + LITTLE
        most = 0 if sent is None else sent.most
        least = max(len(kept), len(stated), known.habits.filled, most)
        if value is not None and known.is_steady:
            return least + PADDING
        if known.data_type in TEXT_TYPES:
            allowed = min(allowed, STATED if stated else TEXT)
        return least + allowed
