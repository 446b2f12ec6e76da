"""Runs the cases against servers with two faults: one that hides others, and one that it may hide.

    python tests/faults/pairs.py [--quick] [--workers N] [--share N] [NAME ...]

A pair is right when a rule that the specific fault breaks alone is named beside those of the
pervasive one, and no case fails for a rule that neither of them breaks alone. A pervasive fault
alone fails few cases, in few causes. Fails when that is not so; pairs that cannot be told apart
are known, with the reason.

Each fault alone meets all cases but the random ones. A pair meets those that failed the specific
one, some of those that failed the pervasive one, and each N-th of the others (``--share``, 1 for
all); the others take turns from pair to pair, so that each is met beside every pervasive fault. One
that seems hidden meets all cases, as it may be told in one that neither fault fails alone.

With ``--quick`` every pervasive fault is paired with one specific one, and both meet the cases
whose ids say what is wrong with them, and few others in the files of these. NAMEs choose faults.
"""

import argparse
import os
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

from case_runs import Choice, Run, run_cases
from detection import files_of

from conformance.faults.catalogue import find_deviation
from conformance.run.case_files import CASES
from conformance.run.verdict import Verdict

PERVASIVE = (
    "every-abort-answered",
    "download-confirmed-then-refused",
    "unsized-downloads-refused",
    "blocks-refused-without-multiplexer",
    "strings-padded",
    "shorter-value-over-longer-one-in-buffer",
    "abort-in-transfer-unnamed",
    "answer-as-long-as-request",
    "deaf-after-remote-frame",
    "initiate-joins-running-transfer",
    "upload-and-download-side-by-side",
    "any-frame-continues-block-upload",
    "threshold-read-as-block-size",
    "gives-up-after-25-ms",
    "aborts-inside-sub-block",
    "first-request-unanswered",
    "nmt-boot-up-as-heartbeat",
)
"""Faults that hide much else; each was met in devices that others made.

They leave what they are not about to the class that follows, so that each can be put together with
any other fault.
"""

SPECIFIC = (
    "upload-last-segment-n-off-by-one",
    "download-n-ignored",
    "upload-last-flag-missing-when-full",
    "block-upload-last-at-full-block-not-marked",
    "second-segmented-upload-empty",
    "second-write-to-number-lost",
    "block-download-sent-acknowledged",
    "block-upload-repeats-from-ackseq",
    "abort-commits-download",
    "block-upload-new-block-size-ignored",
    "upload-size-8-bit",
    "block-download-number-four-bytes",
    "read-only-written-expedited",
    "limits-not-checked",
    "channel-restricted-taken",
    "block-download-crc-not-checked",
    "block-upload-crc-with-fillers",
    "nmt-heartbeat-never",
    "response-copied-to-other-id",
    "block-upload-next-request-lost",
    "number-empty-accepted",
    "unknown-specifier-ignored",
    "download-toggle-ignored",
    "nmt-stopped-answers",
)
"""Faults of all classes and all services, no two of them about the same."""

NO_BLOCKS = "there are no block transfers that it could be seen in"
HIDDEN: dict[tuple[str, str], str] = {
    ("blocks-refused-without-multiplexer", name): NO_BLOCKS
    for name in SPECIFIC
    if name.startswith("block-")
} | {
    ("gives-up-after-25-ms", "block-upload-next-request-lost"): (
        "in place of the answer that is lost comes the abort of a transfer that is over"
    ),
}
"""Pairs that cannot be told from the pervasive fault alone, and why."""

MOST_CASES, MOST_CAUSES = 60, 3
TIMEOUT = "--sdo-response-timeout=0.25"
SHARE, QUICK_SHARE = 6, 12
# Which specific fault the first pervasive one is paired with when it is quick; the rest follows.
QUICK_BEGIN = 21
# How many of the cases that failed the pervasive fault alone meet a pair.
OF_PERVASIVE = 60
WHOLE_RUN = "test_whole_run.py"
# It names no rule, so it tells of no fault.
BENCH_ERROR = Verdict.BENCH_ERROR.value


