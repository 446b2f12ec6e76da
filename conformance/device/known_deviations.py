"""Known deviations of a device: cases that are known to fail, each with the reason why it may.

[[deviations]]
case = "block-download.crc-mismatch"
reason = "ticket 123: the CRC is not checked before release 2"
rule = "block.crc"        # optional: excused only while this is the rule that it breaks
"""

import difflib
import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

NO_REASON = "TODO: say why"


class DeviationsError(ValueError):
    """A list of known deviations that cannot be used; says where and why."""


@dataclass(frozen=True, slots=True)
class Deviation:
    """A case that fails on this device. ``rule`` is the id of the rule that it breaks, if told."""

    case: str
    reason: str
    rule: str | None = None

    @property
    def is_explained(self) -> bool:
        """Whether somebody has filled in the reason of a draft."""
        return self.reason != NO_REASON


def read_deviations(path: Path) -> list[Deviation]:
    """Return the ``[[deviations]]`` of a TOML file; raises DeviationsError."""
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DeviationsError(f"{path} cannot be read: {error.strerror}.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DeviationsError(f"{path} is no TOML: {error}.") from error
    try:
        return parse_deviations(tables.get("deviations", []))
    except DeviationsError as error:
        raise DeviationsError(f"{path}: {error}") from None


def parse_deviations(entries: object) -> list[Deviation]:
    """Return what the array of tables ``[[deviations]]`` says; raises DeviationsError."""
    if not isinstance(entries, list):
        raise DeviationsError("deviations is no list of tables: write [[deviations]].")
    found: dict[str, Deviation] = {}
    for number, entry in enumerate(entries, start=1):
        where = f"[[deviations]] number {number}"
        if not isinstance(entry, Mapping):
            raise DeviationsError(f"{where} is no table: write case = … and reason = … below it.")
        deviation = _deviation(entry, where)
        if deviation.case in found:
            raise DeviationsError(f"{where}: {deviation.case} is listed twice.")
        found[deviation.case] = deviation
    return list(found.values())


def _deviation(entry: Mapping[str, Any], where: str) -> Deviation:
    known = [field.name for field in fields(Deviation)]
    for key, value in entry.items():
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"Did you mean {near[0]!r}?" if near else f"Known: {', '.join(known)}."
            raise DeviationsError(f"{where}: there is no key {key!r}. {hint}")
        if not isinstance(value, str) or not value.strip():
            raise DeviationsError(f"{where}: {key} is {value!r}; write a text between quotes.")
    for key in ("case", "reason"):
        if key not in entry:
            raise DeviationsError(f"{where} has no {key}: each names a case, and why it may fail.")
    return Deviation(**entry)


def unknown_case(deviations: Iterable[Deviation], case_ids: Iterable[str]) -> str | None:
    """Return a sentence on the first entry whose case does not exist, None if all do."""
    known = set(case_ids)
    for deviation in deviations:
        if deviation.case not in known:
            near = difflib.get_close_matches(deviation.case, sorted(known), n=1, cutoff=0.4)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            return (
                f"The known deviations name a case that does not exist: {deviation.case!r}.{hint} "
                "--collect-only lists all cases."
            )
    return None


def write_deviations(path: Path, deviations: Iterable[Deviation]) -> None:
    """Write a list that ``read_deviations`` reads; raises OSError."""
    lines = [
        "# Known deviations, drafted from a run. Say in each reason why it may stay; a case that",
        "# is listed here and passes fails the run until its entry goes.",
    ]
    for deviation in deviations:
        lines += ["", "[[deviations]]", f"case = {_quoted(deviation.case)}"]
        if deviation.rule is not None:
            lines.append(f"rule = {_quoted(deviation.rule)}")
        lines.append(f"reason = {_quoted(deviation.reason)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _quoted(text: str) -> str:
    # A string of JSON is one of TOML, but for DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
