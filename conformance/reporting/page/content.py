"""The contents of report.html, as values."""

import math
import re
from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from itertools import pairwise
from pathlib import Path

from conformance.reporting.bus_log import Place
from conformance.reporting.cause_counts import causes_of
from conformance.reporting.first_fix import FirstFix, first_fix, replay_command
from conformance.reporting.page.cases import Case, CauseShown, cause_shown
from conformance.reporting.page.groups import Group, Map, by_clause, by_rule, by_step, matrix_map
from conformance.reporting.page.profile import Chosen
from conformance.reporting.page.traffic import Times, Traffic
from conformance.reporting.recorded import RecordedRun
from conformance.reporting.reproduction import reproductions
from conformance.reporting.summary import QUICK, tested_share, written_objects
from conformance.run.verdict import FAILED, NOT_TESTED, CaseResult, Verdict

# The entry that a case on the object dictionary is about.
_ENTRY = re.compile(r"(?<=\[)[0-9A-F]{4}h:[0-9A-F]{2}(?=\])")
BARS = 24
# Milliseconds; a shorter time is below the resolution of a log.
SHORTEST = 0.001


@dataclass(frozen=True, slots=True)
class Distribution:
    """Response times to a kind of request, in milliseconds."""

    kind: str
    number: int
    percentiles: list[float]
    bars: list[int]
    slowest: list[tuple[float, Case]]


