"""Names that users write, and the known ones that they may have meant."""

from collections.abc import Iterable
from difflib import get_close_matches

# What is compared takes time that grows with the square of it.
LONGEST_NAME = 80
SHORTEST_PART = 3
MOST_NAMES = 3
_MARKS = str.maketrans("", "", "-_. ")


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """Return the known names that are most like another one; none if none is.

    That is the one that differs in capitals or in ``-``, ``_`` and blanks alone, else the few that
    contain the name, else the most similar one.
    """
    short = name.lower()[:LONGEST_NAME]
    by_lower = {one.lower(): one for one in known}
    plain = short.translate(_MARKS)
    same = [one for lower, one in by_lower.items() if plain and lower.translate(_MARKS) == plain]
    if same:
        return same[:1]
    holding = [one for lower, one in by_lower.items() if plain in lower.translate(_MARKS)]
    if len(plain) >= SHORTEST_PART and 0 < len(holding) <= MOST_NAMES:
        return holding
    return [by_lower[near] for near in get_close_matches(short, by_lower, n=1)]


def meant(name: str, known: Iterable[str]) -> str:
    """Return a question for the nearest known names, with a blank before it; empty for none."""
    near = " or ".join(map(repr, nearest(name, known)))
    return f" Did you mean {near}?" if near else ""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a sentence with the nearest known names, or with all of them."""
    names = list(known)
    return meant(name, names).lstrip() or f"Known: {', '.join(names)}."
