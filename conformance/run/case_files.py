"""Where the cases are that come with the suite: beside the package, or in it once installed."""

from pathlib import Path

_WITHIN = Path(__file__).parents[1] / "cases"
CASES = _WITHIN if _WITHIN.is_dir() else Path(__file__).parents[2] / "cases"
CASE_FILES = "test_*.py"


def case_files() -> list[Path]:
    """Return the files of the cases that come with the suite."""
    return sorted(CASES.glob(CASE_FILES))