class PageContent:
    """Everything on the page of a run; ``profile`` has the choices of each device."""

    def __init__(
        self, folder: Path, run: RecordedRun, traffic: Traffic, profile: dict[int, Chosen]
    ) -> None:
        """Take the run, the folder of its reports, and the contents of its log."""
        self._folder = folder
        self.run = run
        self.traffic = traffic
        self.profile = profile
        shown = {number: _where(run.places[number]) for number in traffic.not_in_words}
        shown |= traffic.shown
        self.cases = [
            Case(number, result, shown.get(number, "")) for number, result in enumerate(run.results)
        ]
        self.about = run.about
        self.alone = len(run.about["node_ids"]) == 1

    # The verdict

    @cached_property
    def causes(self) -> list[CauseShown]:
        """The causes, most cases first."""
        by_result = {id(case.result): case for case in self.cases}
        shown = []
        for number, count in enumerate(causes_of(self.run), start=1):
            cases = [by_result[id(result)] for result in count.cases]
            paths = reproductions(self._folder, number, count)
            files = [path.relative_to(self._folder).as_posix() for path in paths]
            replay = replay_command(self._folder, number, count, self._bus, within=True)
            shown.append(cause_shown(count, cases, files, replay))
        return shown

    @property
    def first_fix(self) -> FirstFix | None:
        """The cause to begin with; None where there is none."""
        causes = [shown.count for shown in self.causes]
        return first_fix(causes, self._folder, self._bus, within=True) if causes else None

    @property
    def _bus(self) -> Sequence[str]:
        """The options that name the bus; records of earlier versions have none."""
        bus: Sequence[str] = self.about.get("bus_arguments", ())
        return bus

    @cached_property
    def failed(self) -> list[Case]:
        """The cases that failed."""
        failing = (*FAILED, *((Verdict.NON_STRICT,) if self.about["strict"] else ()))
        return [case for case in self.cases if case.result.verdict in failing]

    @property
    def outcome(self) -> str:
        """The name of the style of the verdict."""
        if self.failed:
            return "fail"
        return "pass" if self.run.end and not self.run.end["exit_status"] else "bench-error"

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        nodes = ", ".join(map(str, self.about["node_ids"]))
        who = f"Node {nodes}" if self.alone else f"Nodes {nodes}"
        share = tested_share(self.run.results)
        if self.failed:
            causes = len(self.causes)
            why = f", for {causes} {'cause' if causes == 1 else 'causes'}" if causes else ""
            return f"{who}: {share}, {len(self.failed)} failed{why}."
        if self.outcome == "pass":
            return f"{who}: {share}, none failed."
        return f"{who}: no case has failed, but the run is not a pass; see below."

    @property
    def troubles(self) -> list[str]:
        """The first warnings: values not put back, a lost bench or device."""
        if self.run.end is None:
            return self.run.troubles
        unrestored = [f"not put back: {line}" for line in self.run.end["unrestored"]]
        return list(dict.fromkeys([*unrestored, *self.run.end["bench_errors"]]))

    @cached_property
    def verdicts(self) -> list[Verdict]:
        """The verdicts that were given."""
        given = {case.result.verdict for case in self.cases}
        return [verdict for verdict in Verdict if verdict in given]

    def table(self, key: Callable[[CaseResult], str]) -> list[tuple[str, list[int], int]]:
        """Return rows of a name, the number of cases for each verdict, and their sum.

        Those with most failures come first.
        """
        counts: dict[str, Counter[Verdict]] = defaultdict(Counter)
        for case in self.cases:
            counts[key(case.result)][case.result.verdict] += 1
        most_failures = sorted(counts, key=lambda name: -sum(counts[name][each] for each in FAILED))
        return [
            (name, [counts[name][verdict] for verdict in self.verdicts], counts[name].total())
            for name in most_failures
        ]

    @property
    def by_service(self) -> list[tuple[str, list[int], int]]:
        """The verdicts of each service."""
        return self.table(lambda result: result.service)

    @property
    def by_level(self) -> list[tuple[str, list[int], int]]:
        """The verdicts of each level."""
        return self.table(lambda result: result.level)

    @property
    def not_tested(self) -> list[tuple[str, int]]:
        """The reasons why cases were not testable, most cases first; each says how to change it."""
        reasons = Counter(
            f"{case.result.verdict.value}: {case.result.actual}"
            for case in self.cases
            if case.result.verdict in NOT_TESTED and not case.result.cause
        )
        return reasons.most_common()

    @property
    def entries_tested(self) -> int:
        """How many entries of the description had a case with a verdict on them."""
        tested = {
            found[0]
            for result in self.run.results
            if result.verdict not in NOT_TESTED
            and (found := _ENTRY.search(result.case_id)) is not None
        }
        return len(tested)

    @property
    def writable(self) -> str:
        """The writable objects, in words."""
        return written_objects(self.about["writable"], all_rw=self.about["all_rw"])

    @property
    def quick(self) -> list[str]:
        """The cases that a quick run left out, of each device."""
        properties = self.run.properties
        return [text for name, text in properties.items() if name.rpartition(".")[2] == QUICK]

    @property
    def seconds(self) -> float | None:
        """How long the run took."""
        if self.run.end is None:
            return None
        begun, ended = map(datetime.fromisoformat, (self.about["begun"], self.run.end["at"]))
        return (ended - begun).total_seconds()

    # Cases in groups

    @cached_property
    def map(self) -> Map | None:
        """The map of states and stimuli; None where no case of the matrix was selected."""
        return matrix_map(self.cases)

    @cached_property
    def by_rule(self) -> list[Group]:
        """The cases of each rule that was tested."""
        return by_rule(self.cases)

    @cached_property
    def by_clause(self) -> list[Group]:
        """The cases of each clause."""
        return by_clause(self.cases)

    @cached_property
    def by_step(self) -> list[Group]:
        """The cases that do what a step of the official test does, and more."""
        return by_step(self.cases)

    # Times

    @cached_property
    def times(self) -> list[Distribution]:
        """The response times by kind of request."""
        return [self._distribution(kind, each) for kind, each in sorted(self.traffic.times.items())]

    def _distribution(self, kind: str, times: Times) -> Distribution:
        ordered = sorted(seconds * 1000 for seconds in times.all)
        # Each bar stands for times of one ratio: most answers are fast, a few very slow.
        shortest = max(ordered[0], SHORTEST)
        span = math.log(max(ordered[-1], 2 * shortest) / shortest)

        def bar(time: float) -> int:
            return min(BARS - 1, int(BARS * math.log(max(time, shortest) / shortest) / span))

        ends = [bisect_right(ordered, number, key=bar) for number in range(BARS)]
        slowest = [(seconds * 1000, self.cases[case]) for seconds, case in reversed(times.slowest)]
        return Distribution(
            kind,
            len(ordered),
            times.percentiles(),
            [end - begin for begin, end in pairwise([0, *ends])],
            slowest,
        )

    # Audit

    @property
    def written(self) -> Iterator[tuple[str, int, str, str, str]]:
        """Yield for each object: its name, downloads, times of day, and values that were sent."""
        for (node_id, mux), each in sorted(self.traffic.written.items()):
            name = str(mux) if self.alone else f"node {node_id}, {mux}"
            values = [value for value, _ in each.values.most_common(4)]
            more = len(each.values) - len(values)
            shown = "; ".join(values) + (f"; {more} more" if more else "")
            first, last = map(_time_of_day, (each.first, each.last))
            yield name, each.begun, first, last, shown


def _where(place: Place | None) -> str:
    """Say where the frames of a case are."""
    if place is None:
        return ""
    lines = f"lines {place.first} to {place.last}"
    return f"… {place.lines} frames, which are in {place.log}, {lines}"


def _time_of_day(seconds: float) -> str:
    return f"{datetime.fromtimestamp(seconds):%H:%M:%S}"
