"""Where the cases are that come with the suite: beside the package, or in it once installed."""

from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from conformance.run.case import CaseInfo, case_info

_WITHIN = Path(__file__).parents[1] / "cases"
CASES = _WITHIN if _WITHIN.is_dir() else Path(__file__).parents[2] / "cases"
CASE_FILES = "test_*.py"


def case_files() -> list[Path]:
    """Return the files of the cases that come with the suite."""
    return sorted(CASES.glob(CASE_FILES))


def cases_in(path: Path) -> Iterator[CaseInfo]:
    """Yield the cases of a file, by their decorators."""
    spec = spec_from_file_location(f"conformance_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    for value in vars(module).values():
        info = case_info(value)
        if info is not None:
            yield info
