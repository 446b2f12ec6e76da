"""What a device was seen to do since the run began: found out once, and known from then on."""

from collections import defaultdict
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Literal

from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Missing, NotTestable
from conformance.device.serving import Serving
from conformance.sdo.block_client import BlockClient, Step
from conformance.sdo.frames import Abort, Response
from conformance.sdo.layout import Multiplexer

# How a value is written.
Way = Callable[[BlockClient, Multiplexer, bytes], Generator[Step, Response, object]]


@dataclass(slots=True)
class Lengths:
    """The lengths, in bytes, that a string or domain takes, as far as writing to it has shown.

    ``taken`` are some that it has taken. ``most`` is the largest, None until it was measured; a
    ``fixed`` one is the only one. ``refusal`` is how the device refuses others, in words. A value
    is ``irreplaceable`` that is refused as too long though it reads so: nothing is written there.
    Shorter values than ``filled`` bytes are filled up to as many. Behind shorter ones than
    ``lasting`` bytes the end of a longer one stays: what is longer would last. Between lengths that
    are taken there may be ``refused`` ones. ``whole`` are some that were written in segments, and
    read whole. It was ``asked`` for room once. ``much`` is how many bytes it took when it was asked
    for much room, 0 where it refused them, None until it was asked.
    """

    taken: set[int] = field(default_factory=set)
    most: int | None = None
    fixed: bool = False
    refusal: str = ""
    irreplaceable: bool = False
    filled: int = 0
    lasting: int = 0
    refused: set[int] = field(default_factory=set)
    whole: set[int] = field(default_factory=set)
    asked: bool = False
    much: int | None = None

    @property
    def surely(self) -> int | None:
        """Up to how many bytes any length is taken; None where there may be one length only."""
        return None if self.fixed or len(self.taken) < 2 else max(self.taken)

    @property
    def least(self) -> int:
        """How many bytes it reads at the least, whatever was written, as far as that is known."""
        return max(self.filled, self.lasting, (self.most or 0) if self.fixed else 0)

    def check_lasting(self, known: KnownObject, size: int) -> None:
        """Raise NotTestable where the end of a value of ``size`` bytes would stay for good."""
        if self.lasting and size > self.lasting:
            raise NotTestable(
                f"{known} keeps the end of a longer value behind a shorter one: {size} bytes would "
                f"never be the {self.lasting} again that it reads; name a larger string or domain"
            )

    def fit(self, wanted: int) -> int | None:
        """Return what to write where ``wanted`` bytes would be best; None to try just these."""
        if self.fixed:
            return self.most
        if self.filled and (self.most is None or self.filled <= self.most):
            return self.filled
        if wanted in self.refused and self.taken:
            return max((taken for taken in self.taken if taken < wanted), default=min(self.taken))
        if wanted in self.taken or wanted <= (self.surely or 0):
            return wanted
        return None if self.most is None else min(wanted, self.most)


class Reason(Enum):
    """Why an object was not read."""

    REFUSED = auto()
    BREACH = auto()
    TOO_LONG = auto()
    PASSED_OVER = auto()


@dataclass(frozen=True, slots=True)
class Unread:
    """Why an object has no value that could be put back, so that it is never written.

    It was ``REFUSED``, or came with fewer bytes than its type has; its upload was a ``BREACH``; it
    is ``TOO_LONG`` to be read to its end; or ``PASSED_OVER``, as the device has very many.
    ``missing`` is what the user may add to have it read; ``came`` is the answer in words where that
    is not all of ``why``.
    """

    reason: Reason
    why: str = ""
    missing: Missing | None = None
    came: str = ""


@dataclass(slots=True)
class Learned:
    """What the reading and the cases have found out.

    Of objects: which are ``unread``, what ``lengths`` they take, what the device refuses by its
    state (``serving``). ``nowhere`` names entries that it was seen to lack, as their sub-indices
    00h, and whose multiplexers are text. ``all_entries`` are indices of which it serves
    sub-indices that they cannot have.

    Of services: ``block_download_refusal`` is how it refuses block downloads, False if it serves
    them, None until that was tried; ``block_upload_refusal`` is the same of block uploads.
    ``stores_in_blocks``: a block download was served to its end, and none has lost its data; None
    until then. ``reads_alike``: a block upload has brought the data of an ordinary one; None until
    they were compared. ``loses_segments``: it has acknowledged fewer segments of a sub-block than
    were sent. ``way_to_store`` is how values are written where it refuses the ordinary way.
    ``further_channels`` are the SDO server parameter records behind 1200h, None until they were
    searched.

    Of answers: ``answers_twice``: every read is answered twice, and alike, so that it may be two
    devices with one node-ID. ``is_behind``: it answers each request when the next one comes.
    ``streams``: it sends segments by itself behind what asks for them out of place; ``says_all``
    has such requests, as a line has them, behind which it was seen to send nothing.
    """

    unread: dict[Multiplexer, Unread] = field(default_factory=dict)
    lengths: defaultdict[Multiplexer, Lengths] = field(default_factory=lambda: defaultdict(Lengths))
    serving: Serving = field(default_factory=Serving)
    nowhere: tuple[Multiplexer, ...] = ()
    all_entries: set[int] = field(default_factory=set)
    block_download_refusal: Abort | Literal[False] | None = None
    block_upload_refusal: Abort | Literal[False] | None = None
    stores_in_blocks: bool | None = None
    reads_alike: bool | None = None
    loses_segments: bool = False
    way_to_store: Way | None = None
    further_channels: tuple[int, ...] | None = None
    answers_twice: bool = False
    is_behind: bool = False
    streams: bool = False
    says_all: set[tuple[type, bool]] = field(default_factory=set)

    def is_unread(self, mux: Multiplexer, reason: Reason) -> bool:
        """Say whether an object was not read for this reason."""
        return mux in self.unread and self.unread[mux].reason is reason

    def unread_for(self, reason: Reason) -> set[Multiplexer]:
        """Return the objects that were not read for this reason."""
        return {mux for mux in self.unread if self.is_unread(mux, reason)}

    @property
    def unreadable(self) -> dict[Multiplexer, str]:
        """The objects that could not be read, and why."""
        passed_over = self.unread_for(Reason.PASSED_OVER)
        return {mux: each.why for mux, each in self.unread.items() if mux not in passed_over}
