"""The verdicts of a run as a table of its services, where not all has passed."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from conformance.run.verdict import FAILED, CaseResult, Verdict

REST = "others"
ALL = "all"


@dataclass(frozen=True, slots=True)
class Row:
    """A service, or several, with the number of its cases for each verdict."""

    name: str
    counts: Counter[Verdict]


def service_rows(results: Sequence[CaseResult], *, whole: bool) -> list[Row]:
    """Return a row for each service of which cases failed, most failures first, and for all.

    The others share a row, unless the table is to be ``whole``.
    """
    services: dict[str, Counter[Verdict]] = {}
    for result in results:
        services.setdefault(result.service, Counter())[result.verdict] += 1
    rows = [Row(name, counts) for name, counts in services.items()]
    rows.sort(key=_failures, reverse=True)
    shown = [row for row in rows if whole or _failures(row)]
    rest = rows[len(shown) :]
    if len(rest) == 1:
        shown += rest
    elif rest:
        shown.append(Row(f"{len(rest)} {REST}", _sum(rest)))
    return [*shown, *([Row(ALL, _sum(rows))] if len(rows) > 1 else [])]


def _failures(row: Row) -> int:
    return sum(row.counts[verdict] for verdict in FAILED)


def _sum(rows: Sequence[Row]) -> Counter[Verdict]:
    return sum((row.counts for row in rows), Counter())
