"""A conversation as a picture: client and server, an arrow for each frame, its bytes explained."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from conformance.reporting.page.explained import Part, parts_of
from conformance.run.trace import TraceLine

_DATA = re.compile(r"[0-9A-F]+#((?:[0-9A-F]{2})*)")
# A picture is looked at: what led to the decisive frame, and a glance at what followed.
MOST_BEFORE, MOST_AFTER = 11, 2

WIDTH = 960
LIFELINES = 70, WIDTH - 70
MIDDLE = WIDTH // 2
FIRST_ROW, ROW = 58, 66
# Pixels: of a character of the bytes and of their meaning, beside and between them.
_HEX, _WORD, _PADDING, _GAP = 8.0, 6.3, 10, 6


@dataclass(frozen=True, slots=True)
class Box:
    """A part of a frame at its place, in pixels."""

    x: float
    width: float
    part: Part


@dataclass(frozen=True, slots=True)
class Row:
    """A frame of the picture: its arrow at ``y``, in pixels."""

    y: int
    time: str
    sent: bool
    words: str
    boxes: tuple[Box, ...]
    decisive: bool


@dataclass(frozen=True, slots=True)
class Diagram:
    """The picture of a conversation; ``left_out`` frames before it are in the trace only."""

    rows: tuple[Row, ...]
    left_out: int

    @property
    def height(self) -> int:
        """The height in pixels."""
        return FIRST_ROW + ROW * len(self.rows)

    @property
    def in_words(self) -> str:
        """The frames for those who cannot see the picture."""
        return "; ".join(
            f"{'client' if row.sent else 'server'}: {row.words}"
            f"{' (the offending frame)' if row.decisive else ''}"
            for row in self.rows
        )


def diagram(trace: Sequence[TraceLine], decisive: int | None) -> Diagram | None:
    """Draw the frames of a trace around the ``decisive`` one, or the last; None for no frame."""
    frames = [index for index, line in enumerate(trace) if line.frame]
    if not frames:
        return None
    end = len(frames) - 1 if decisive is None else frames.index(decisive)
    first = max(0, end - MOST_BEFORE)
    rows = (
        _row(trace[index], FIRST_ROW + ROW * number, decisive=index == decisive)
        for number, index in enumerate(frames[first : end + 1 + MOST_AFTER])
    )
    return Diagram(tuple(rows), first)


def _row(line: TraceLine, y: int, *, decisive: bool) -> Row:
    data = _DATA.fullmatch(line.frame)
    parts = parts_of(line.kind, bytes.fromhex(data[1])) if data else [Part(line.frame, "")]
    time = f"{line.elapsed * 1000:.1f} ms"
    return Row(y, time, line.sent, line.words, tuple(_placed(parts)), decisive)


def _placed(parts: Sequence[Part]) -> Iterator[Box]:
    """Put parts beside each other, in the middle of the picture."""
    widths = [
        max(len(part.data) * _HEX, len(part.meaning) * _WORD) + 2 * _PADDING for part in parts
    ]
    x = MIDDLE - (sum(widths) + _GAP * (len(parts) - 1)) / 2
    for part, width in zip(parts, widths, strict=True):
        yield Box(x, width, part)
        x += width + _GAP
