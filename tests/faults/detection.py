"""Runs the cases against every faulty and every unusual server, and prints who caught whom.

    python tests/faults/detection.py [--quick] [--workers N] [NAME ...]

Fails when a fault is not caught by each case that it names, when an unusual server is failed, or
when a case fails against no faulty server at all: a case like that proves nothing.

With ``--quick`` a fault meets only the cases that it names, some faults all scripts; one that takes
a history to see is left out.
An unusual server meets one in eight of the scripts on the same subject, but for those on 65,536
bytes; the others take turns from server to server. Without ``--quick`` an unusual server meets all
cases, the matrix and the random ones as well. A faulty one meets them too, until a script, the
matrix and a random conversation have each caught it; from then on only cases that no server has
failed yet. The pairs of states meet the unusual servers, and the faults that show nowhere else.
"""

import argparse
import os
import sys
from collections.abc import Iterator, Sequence, Set
from concurrent.futures import Future, ProcessPoolExecutor

import pytest
from case_runs import AT_THE_END, Choice, Run, run_cases

from conformance.device.effort import USUAL_EXAMPLES
from conformance.faults.catalogue import all_deviations, unusual
from conformance.faults.registry import About, Deviation
from conformance.plugin.exit_code import ExitCode
from conformance.plugin.items import CaseFunction
from conformance.run.case_files import CASES, case_files

# A faulty server may keep silent a hundred times; a right one never does.
TIMEOUT_OF_FAULTS = "0.25"
# A fault that takes a history to see is given more of them than a run tries by default.
EXAMPLES_OF_FAULTS = 400
# How many servers are begun before the first of them is done, lest a slow one holds up the others.
AHEAD = 4
# With --quick an unusual server meets one script in QUICK_SHARE.
QUICK_SHARE = 8
# One of these moves more frames than all others that an unusual server meets.
HUGE = "beyond-16-bits"
# What is judged at the end of a run needs cases before it.
AGAINST_ALL = ("answers-twice", "download-not-stored", "upload-drops-last-byte", "answers-late")
BEFORE_THE_END = "upload.length"
FILES = {
    "upload": "test_expedited_upload",
    "download": "test_expedited_download",
    "segmented-upload": "test_segmented_upload",
    "segmented-download": "test_segmented_download",
    "abort": "test_abort",
    "specifier": "test_specifiers",
    "frame": "test_frame_shape",
    "sequence": "test_sequences",
    "block-download": "test_block_download",
    "block-upload": "test_block_upload",
    "block-sequence": "test_block_sequences",
    "vanished-client": "test_vanished_client",
    "server-timeout": "test_server_timeout",
    "channel": "test_channels",
    "communication": "test_communication",
    "pdo": "test_pdos",
    "independence": "test_channel_independence",
    "nmt": "test_nmt",
    "other-state": "test_other_state",
    "od": "test_object_dictionary",
    "matrix": "test_matrix",
    "random": "test_random",
    "pairs": "test_state_pairs",
    "run": "test_whole_run",
}
GENERATED = ("test_matrix", "test_random", "test_state_pairs")
# What there is in a thorough run, without its many examples.
THOROUGH = ("--sdo-thorough", f"--sdo-examples={USUAL_EXAMPLES}")
# An unusual server that is about these meets the files below as well when it is quick.
MORE_THAN_TRANSFERS = (About.LENGTHS, About.OBJECTS, About.CHANNELS, About.NMT)
BEYOND_TRANSFERS = (
    "test_object_dictionary",
    "test_object_dictionary_protocols",
    "test_object_dictionary_storage",
    "test_channels",
    "test_channels_stored",
    "test_communication",
    "test_communication_values",
    "test_pdos",
    "test_channel_independence",
    "test_nmt",
    "test_other_state",
    "test_nmt_values",
)
# Long enough for a right server on a loaded machine, short enough to wait for with the faulty ones.
SERVER_TIMEOUT, SERVER_TIMEOUT_OF_FAULTS = "--sdo-server-timeout=1", "--sdo-server-timeout=0.4"


