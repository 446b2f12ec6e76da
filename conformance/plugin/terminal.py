"""Lines on pytest's terminal, which fit it.

pytest decides about colours: none without a terminal, with ``--color=no`` or with NO_COLOR.
"""

import shutil
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

# The column at which a broken line goes on.
HANG = 4
# A terminal that is narrower gets lines of this length.
NARROWEST = 30

Markup = dict[str, bool]


class Terminal(Protocol):
    """The terminal on which pytest lets a failure print itself."""

    def line(self, s: str = "", **markup: bool) -> None:
        """Print one line."""


class SummaryTerminal(Protocol):
    """The part of pytest's terminal reporter that is used here; old pytests export no type."""

    showfspath: bool

    def ensure_newline(self) -> None:
        """Begin a new line, unless at the beginning of one."""

    def write(self, content: str, *, flush: bool = False, **markup: bool) -> None:
        """Print a part of a line."""

    def section(self, title: str, sep: str = "=", **markup: bool) -> None:
        """Print a heading."""

    def write_line(self, line: str, **markup: bool) -> None:
        """Print one line."""


def shown(path: Path) -> Path:
    """Return a path as short as it is from here."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def columns() -> int | None:
    """Return how long lines may be: None without a terminal and without COLUMNS.

    In a file, and in the log of a CI job, a line is found more easily while it is whole.
    """
    found = shutil.get_terminal_size(fallback=(0, 0)).columns
    return max(found, NARROWEST) if found else None


def fitted(text: str, hang: int = HANG) -> Iterator[str]:
    """Yield the lines of a text, each as one or more that fit the terminal.

    A word is never broken. A broken line goes on at the column ``hang``, or in the middle of a
    narrow terminal.
    """
    width = columns()
    for line in text.splitlines():
        if width is None or len(line) <= width:
            yield line
        else:
            yield from textwrap.wrap(
                line,
                width,
                subsequent_indent=" " * min(hang, width // 2),
                break_long_words=False,
                break_on_hyphens=False,
            )
