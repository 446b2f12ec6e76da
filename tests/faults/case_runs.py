"""Runs the cases against a server in this process, and keeps what they said of it."""

import contextlib
import io
import os
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import pytest

from conformance.run.verdict import CaseResult, Verdict

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
            self.rules[result.case_id] = result.broken_rule_id or result.verdict.value
            cause = getattr(result, "cause", None) or result.broken_rule_id
            self.causes[result.case_id] = str(cause)


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

    The ``plugins`` may look at the ``run`` while it goes on.
    """
    run = run or Run(name or "reference server")
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()) as out:
        command = [
            *("--self-test", "-q", "-p", "no:cacheprovider", "-p", "no:xdist"),
            *(["--simulated"] if simulated else []),
            *(f"--rootdir={folder}", f"--report-dir={folder}"),
            *([f"--fault={name}"] if name else []),
            *arguments,
        ]
        here = os.getcwd()
        os.chdir(folder)  # neither the options nor the tests of the checkout
        try:
            run.exit_code = int(pytest.main(command, plugins=[_Collector(run), *plugins]))
        finally:
            os.chdir(here)
    run.seconds = time.monotonic() - begin
    run.output = out.getvalue()
    return run
