"""Known deviations of a device: cases that may fail, each with the reason.

[[deviations]]
case = "block-download.crc[1]"
reason = "ticket 123: the CRC is not checked before release 2"
rule = "block-download.crc"   # optional: excused only while this is the rule that it breaks;
                              # without it, while the rule is one that the case tests

[[deviations]]
case = "matrix.idle[*"    # several cases: * is any text, ? any character, nothing else is special
rule = "abort.code"
reason = "ticket 124"

[[deviations]]
rule = "abort.not-answered"   # in all cases
reason = "ticket 125"
"""

import fnmatch
import json
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from conformance.device.toml_tables import Table, TomlFile, anything, text_of
from conformance.sdo.nearest import meant

NO_REASON = "no reason given yet: write why it is accepted"
TABLE = "deviations"
_WANTED = "write a text that is not empty"
_WILD = re.compile(r"[*?]")


@dataclass(frozen=True, slots=True)
class KnownDeviation:
    """A known failure of this device: of a case, of the cases of a glob, or of a rule.

    ``rule`` is the id of the broken rule, or None; an entry without a ``case`` has one.
    """

    case: str | None
    reason: str
    rule: str | None = None

    def __str__(self) -> str:
        rule = "" if self.rule is None else f"rule {self.rule}"
        return ", ".join(filter(None, [self.case or "", rule]))

    @property
    def is_explained(self) -> bool:
        """Whether the reason of a draft was filled in."""
        return self.reason != NO_REASON

    @property
    def is_exact(self) -> bool:
        """Whether it is about one case."""
        return self.case is not None and _WILD.search(self.case) is None

    @property
    def key(self) -> tuple[str | None, str | None]:
        """The key of the entry in a list."""
        return (self.case, self.rule)

    @property
    def breadth(self) -> tuple[int, bool]:
        """How much it excuses: of several entries the narrowest counts."""
        return (0 if self.is_exact else 1 if self.case is not None else 2, self.rule is None)

    def names(self, case_id: str) -> bool:
        """Say whether a case may fail, if only by the rule."""
        return self.case is None or _pattern(self.case).fullmatch(case_id) is not None

    def excuses(self, case_id: str, broken: Collection[str], tested: Collection[str]) -> bool:
        """Say whether a case that tests some rules may have failed by breaking others.

        Without a rule, only the rules that the case tests are excused: another defect is news.
        A test of the user's own may fail without breaking a rule.
        """
        if not self.names(case_id):
            return False
        if self.rule is None:
            return not broken or not set(broken).isdisjoint(tested)
        return self.rule in broken


@lru_cache(maxsize=256)
def _pattern(glob: str) -> re.Pattern[str]:
    # The pattern of fnmatch does not backtrack between two stars.
    return re.compile(fnmatch.translate(glob.replace("[", "[[]")))


def read_deviations(path: Path) -> tuple[KnownDeviation, ...]:
    """Return the ``[[deviations]]`` of a TOML file; raises FileError."""
    top = TomlFile.read(path).top()
    found = deviations_in(top)
    top.finish()
    return found


def deviations_in(top: Table) -> tuple[KnownDeviation, ...]:
    """Return the ``[[deviations]]`` beside other tables of a file; raises FileError."""
    file = top.file
    entries: Any = top.read(TABLE, anything, "", [])
    if not isinstance(entries, list):
        raise file.error(f"write [[{TABLE}]], in double brackets.", "", TABLE)
    found: dict[object, KnownDeviation] = {}
    for position, entry in enumerate(entries):
        table = Table(file, TABLE, entry, position)
        case = table.read("case", text_of, _WANTED, None)
        reason = table.read("reason", text_of, _WANTED, "")
        rule = table.read("rule", text_of, _WANTED, None)
        table.finish()
        if (case is None and rule is None) or not reason:
            raise file.error(
                "a deviation needs a case or a rule, and a reason, which says why it is excused.",
                TABLE,
                "reason" if reason else "case" if case else "rule" if rule else "",
                position,
            )
        deviation = KnownDeviation(case, reason, rule)
        if deviation.key in found:
            listed = deviation.case if deviation.is_exact else deviation
            key = "rule" if case is None else "case"
            raise file.error(f"{listed} is listed twice.", TABLE, key, position)
        found[deviation.key] = deviation
    return tuple(found.values())


def unknown_case(
    deviations: Iterable[KnownDeviation], case_ids: Iterable[str], rule_ids: Iterable[str]
) -> str | None:
    """Return a sentence on the first entry whose case or rule does not exist, None if all do."""
    cases, rules = set(case_ids), set(rule_ids)
    for deviation in deviations:
        case, rule = deviation.case, deviation.rule
        if rule is not None and rule not in rules:
            return (
                f"The known deviations name a rule that does not exist: {rule!r}."
                f"{meant(rule, sorted(rules))} conformance rules lists all rules."
            )
        if case is None or case in cases or any(deviation.names(known) for known in cases):
            continue
        what = (
            "a case that does not exist" if deviation.is_exact else "cases of which there is none"
        )
        return (
            f"The known deviations name {what}: {case!r}."
            f"{meant(_WILD.sub('', case), sorted(cases))} --collect-only lists all cases."
        )
    return None


def write_deviations(path: Path, deviations: Iterable[KnownDeviation]) -> None:
    """Write a list that ``read_deviations`` reads; raises OSError."""
    lines = [
        "# Known deviations, drafted from a run. Write in each reason why it is accepted. A case",
        "# that is listed here and passes fails the run until its entry is deleted.",
    ]
    for deviation in deviations:
        lines += ["", "[[deviations]]"]
        if deviation.case is not None:
            lines.append(f"case = {_quoted(deviation.case)}")
        if deviation.rule is not None:
            lines.append(f"rule = {_quoted(deviation.rule)}")
        lines.append(f"reason = {_quoted(deviation.reason)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _quoted(text: str) -> str:
    # A string of JSON is one of TOML, but for DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
