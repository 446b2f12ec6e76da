"""The trace of a case, read again: its frames as conformance.run.evidence has written them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from conformance.run.evidence import ASIDE, DECISIVE

_FRAME = re.compile(r"([* ]) *([\d.]+) ms ([<>]) (\S+) +(.*)")
_LEFT_OUT = re.compile(r"… (\d+) frames left out")


@dataclass(frozen=True, slots=True)
class Traced:
    """A frame of a trace: its number in the case, from 0, milliseconds, the frame, and words.

    ``own``: the case was not over yet.
    """

    number: int
    time: str
    sent: bool
    frame: str
    words: str
    decisive: bool
    own: bool


def traced(trace: Sequence[str]) -> Iterator[Traced]:
    """Yield the frames of a trace; the numbers count those that it leaves out as well."""
    number, own = 0, True
    for line in trace:
        if found := _FRAME.match(line):
            mark, time, arrow, frame, words = found.groups()
            yield Traced(number, time, arrow == ">", frame, words, mark == DECISIVE, own)
            number += 1
        elif line == ASIDE:
            own = False
        elif found := _LEFT_OUT.match(line):
            number += int(found[1])
