"""What a random conversation is made of, as values: they can be shrunk, stored and performed."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from conformance.sdo.layout import Multiplexer


class Service(StrEnum):
    """The kind of a transfer."""

    EXPEDITED = "expedited download"
    DOWNLOAD = "segmented download"
    UPLOAD = "upload"
    BLOCK_DOWNLOAD = "block download"
    BLOCK_UPLOAD = "block upload"


class Kind(StrEnum):
    """What conversations are drawn, by what the server is tried with."""

    SEGMENTED_TRANSFERS = "segmented transfers"
    BLOCK_TRANSFERS = "block transfers"
    SEQUENCES = "sequences"
    INTERRUPTED = "interrupted transfers"
    ANY_FRAMES = "any frames"


class Event(StrEnum):
    """What befalls a request on its way, or the client before it sends it."""

    ABORT = "the client aborts instead"
    LEAVE = "the client falls silent instead"
    LOSE = "lost"
    REPEAT = "sent twice"
    LATE = "sent behind the next one"
    INSERT = "another frame before it"
    ALTER = "bits of a byte inverted"
    CUT = "cut"


@dataclass(frozen=True, slots=True)
class Disturbance:
    """One event, at one of the requests of a transfer, counted from 0.

    ``byte`` is the one to alter, with the bits of ``mask`` inverted, or the number of bytes left
    of a frame that is cut. ``label`` names the frame to insert (see ``matrix.stimuli``).
    """

    at: int
    event: Event
    byte: int = 0
    mask: int = 0
    label: str = ""


@dataclass(frozen=True, slots=True)
class Transfer:
    """One transfer as the client means it, and what befalls it.

    ``size`` is that of strings and domains, in bytes; ``content`` decides on the data. A value of
    this size is written before an upload, unless ``size`` is 0. Of a block upload, ``block_sizes``
    are asked for in turn, ``threshold`` is pst, and ``withheld`` says how many segments of each
    sub-block in turn are not acknowledged.
    """

    service: Service
    target: Multiplexer
    size: int = 0
    content: int = 0
    sized: bool = True
    crc: bool = True
    threshold: int = 0
    block_sizes: tuple[int, ...] = (127,)
    withheld: tuple[int, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()


Conversation = tuple[Transfer, ...]


def to_lines(conversation: Conversation) -> list[str]:
    """Write a conversation as JSON, a line each transfer."""
    return [
        json.dumps({**asdict(transfer), "target": transfer.target._asdict()})
        for transfer in conversation
    ]


def from_lines(lines: Iterable[str]) -> Conversation:
    """Read what ``to_lines`` wrote; raises ValueError, TypeError or KeyError for anything else."""
    return tuple(_transfer(json.loads(line)) for line in lines)


def _transfer(values: dict[str, Any]) -> Transfer:
    disturbances = tuple(
        Disturbance(**{**found, "event": Event(found["event"])})
        for found in values.pop("disturbances")
    )
    return Transfer(
        Service(values.pop("service")),
        Multiplexer(**values.pop("target")),
        block_sizes=tuple(values.pop("block_sizes")),
        withheld=tuple(values.pop("withheld")),
        disturbances=disturbances,
        **values,
    )
