"""Failures as the terminal shows them: fitting it, in colour, and with a command that repeats them.

Other plugins and files get the plain evidence.
"""

from collections.abc import Callable, Generator, Iterator

import pytest

from conformance.plugin.failure import lines_shown
from conformance.plugin.state import RunState
from conformance.plugin.terminal import HANG, Markup, fitted, shown
from conformance.reporting.cause_counts import CauseCount
from conformance.reporting.first_fix import replay_command
from conformance.run.evidence import WORDS_AT, Part, evidence_lines
from conformance.run.verdict import CaseResult

_MARKUP: dict[Part, Markup] = {
    Part.TITLE: {"bold": True},
    Part.EXPECTED: {"green": True},
    Part.ACTUAL: {"red": True},
    Part.DECISIVE: {"red": True, "bold": True},
}


class PrintedFailures:
    """Keeps failures until they are printed; the ``causes`` are those of the whole run."""

    def __init__(self, state: RunState) -> None:
        """Begin without a failure."""
        self.causes: list[CauseCount] = []
        self._state = state
        self._failed: list[tuple[pytest.TestReport, CaseResult]] = []

    def take(self, report: pytest.TestReport, result: CaseResult) -> None:
        """Take the report of a case."""
        if report.failed:
            self._failed.append((report, result))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_terminal_summary(self, config: pytest.Config) -> Generator[None, object, object]:
        """Change the failures that pytest is about to print; all other readers have them by now."""
        markup = config.get_terminal_writer().markup
        replays = self._replays()
        for report, result in self._failed:
            lines = lines_shown(report, result)
            if lines is not None:
                replay = replays.get((result.node_id, result.case_id), "")
                lines[:] = _printed(result, replay, markup)
        return (yield)

    def _replays(self) -> dict[tuple[int, str], str]:
        """Return the commands that send the frames of the causes again, by node-ID and case."""
        folder = shown(self._state.report_dir)
        return {
            (count.node_id, count.cases[0].case_id): replay_command(
                folder, number, count, self._state.options.run.bus.arguments
            )
            for number, count in enumerate(self.causes, start=1)
        }


def _printed(result: CaseResult, replay: str, markup: Callable[..., str]) -> Iterator[str]:
    """Yield the lines of a failure; ``replay`` stands where the bus has no command of its own."""
    for text, part in evidence_lines(result):
        hang = WORDS_AT if part in (Part.FRAME, Part.DECISIVE) else HANG
        for line in fitted(text, hang):
            yield markup(line, **_MARKUP.get(part, {}))
    if replay and not result.reproduce:
        yield "  to repeat what was sent:"
        yield f"    {replay}"