class Sieve:
    """A pytest plugin that leaves out the cases that could say nothing new of a faulty server.

    ``proven`` are the cases, by ``subject_of``, that have failed a faulty server before.
    """

    def __init__(self, deviation: Deviation, run: Run, proven: frozenset[str]) -> None:
        """Take the verdicts of ``run`` as they come."""
        self._deviation = deviation
        self._run = run
        self._proven = proven

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(
        self, item: pytest.Item, nextitem: pytest.Item | None
    ) -> bool | None:
        """Leave a case out by calling it done, unless pytest has to change modules behind it."""
        assert isinstance(item, CaseFunction)
        another = nextitem is not None and nextitem.parent is not item.parent
        return None if another or self.wants(item.case_id) else True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Skip a case that is begun for the change of modules only."""
        assert isinstance(item, CaseFunction)
        if not self.wants(item.case_id):
            pytest.skip("nothing new")

    def wants(self, case_id: str) -> bool:
        """Say whether a case may tell what is not known yet."""
        failed = self._run.failed(strict=self._deviation.soft)
        reason = self._deviation.caught_by[0]
        if case_id.startswith(reason):
            return not any(case.startswith(reason) for case in failed)
        if subject_of(case_id) not in self._proven:
            return True
        return not any(kind_of(case) == kind_of(case_id) for case in failed)


def conditions_of(deviation: Deviation) -> list[str]:
    """Return the options without which a server shows nothing.

    Cases on time-outs look at the clock, which stands still on a simulated bus.
    """
    if deviation.timed:
        return [SERVER_TIMEOUT_OF_FAULTS if deviation.is_fault else SERVER_TIMEOUT]
    return [*THOROUGH] if deviation.thorough else []


def files_of(*begins: str) -> list[str]:
    """Return the files of cases whose ids begin like that, and of others on the same services."""
    services = {FILES[begin.partition(".")[0]] for begin in begins}
    return sorted({str(path) for service in services for path in CASES.glob(f"{service}*.py")})


def scripts(*without: str) -> list[str]:
    """Return the files of all cases but the generated ones, and others that are left out."""
    left_out = (*GENERATED, *without)
    return [str(path) for path in case_files() if path.stem not in left_out]


def run_deviation(
    deviation: Deviation, proven: frozenset[str] = frozenset(), *, quick: bool
) -> Run:
    """Run the cases against a faulty or an unusual server."""
    if not deviation.is_fault:
        return run_unusual(deviation, quick=quick)
    run = Run(deviation.name)
    reason, *further = deviation.caught_by
    if quick and deviation.name not in AGAINST_ALL:
        run_named(deviation, run, reason)
    else:
        some = (*scripts(), "-k", f"not {HUGE}") if quick else ()
        sieve = () if deviation.name in AGAINST_ALL else (Sieve(deviation, run, proven),)
        run_fault(deviation, run, *some, plugins=sieve)
        if not any(case.startswith(reason) for case in run.failed(strict=deviation.soft)):
            # Another case has told the cause, and it is told once.
            run_named(deviation, run, reason)
    for begin in further:
        run_named(deviation, run, begin)
    return run


def run_named(deviation: Deviation, run: Run, begin: str) -> None:
    """Run cases by the beginning of their ids: with others one may be in the way of another."""
    begins = (begin, BEFORE_THE_END) if begin.startswith(AT_THE_END) else (begin,)
    run_fault(deviation, run, "-k", " or ".join(begins), *files_of(*begins))


def run_fault(
    deviation: Deviation, run: Run, *arguments: str, plugins: Sequence[object] = ()
) -> None:
    """Run cases against a faulty server, and add to what they said of it before."""
    examples = [f"--sdo-examples={EXAMPLES_OF_FAULTS}"] if deviation.about is About.HISTORY else []
    run_cases(
        deviation.name,
        *conditions_of(deviation),
        *arguments,
        f"--sdo-response-timeout={TIMEOUT_OF_FAULTS}",
        *examples,
        simulated=not deviation.timed,
        plugins=plugins,
        run=run,
    )


def run_unusual(deviation: Deviation, *, quick: bool) -> Run:
    """Run the cases against an unusual server."""
    if deviation.timed:  # in all else it is the reference server
        timed = (*conditions_of(deviation), *files_of("server-timeout"))
        return run_cases(deviation.name, *timed, simulated=False)
    if not quick:
        return run_cases(deviation.name, *THOROUGH)
    beyond = () if deviation.about in MORE_THAN_TRANSFERS else BEYOND_TRANSFERS
    choice = Choice(share=QUICK_SHARE, turn=unusual().index(deviation))
    return run_cases(deviation.name, *scripts(*beyond), "-k", f"not {HUGE}", plugins=[choice])


def problem_with(deviation: Deviation, run: Run, *, whole: bool = False) -> str:
    """Say in what the run, of all cases where it is ``whole``, is not what it should be."""
    if not deviation.is_fault:
        failed = run.failed(strict=not deviation.soft)
        if whole and deviation.soft and not run.failed(strict=True):
            return "called soft, but misses no SHOULD"
        return f"FALSE ALARM: {', '.join(failed[:5])}" if failed else ""
    if deviation.soft and run.failed():
        return f"misses a SHOULD alone, but fails: {', '.join(run.failed()[:5])}"
    failed = run.failed(strict=deviation.soft)
    # A server that is gone for good is met by whichever case provokes that first, or before them.
    lost = run.exit_code == ExitCode.DEVICE_LOST
    if not failed and not lost:
        return "NOT CAUGHT"
    missed = [
        begin
        for begin in deviation.caught_by
        if not any(case_id.startswith(begin) for case_id in failed)
    ]
    if missed and not lost:
        return f"caught, but by no case called {', '.join(missed)}: {', '.join(failed[:5])}"
    return ""


def kind_of(case_id: str) -> str:
    """Say which kind of case an id belongs to."""
    stem = case_id.partition(".")[0]
    return stem if stem in ("matrix", "random", "pairs") else "scripts"


def subject_of(case_id: str) -> str:
    """Return what has to be proven able to fail: a case, a state of the matrix, or all pairs."""
    return case_id.partition("[")[0] if kind_of(case_id) in ("matrix", "pairs") else case_id


def row(deviation: Deviation, run: Run) -> str:
    """Return the line of a server: how it was caught, and the first case of each kind to do so."""
    failed = run.failed(strict=deviation.soft and deviation.is_fault)
    result = problem_with(deviation, run) or "ok"
    first = next((case for case in failed if case.startswith(deviation.caught_by)), "-")
    columns = [f"{deviation.name:46} {run.seconds:6.1f} s  {result:4} {first:56}"]
    for kind in ("scripts", "matrix", "random"):
        found = next((case for case in failed if kind_of(case) == kind), "-")
        columns.append(f"{kind} {found:50}")
    return " | ".join(columns).rstrip()


def idle_cases(proven: Set[str], clean: Run) -> list[str]:
    """Return the ids of the cases that no server failed; of the matrix, states without any."""
    return [case for case in dict.fromkeys(map(subject_of, clean.verdicts)) if case not in proven]


def run_all(
    deviations: Sequence[Deviation], proven: set[str], *, workers: int, quick: bool
) -> Iterator[tuple[Deviation, Run]]:
    """Run the cases against several servers at a time; add to ``proven`` those that can fail.

    Where that is ``quick``, those that are waited for by the clock have workers of their own.
    """
    timed = [deviation for deviation in deviations if deviation.timed and quick]
    waiting = [deviation for deviation in reversed(deviations) if deviation not in timed]
    with ProcessPoolExecutor(workers) as pool, ProcessPoolExecutor(workers) as idle:
        running: dict[str, Future[Run]] = {
            each.name: idle.submit(run_deviation, each, quick=quick) for each in timed
        }
        for deviation in deviations:
            while waiting and len(running) < AHEAD * workers + len(timed):
                following = waiting.pop()
                running[following.name] = pool.submit(
                    run_deviation, following, frozenset(proven), quick=quick
                )
            run = running.pop(deviation.name).result()
            if deviation.is_fault:
                proven |= {subject_of(case) for case in run.failed(strict=True)}
            yield deviation, run


def clean_run() -> Run:
    """Run all cases against the reference server."""
    run = run_cases(None, *THOROUGH)
    timed = run_cases(None, SERVER_TIMEOUT, *files_of("server-timeout"), simulated=False)
    run.verdicts |= timed.verdicts
    return run


def main() -> int:
    """Print the table; returns 1 when anything is not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--quick", action="store_true", help="fewer cases, see above")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    deviations = [
        deviation
        for deviation in all_deviations()
        if deviation.name in options.names
        or not (options.names or (options.quick and deviation.about is About.HISTORY))
    ]
    problems = []
    proven: set[str] = set()
    judged = run_all(deviations, proven, workers=options.workers, quick=options.quick)
    for deviation, run in judged:
        print(row(deviation, run), flush=True)
        if problem := problem_with(deviation, run, whole=not options.quick):
            problems.append(f"{deviation.name}: {problem}")
    if not options.quick:
        clean = clean_run()
        failed = clean.failed(strict=True)
        problems += [f"the reference server fails {case_id}" for case_id in failed]
        if not options.names:
            problems += [f"no faulty server fails {case}" for case in idle_cases(proven, clean)]
    faults = sum(deviation.is_fault for deviation in deviations)
    print(f"{faults} faults, {len(deviations) - faults} unusual servers, {len(problems)} problems")
    print(*problems, sep="\n")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())
