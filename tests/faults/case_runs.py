"""Runs the cases against a server in this process, and keeps what they said of it."""

import contextlib
import io
import os
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import pytest

from conformance.plugin.items import CaseFunction
from conformance.run.verdict import CaseResult, Verdict

# pytest-xdist tells its workers how wide its terminal is; lines stay whole where there is none.
os.environ.pop("COLUMNS", None)

# What is judged at the end of a run belongs to each.
AT_THE_END = "run."
FAILED = (Verdict.FAIL, Verdict.BENCH_ERROR)


@dataclass(slots=True)
class Run:
    """What the cases said of one server: verdicts, and of those that failed the broken rules.

    A cause is a rule and the kind of answer.
    """

    name: str
    exit_code: int = 0
    verdicts: dict[str, Verdict] = field(default_factory=dict)
    rules: dict[str, str] = field(default_factory=dict)
    causes: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    output: str = ""

    def failed(self, *, strict: bool = False) -> list[str]:
        """Return the ids of the cases that failed, in the order of the run."""
        counts = (*FAILED, Verdict.NON_STRICT) if strict else FAILED
        return [case_id for case_id, verdict in self.verdicts.items() if verdict in counts]

    def take(self, result: CaseResult) -> None:
        """Keep what a case said."""
        self.verdicts[result.case_id] = result.verdict
        if result.verdict in FAILED:
            self.rules[result.case_id] = result.broken_rule or result.verdict.value
            cause = result.cause or result.broken_rule
            self.causes[result.case_id] = str(cause)


@dataclass(frozen=True, slots=True)
class Choice:
    """A pytest plugin that chooses cases: the named ones, and each ``share``-th of the others."""

    named: frozenset[str] = frozenset()
    begins: tuple[str, ...] = ()
    share: int = 1
    turn: int = 0
    left_out: frozenset[str] = frozenset()

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave out what is not wanted."""
        items[:] = [item for number, item in enumerate(items) if self.wants(item, number)]

    def wants(self, item: pytest.Item, number: int) -> bool:
        """Say whether a case is to be run."""
        if not isinstance(item, CaseFunction):
            return False
        if item.case_id in self.named or item.case_id.startswith((AT_THE_END, *self.begins)):
            return True
        return item.case_id not in self.left_out and number % self.share == self.turn % self.share


class _Collector:
    """A pytest plugin that keeps results."""

    def __init__(self, run: Run) -> None:
        self._run = run

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the result that the suite puts into its reports."""
        values = getattr(report, "conformance", None)
        if values is not None:
            self._run.take(CaseResult.from_dict(values))


def run_cases(
    name: str | None,
    *arguments: str,
    simulated: bool = True,
    plugins: Sequence[object] = (),
    run: Run | None = None,
) -> Run:
    """Run the cases against a server in this process; for None the reference server.

    The ``plugins`` may look at the ``run`` while it goes on. What it holds already is added to.
    """
    run = run or Run(name or "reference server")
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as out:
        command = [
            *("--self-test", "-q", "-p", "no:cacheprovider", "-p", "no:xdist"),
            *("-p", "no:unraisableexception"),  # it has the garbage collector look at all, twice
            *(["--sdo-simulated"] if simulated else []),
            *(f"--rootdir={folder}", f"--sdo-report-dir={folder}", "--sdo-no-page"),
            *([f"--sdo-fault={name}"] if name else []),
            *arguments,
        ]
        here = os.getcwd()
        os.chdir(folder)  # neither the options nor the tests of the checkout
        try:
            status = int(pytest.main(command, plugins=[_Collector(run), *plugins]))
            run.exit_code = run.exit_code or status
        finally:
            os.chdir(here)
    run.seconds += time.monotonic() - begin
    run.output += out.getvalue()
    return run
