"""The cases that arguments of a command line name, by any id that is printed of them.

pytest knows files. A case is printed as ``cases/test_abort.py::abort.own[1]``, wherever the suite
is installed, and as ``abort.own[1]`` in reports and summaries; with several devices it is
``abort.own@5[1]``. All of these, and beginnings of ids, can be arguments again.
"""

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest

from conformance.plugin.items import CaseFunction
from conformance.run.case_files import CASE_FILES, CASES, case_files, cases_in
from conformance.sdo.nearest import meant

FOLDER = CASES.name
# Files, and the ids of their named cases or beginnings of ids; all cases if there are none.
Named = dict[Path, list[str]]
NAMED = pytest.StashKey[Named]()
# An id, also a mistyped one; files of tests have another ending.
_WRITTEN = re.compile(r"[a-z0-9_-]+\.(?!py\b)[a-z0-9._-]+", re.IGNORECASE)
# How an id goes on of which an argument is the beginning.
_BOUNDARY = (".", "-", "[")


def read_arguments(arguments: Iterable[str], beside: Path) -> tuple[list[str], Named]:
    """Return the arguments as pytest takes them, and the cases that are named in them.

    A path that exists ``beside``, in the folder of the command, stays a path. Raises
    pytest.UsageError for an argument that is nearly an id.
    """
    paths: dict[str, None] = {}
    named: Named = {}
    whole: set[Path] = set()
    for argument in arguments:
        path, _, case = argument.partition("::")
        folder, _, name = path.replace("\\", "/").partition("/")
        if (beside / path).exists():
            paths[argument] = None
        elif folder == FOLDER and (file := CASES / name).exists():
            paths[str(file)] = None
            if case:
                named.setdefault(file, []).append(case)
            else:
                whole |= {file, *file.glob(CASE_FILES)}
        elif files := _files_of(argument):
            for file in files:
                paths[str(file)] = None
                named.setdefault(file, []).append(argument)
        else:
            _check_id(argument)
            paths[argument] = None
    return list(paths), {file: ids for file, ids in named.items() if file not in whole}


def _check_id(argument: str) -> None:
    """Raise pytest.UsageError for an argument that is no path, and nearly the id of a case."""
    base = re.split(r"[\[@]", argument, maxsplit=1)[0]
    if _WRITTEN.fullmatch(base) and (hint := meant(base, _ids())):
        raise pytest.UsageError(f"There is no case, file or folder {argument!r}.{hint}")


def _files_of(argument: str) -> set[Path]:
    """Return the files with cases of an id, or of ids that begin so."""
    base = re.split(r"[\[@]", argument, maxsplit=1)[0]
    known = _ids()
    if base in known:
        return {known[base]}
    return {path for case, path in known.items() if _begins(case, base)}


@cache
def _ids() -> dict[str, Path]:
    return {info.rule.id: path for path in case_files() for info in cases_in(path)}


def _begins(case: str, beginning: str) -> bool:
    return case == beginning or case.startswith(tuple(beginning + mark for mark in _BOUNDARY))


def is_beside(item: pytest.Item, named: Named) -> bool:
    """Say whether an item is another case in a file of which some are named, on any device."""
    if not isinstance(item, CaseFunction) or not item.is_own:
        return False
    ids = named.get(item.path, ())
    return bool(ids) and not any(_names(one, item) for one in ids)


def _names(one: str, item: CaseFunction) -> bool:
    if one in _ids():
        return item.case.rule.id == one
    return one == item.name or _begins(item.case_id, one)
