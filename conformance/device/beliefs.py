"""What the suite believes of a device since the reading at the beginning of the run."""

from dataclasses import dataclass, field

from conformance.sdo.layout import Multiplexer


@dataclass(slots=True)
class Beliefs:
    """What the reading has told beside values.

    ``unreadable`` says why an object could not be read; such an object is never written;
    ``misread`` are those of them that were not refused, ``too_long`` those that have so many bytes
    that they were not read to the end. ``passed_over`` are those that were not read because the
    device has very many. ``nowhere`` names entries that the device was seen to lack, as their
    sub-indices 00h, and whose multiplexers are text. ``answers_twice``: every read is answered
    twice, and alike, so that it may be two devices with one node-ID. ``is_behind``: it answers each
    request when the next one comes.
    ``streams``: it sends segments by itself behind what asks for them out of place; ``says_all``
    has such requests, as the tracker has them, behind which it was seen to send nothing.
    ``all_entries`` are indices of which it was seen to serve sub-indices that they cannot have.
    """

    unreadable: dict[Multiplexer, str] = field(default_factory=dict)
    misread: set[Multiplexer] = field(default_factory=set)
    too_long: set[Multiplexer] = field(default_factory=set)
    passed_over: set[Multiplexer] = field(default_factory=set)
    nowhere: tuple[Multiplexer, ...] = ()
    answers_twice: bool = False
    is_behind: bool = False
    streams: bool = False
    says_all: set[tuple[type, bool]] = field(default_factory=set)
    all_entries: set[int] = field(default_factory=set)
