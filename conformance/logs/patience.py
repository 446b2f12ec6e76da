"""How long a request may go unanswered in a log before the answer is missing.

CiA 301 sets no time. An answer that comes later is right whenever it comes, also behind an abort of
the client: this is about those that never come, where the client has given up before.
"""

from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import INITIATES, UploadInitiate
from conformance.sdo.storage_commands import COMMANDS

# In seconds. The wait of a run, less what clocks differ; memories that are written take longer.
READ = 0.99
WRITE = 3.0
STORE = 10.0
SEGMENT = 0.02
# Parameters that are stored, and programs (CiA 302-3): these areas are erased first.
STORING = (*COMMANDS, *range(0x1F50, 0x1F58))


class Patience:
    """Follows the requests of one channel; each may say how long its answer can take."""

    __slots__ = ("_agreed", "_least", "_segments")

    def __init__(self, agreed: float | None = None) -> None:
        """Begin with nothing known of the transfer: it may be a download.

        An ``agreed`` time in seconds holds for all answers.
        """
        self._agreed = agreed
        self._least = WRITE
        self._segments = 0

    @property
    def seconds(self) -> float:
        """How long the latest request may go unanswered."""
        if self._agreed is not None:
            return self._agreed
        return self._least + self._segments * SEGMENT

    def asked(self, frame: bytes, *, in_sub_block: bool) -> None:
        """Take a request; within a sub-block it is a segment."""
        if in_sub_block:
            self._segments += 1
            return
        request = decode_request(frame)
        if isinstance(request, INITIATES):
            reads = isinstance(request, UploadInitiate)
            stores = request.mux.index in STORING
            self._least = READ if reads else STORE if stores else WRITE

    def answered(self) -> None:
        """Take a response."""
        self._segments = 0
