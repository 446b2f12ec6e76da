"""The summary at the end of a run: its results, missing objects, and the first thing to repair."""

from collections.abc import Iterator, Sequence

from conformance.device.known_deviations import KnownDeviation
from conformance.device.options import WRITE_DEVIATIONS
from conformance.plugin.selection import FOLDER
from conformance.plugin.state import RunState
from conformance.plugin.terminal import SummaryTerminal, columns, fitted, shown
from conformance.reporting.cause_counts import CauseCount, cause_lines
from conformance.reporting.first_fix import first_fix
from conformance.reporting.service_table import Row, service_rows
from conformance.reporting.summary import (
    device_lines,
    found_lines,
    not_run_lines,
    summary_lines,
)
from conformance.run.verdict import FAILED, Verdict

# A table may be as wide where there is no terminal; between its columns are so many spaces at most.
WIDE, WIDEST_GAP = 100, 2


class TerminalSummary:
    """Prints the end of a run; of one in which all is well, a few lines.

    ``whole``: also parts that are left out because they are long.
    """

    def __init__(self, terminal: SummaryTerminal, state: RunState, *, whole: bool) -> None:
        """Take the terminal, and a run whose reports are written."""
        self._terminal = terminal
        self._state = state
        self._whole = whole

    def write(
        self,
        causes: Sequence[CauseCount],
        stale: Sequence[KnownDeviation],
        untested: Sequence[str],
        *,
        left_out: bool,
    ) -> None:
        """Print the results, and the requirements that are ``untested``.

        ``left_out``: none of the suite's cases was run.
        """
        state, findings = self._state, self._state.findings
        folder = shown(state.report_dir)
        self._terminal.ensure_newline()
        if state.results:
            self._terminal.section("conformance")
            for line in self._counts():
                self._line(line)
            self._terminal.write_line(f"reports: {folder}")  # in one line, to be copied
            self._table()
            self._causes(causes)
        for unjudged in findings.unjudged:
            self._line(f"late response after {unjudged}", red=True)
        for beside in findings.beside:
            self._line(f"outside the cases, at {beside}", red=True)
        for each in stale:
            self._line(
                f"stale deviation: {each} ({each.reason}) excused no failure in this run: delete "
                "its entry from the known deviations",
                red=True,
            )
        for sentence in untested:
            self._line(f"required, but not tested: {sentence}", red=True)
        for restored in findings.restored:
            self._line(restored)
        for unrestored in findings.unrestored:
            self._line(f"not restored: {unrestored}")
        if findings.unrestored:
            self._line(
                f"the complete values are in {folder}: 'conformance restore {folder}' writes them "
                "back"
            )
        if left_out:
            self._line(
                "none of the suite's cases was run: to run them with your own tests, add "
                f"{FOLDER!r} to the arguments; to run your own tests alone, name their files, and "
                "use the fixtures of the suite in them",
                red=True,
            )
        if findings.bench_errors:
            self._terminal.section("the bench", red=True)
            for error in dict.fromkeys(map(str, findings.bench_errors)):
                self._line(error)
        for line in not_run_lines(state.results):
            self._line(line)

    def _line(self, text: str, **markup: bool) -> None:
        for line in fitted(text):
            self._terminal.write_line(line, **markup)

    def _counts(self) -> Iterator[str]:
        state = self._state
        yield from device_lines(state.options.node_ids, state.results)
        yield from found_lines(state.findings.properties)
        yield from summary_lines(state.results, whole=self._whole)
        yield from state.findings.stopped
        yield from (f"bench: {note}" for note in dict.fromkeys(state.findings.notes))
        unexplained = [known for known in state.options.deviations if not known.is_explained]
        if unexplained:
            yield f"known deviations without a reason: {len(unexplained)}; state why each may stay"
        draft = state.options.given[WRITE_DEVIATIONS]
        if draft is not None:
            yield f"draft of the known deviations: {draft}"

    # The services

    def _table(self) -> None:
        """Print the services with their verdicts, if there are several and any has failed."""
        results = self._state.results
        rows = service_rows(results, whole=self._whole)
        if len(rows) < 2 or not any(result.verdict in FAILED for result in results):
            return
        self._terminal.section("by service", "-")
        verdicts = [each for each in Verdict if any(row.counts[each] for row in rows)]
        first = max(len(row.name) for row in rows)
        room = (columns() or WIDE) - first - sum(map(len, verdicts))
        if room < len(verdicts):
            for row in rows:
                given = (f"{row.counts[each]} {each}" for each in verdicts if row.counts[each])
                self._line(f"{row.name}: {', '.join(given)}")
            return
        gap = min(room // len(verdicts), WIDEST_GAP)
        heads = "".join(f"{verdict:>{len(verdict) + gap}}" for verdict in verdicts)
        self._terminal.write_line(f"{'':{first}}{heads}", bold=True)
        for row in rows:
            self._row(row, first, verdicts, gap)

    def _row(self, row: Row, first: int, verdicts: Sequence[Verdict], gap: int) -> None:
        self._terminal.write(f"{row.name:{first}}")
        for verdict in verdicts:
            number = row.counts[verdict]
            cell = f"{number or '':>{len(verdict) + gap}}"
            self._terminal.write(cell, red=bool(number) and verdict in FAILED)
        self._terminal.write_line("")

    # The causes

    def _causes(self, causes: Sequence[CauseCount]) -> None:
        if not causes:
            return
        self._terminal.section("causes, most cases first")
        alone = len(self._state.options.node_ids) == 1
        for number, line in enumerate(cause_lines(causes, alone=alone), start=1):
            self._line(f"{number:>2}. {line}")
        fix = first_fix(
            causes, shown(self._state.report_dir), self._state.options.run.bus.arguments
        )
        self._terminal.write_line("")
        self._line(f"fix this first: {fix.cause}", bold=True)
        for text in fix.why:
            self._line(f"    {text}")
        self._line(f"    to test it alone: add {fix.case_id} to the command line")
        if fix.replay:  # in one line, to be copied
            self._terminal.write_line("    to see it again:")
            self._terminal.write_line(f"      {fix.replay}")
