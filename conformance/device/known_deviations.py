"""Known deviations of a device: cases that are known to fail, each with the reason why it may.

[[deviations]]
case = "block-download.crc-mismatch"
reason = "ticket 123: the CRC is not checked before release 2"
rule = "block.crc"        # optional: excused only while this is the rule that it breaks
"""

import difflib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from conformance.device.toml_tables import Table, TomlFile, anything, text_of

NO_REASON = "no reason given yet: say why it may stay"
TABLE = "deviations"
_WANTED = "write a text that is not empty"


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


def read_deviations(path: Path) -> tuple[Deviation, ...]:
    """Return the ``[[deviations]]`` of a TOML file; raises FileError."""
    file = TomlFile.read(path)
    top = file.top()
    found = deviations_in(file, top)
    top.finish()
    return found


def deviations_in(file: TomlFile, top: Table) -> tuple[Deviation, ...]:
    """Return the ``[[deviations]]`` beside other tables of a file; raises FileError."""
    entries: Any = top.read(TABLE, anything, "", [])
    if not isinstance(entries, list):
        raise file.error(f"write [[{TABLE}]], in double brackets.", "", TABLE)
    found: dict[str, Deviation] = {}
    for position, entry in enumerate(entries):
        table = Table(file, TABLE, entry, position)
        case = table.read("case", text_of, _WANTED, "")
        reason = table.read("reason", text_of, _WANTED, "")
        rule = table.read("rule", text_of, _WANTED, None)
        table.finish()
        if not case or not reason:
            raise file.error(
                "a deviation needs a case and a reason, which says why it is excused.",
                TABLE,
                "case" if case else "reason",
                position,
            )
        if case in found:
            raise file.error(f"{case} is listed twice.", TABLE, "case", position)
        found[case] = Deviation(case, reason, rule)
    return tuple(found.values())


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
