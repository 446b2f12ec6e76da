"""The kinds of work that a request is for a device: each takes its own time."""

from collections import Counter
from enum import Enum, auto
from typing import NamedTuple

from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
    Request,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.storage_commands import COMMANDS


class Kind(Enum):
    """What a device has to do, as far as it may take a time of its own.

    ENDING is a frame that ends a transfer and has no answer. What comes behind it is answered when
    the device is done with both.
    """

    READ = auto()
    WRITE = auto()
    SEGMENT = auto()
    BURST = auto()
    BLOCK_END = auto()
    STORE = auto()
    ENDING = auto()


class Task(NamedTuple):
    """Work of a kind, with the index of the object that is written; 0 where that is open."""

    kind: Kind
    about: int = 0


READING = Task(Kind.READ)
# The requests that were not answered so far, and how many there are of each kind.
Tasks = Counter[Task]


def task_of(request: Request, running: Multiplexer | None) -> Task:
    """Return the work that a request is, with the object of the transfer that is running.

    >>> task_of(DownloadSegment(b"ABC", toggle=1, last=True), Multiplexer(0x2010))
    Task(kind=<Kind.WRITE: 2>, about=8208)
    """
    index = 0 if running is None else running.index
    match request:
        case BlockSegment():
            return Task(Kind.BURST)
        case DownloadInitiate() | BlockDownloadInitiate():
            kind = Kind.STORE if request.mux.index in COMMANDS else Kind.WRITE
            return Task(kind, request.mux.index)
        case DownloadSegment():
            return Task(Kind.WRITE, index) if request.last else Task(Kind.SEGMENT)
        case UploadSegment():
            return Task(Kind.SEGMENT)
        case BlockEnd():
            return Task(Kind.BLOCK_END, index)
        case Abort() | BlockEndResponse():
            return Task(Kind.ENDING)
        case _:
            return READING
