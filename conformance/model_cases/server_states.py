"""The states of a server: what each is called, how it is reached, and what goes on there.

A state says what the server waits for (CiA 301, 7.2.4.3). A transfer in segments waits for the
``first`` one, for one in the ``middle``, or for the ``last``. A block download waits for the
``first`` segment of all, for one ``inside`` a sub-block, for one ``between`` two sub-blocks, or for
the ``end``. A block upload that is ``initiated`` waits for its start, ``between`` two sub-blocks
and with all of them ``sent`` for an acknowledgement, at the ``end`` for its confirmation.

All cases that are about a state take it from here: those that send each frame in each state, those
of a client that falls silent, and those of one service. Their ids have its name.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Generic

from conformance.device.device import TWO_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.model_cases.matrix.stimuli import (
    NEXT_SUB_BLOCK_STIMULI,
    STIMULI,
    SUB_BLOCK_STIMULI,
    Stimulus,
)
from conformance.model_cases.ways_to_states import (
    Due_co,
    Way,
    block_download,
    block_download_between,
    block_upload,
    idle,
    segmented_download,
    segmented_upload,
)
from conformance.run.risks import LOST_SEGMENT, Risk
from conformance.sdo.frames import Request

# Three segments, the last one with 6 bytes of data.
SIZE = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class State(Generic[Due_co]):
    """What a server waits for, and the shortest way there.

    ``sentence`` is about the server. ``least`` are the fewest bytes with which there is such a
    state. Where ``segment`` is a number, a segment of a sub-block with that number is due: whatever
    comes then is one, and only an abort leads out. Into a ``short`` one a transfer of two segments
    leads as well as a longer one. ``risk`` is what a server may not survive on the way with a
    transfer of ``SIZE``.
    """

    name: str
    sentence: str
    way: Way[Due_co]
    downloads: bool = False
    least: int = 1
    segment: int | None = None
    short: bool = False
    stimuli: Mapping[str, Stimulus] = field(default_factory=lambda: STIMULI)
    risk: Risk | None = None

    def reach(self, sdo: Dialogue, known: KnownObject, size: int) -> Due_co:
        """Lead an idle server there, and stay; return what the client would send next."""
        return next(self.way(sdo, known, size))

    @property
    def uploads(self) -> bool:
        """Whether an upload leads into it, so that the object has to hold what is read."""
        return not self.downloads and self is not IDLE


IDLE: State[None] = State(name="idle", sentence="No transfer runs.", way=idle)

SEGMENTED_DOWNLOAD_FIRST = State(
    name="segmented-download-first",
    sentence="A download was initiated: its first segment is due.",
    way=segmented_download(0),
    downloads=True,
)
SEGMENTED_DOWNLOAD_MIDDLE = State(
    name="segmented-download-middle",
    sentence="A segment of a download was confirmed: another one is due.",
    way=segmented_download(1),
    downloads=True,
    least=TWO_SEGMENTS,
)
SEGMENTED_DOWNLOAD_LAST = State(
    name="segmented-download-last",
    sentence="All segments of a download but one were confirmed: the last is due.",
    way=segmented_download(-1),
    downloads=True,
    short=True,
    least=TWO_SEGMENTS,
)

SEGMENTED_UPLOAD_FIRST = State(
    name="segmented-upload-first",
    sentence="An upload was initiated: its first segment is to be asked for.",
    way=segmented_upload(0),
    least=TWO_SEGMENTS,
)
SEGMENTED_UPLOAD_MIDDLE = State(
    name="segmented-upload-middle",
    sentence="A segment of an upload was sent: another one is to be asked for.",
    way=segmented_upload(1),
    least=TWO_SEGMENTS,
)
SEGMENTED_UPLOAD_LAST = State(
    name="segmented-upload-last",
    sentence="All segments of an upload but one were sent: the last is to be asked for.",
    way=segmented_upload(-1),
    short=True,
    least=TWO_SEGMENTS,
)

BLOCK_DOWNLOAD_FIRST = State(
    name="block-download-first",
    sentence="A block download was initiated: the first segment of its first sub-block is due.",
    way=block_download(0),
    downloads=True,
    segment=1,
    stimuli=SUB_BLOCK_STIMULI,
)
BLOCK_DOWNLOAD_INSIDE = State(
    name="block-download-inside",
    sentence="Segments of a sub-block of a download were sent: the next one is due.",
    way=block_download(1),
    downloads=True,
    least=TWO_SEGMENTS,
    segment=2,
    stimuli=SUB_BLOCK_STIMULI,
)
BLOCK_DOWNLOAD_BETWEEN = State(
    name="block-download-between",
    sentence="A sub-block of a download was acknowledged: the first segment of the next is due.",
    way=block_download_between,
    downloads=True,
    least=TWO_SEGMENTS,
    segment=1,
    stimuli=NEXT_SUB_BLOCK_STIMULI,
    risk=LOST_SEGMENT,
)
BLOCK_DOWNLOAD_END = State(
    name="block-download-end",
    sentence="All sub-blocks of a download were acknowledged: its end is due.",
    way=block_download(-1),
    downloads=True,
    short=True,
)

BLOCK_UPLOAD_INITIATED = State(
    name="block-upload-initiated",
    sentence="A block upload was initiated: its start is due.",
    way=block_upload(0),
)
BLOCK_UPLOAD_BETWEEN = State(
    name="block-upload-between",
    sentence="A sub-block of an upload was sent, not the last: its acknowledgement is due.",
    way=block_upload(1),
    least=TWO_SEGMENTS,
)
BLOCK_UPLOAD_SENT = State(
    name="block-upload-sent",
    sentence="The last sub-block of an upload was sent: its acknowledgement is due.",
    way=block_upload(-2),
    least=TWO_SEGMENTS,
)
BLOCK_UPLOAD_END = State(
    name="block-upload-end",
    sentence="The end of a block upload was sent: its confirmation is due.",
    way=block_upload(-1),
    least=TWO_SEGMENTS,
)


def by_name(*states: State[Due_co]) -> dict[str, State[Due_co]]:
    """Return states for the cases that are about each of them: the ids have their names."""
    return {state.name: state for state in states}


SEGMENTED_DOWNLOADS = by_name(
    SEGMENTED_DOWNLOAD_FIRST, SEGMENTED_DOWNLOAD_MIDDLE, SEGMENTED_DOWNLOAD_LAST
)
SEGMENTED_UPLOADS = by_name(SEGMENTED_UPLOAD_FIRST, SEGMENTED_UPLOAD_MIDDLE, SEGMENTED_UPLOAD_LAST)
BLOCK_DOWNLOADS: dict[str, State[Request]] = by_name(
    BLOCK_DOWNLOAD_FIRST, BLOCK_DOWNLOAD_INSIDE, BLOCK_DOWNLOAD_BETWEEN, BLOCK_DOWNLOAD_END
)
BLOCK_UPLOADS: dict[str, State[Request]] = by_name(
    BLOCK_UPLOAD_INITIATED, BLOCK_UPLOAD_BETWEEN, BLOCK_UPLOAD_SENT, BLOCK_UPLOAD_END
)
STATES: dict[str, State[Request | None]] = {
    IDLE.name: IDLE,
    **SEGMENTED_DOWNLOADS,
    **SEGMENTED_UPLOADS,
    **BLOCK_DOWNLOADS,
    **BLOCK_UPLOADS,
}
"""All that there are."""
SILENT: dict[str, State[Request]] = by_name(
    SEGMENTED_DOWNLOAD_FIRST,
    SEGMENTED_DOWNLOAD_MIDDLE,
    SEGMENTED_UPLOAD_FIRST,
    SEGMENTED_UPLOAD_MIDDLE,
    *BLOCK_DOWNLOADS.values(),
    BLOCK_UPLOAD_INITIATED,
    BLOCK_UPLOAD_BETWEEN,
    BLOCK_UPLOAD_END,
)
"""Where cases let the client fall silent: before the last segment it is as in the middle."""
