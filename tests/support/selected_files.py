"""The files of cases that a run within a test can do without: to collect all takes time."""

import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from conformance.run.case_files import case_files


def other_files(arguments: Sequence[str]) -> list[str]:
    """Return options that leave out the files without a case that -k chooses by its id."""
    expression = arguments[arguments.index("-k") + 1] if "-k" in arguments else ""
    # A list of deviations is judged by all cases.
    judged = any("deviations" in argument for argument in arguments)
    if judged or not expression or "not " in expression:
        return []
    found: set[Path] = set()
    for part in expression.split(" or "):
        stems = {word.partition(".")[0] for word in re.findall(r"[^\s()]+", part)}
        known = stems & files_of_stems().keys()
        if not known:
            return []
        found.update(*(files_of_stems()[stem] for stem in known))
    return [f"--ignore={path}" for path in case_files() if path not in found]


@cache
def files_of_stems() -> dict[str, set[Path]]:
    """Return the files whose cases have ids that begin so, or whose own names do."""
    found: dict[str, set[Path]] = {
        path.stem: {other for other in case_files() if other.stem.startswith(path.stem)}
        for path in case_files()
    }
    for path in case_files():
        for stem in re.findall(r'^@\w+\(\s*"([a-z-]+)\.', path.read_text("utf-8"), re.MULTILINE):
            found.setdefault(stem, set()).add(path)
    return found