@dataclass(frozen=True, slots=True)
class Pair:
    """Two faults, what each of them fails alone, and what both together do."""

    pervasive: Run
    specific: Run
    both: Run

    @property
    def name(self) -> str:
        """The names of both."""
        return f"{self.pervasive.name}+{self.specific.name}"

    def told(self) -> list[str]:
        """Return the cases in which the specific fault is named beside the pervasive one.

        A rule that both break names it where the cause is none of the pervasive one.
        """
        alone = set(self.pervasive.rules.values())
        wanted = set(self.specific.rules.values()) - {BENCH_ERROR}
        new = self.specific.rules.keys() - self.pervasive.rules.keys()
        known = set(self.pervasive.causes.values())
        return [
            case
            for case, rule in self.both.rules.items()
            if rule in wanted
            and (rule not in alone or case in new or self.both.causes[case] not in known)
        ]

    def unexplained(self) -> list[str]:
        """Return the cases that fail for a rule that neither fault breaks alone.

        Not those that one of them fails alone, whatever is met first. Where the cause is one of
        theirs, another case is only the first to meet it.
        """
        alone = self.pervasive.rules.keys() | self.specific.rules.keys()
        rules = {*self.pervasive.rules.values(), *self.specific.rules.values()}
        causes = {*self.pervasive.causes.values(), *self.specific.causes.values()}
        return [
            case
            for case, rule in self.both.rules.items()
            if case not in alone and rule not in rules and self.both.causes[case] not in causes
        ]

    def problem(self) -> str:
        """Say what is wrong; empty where nothing is."""
        problems = []
        if not self.specific.rules:
            problems.append("the specific fault alone fails no case")
        elif not self.told():
            wanted = ", ".join(sorted(set(self.specific.rules.values())))
            problems.append(f"HIDDEN: none of {wanted}")
        if unexplained := self.unexplained():
            shown = ", ".join(f"{case} ({self.both.rules[case]})" for case in unexplained[:4])
            problems.append(f"UNEXPLAINED: {len(unexplained)}: {shown}")
        return "; ".join(problems)


def alone(name: str, choice: Choice | None = None, *files: str) -> Run:
    """Run the cases against a server with one fault."""
    plugins = [] if choice is None else [choice]
    return run_cases(name, TIMEOUT, "--sdo-examples=0", *files, plugins=plugins)


