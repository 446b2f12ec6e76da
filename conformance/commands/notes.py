"""Notes of commands, beside their results."""

import sys
from collections.abc import Iterable

from conformance.sdo.printable_text import inert


def tell(notes: Iterable[str]) -> None:
    """Print notes where they do not mix with the results of a command."""
    for note in notes:
        print(f"conformance: {inert(note)}", file=sys.stderr)