def spread(cases: Sequence[str], most: int) -> list[str]:
    """Return ``most`` cases or fewer, from the beginning to the end."""
    step = max(-(-len(cases) // most), 1)
    return list(cases[::step])


def choice_for(pervasive: Run, specific: Run, *, share: int, turn: int) -> Choice:
    """Choose the cases that a pair meets."""
    failed = pervasive.failed()
    return Choice(
        frozenset((*specific.failed(), *spread(failed, OF_PERVASIVE))),
        share=share,
        turn=turn,
        left_out=frozenset(failed),
    )


def quick_pair(pervasive: str, specific: str, turn: int) -> Pair:
    """Run few cases against each of two faults, and against both together."""
    found = [find_deviation(name) for name in (pervasive, specific)]
    begins = tuple(each.caught_by[0] for each in found if each is not None)
    files = [*files_of(*begins), str(CASES / WHOLE_RUN)]
    choice = Choice(begins=begins, share=QUICK_SHARE, turn=turn)
    names = (pervasive, specific, f"{pervasive}+{specific}")
    runs = [alone(name, choice, *files) for name in names]
    return Pair(*runs)


def problem_with_pervasive(run: Run) -> str:
    """Say whether a pervasive fault alone fails more than it should; empty where it does not."""
    failed, causes = len(run.failed()), len(set(run.causes.values()))
    if not failed:
        return "fails no case"
    if failed > MOST_CASES or causes > MOST_CAUSES:
        return f"fails {failed} cases in {causes} causes"
    return ""


@dataclass(slots=True)
class Table:
    """The pairs as they come, and what is wrong."""

    problems: list[str] = field(default_factory=list)
    right: int = 0
    pairs: int = 0

    def take_alone(self, run: Run) -> None:
        """Print what a pervasive fault fails alone."""
        causes = Counter(run.causes.values())
        shown = ", ".join(f"{cause} {number}" for cause, number in causes.most_common(6))
        print(f"{run.name:40} {len(run.failed()):5} cases, {len(causes)} causes: {shown}")
        if problem := problem_with_pervasive(run):
            self.problems.append(f"{run.name} alone {problem}")

    def take(self, pair: Pair) -> None:
        """Print whether a pair is right."""
        self.pairs += 1
        problem = pair.problem()
        known = HIDDEN.get((pair.pervasive.name, pair.specific.name))
        if known is not None:
            said = f"cannot be told: {known}" if problem else "can be told, though called hidden"
            if not problem or pair.unexplained():
                self.problems.append(f"{pair.name}: {problem or said}")
        elif problem:
            said = problem
            self.problems.append(f"{pair.name}: {problem}")
        else:
            self.right += 1
            case = pair.told()[0]
            said = f"ok   {pair.both.rules[case]} in {case}"
        print(f"{pair.name:82} {pair.both.seconds:6.1f} s  {said}", flush=True)

    def end(self) -> bool:
        """Print the sum; say whether anything is wrong."""
        share = f"{self.right / self.pairs:.1%}" if self.pairs else "none"
        print(f"{self.right} of {self.pairs} pairs are right ({share})")
        print(*self.problems, sep="\n")
        return bool(self.problems)


def chosen(names: Sequence[str], of: Sequence[str]) -> list[str]:
    """Return those that are named; all where none of them is."""
    return [name for name in of if name in names] or list(of)


def full_pairs(
    pervasive: Sequence[str], specific: Sequence[str], pool: ProcessPoolExecutor, *, share: int
) -> Iterator[Run | Pair]:
    """Run all pairs; yield what each pervasive fault does alone, and then its pairs."""
    specific_runs = pool.map(alone, specific)
    pervasive_runs = list(pool.map(alone, pervasive))
    known = list(specific_runs)
    for row, first in enumerate(pervasive_runs):
        yield first
        awaited = [
            pool.submit(
                alone,
                f"{first.name}+{second.name}",
                choice_for(first, second, share=share, turn=row + column),
            )
            for column, second in enumerate(known)
        ]
        for second, run in zip(known, awaited, strict=True):
            pair = Pair(first, second, run.result())
            if pair.told():
                yield pair
            else:  # it may be told in a case that neither fault fails alone
                yield Pair(first, second, pool.submit(alone, pair.name).result())


def quick_pairs(
    pervasive: Sequence[str], specific: Sequence[str], pool: ProcessPoolExecutor
) -> Iterator[Pair]:
    """Run each pervasive fault with one specific one."""
    partners = [
        specific[(QUICK_BEGIN + number) % len(specific)] for number in range(len(pervasive))
    ]
    yield from pool.map(quick_pair, pervasive, partners, range(len(pervasive)))


def main() -> int:
    """Print the table; returns 1 when anything is not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--quick", action="store_true", help="fewer cases and pairs, see above")
    parser.add_argument("--share", type=int, default=SHARE, help="see above (%(default)s)")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    pervasive, specific = chosen(options.names, PERVASIVE), chosen(options.names, SPECIFIC)
    table = Table()
    with ProcessPoolExecutor(options.workers) as pool:
        if options.quick:
            for pair in quick_pairs(pervasive, specific, pool):
                table.take(pair)
            return table.end()
        for found in full_pairs(pervasive, specific, pool, share=options.share):
            if isinstance(found, Run):
                table.take_alone(found)
            else:
                table.take(found)
    return table.end()


if __name__ == "__main__":
    sys.exit(main())
