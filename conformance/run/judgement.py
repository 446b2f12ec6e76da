"""From what went wrong in a case to its verdict: a cause fails the cases that are about it.

Elsewhere it fails the case that meets it first, and from then on it stands: a case that it keeps
from its point is not testable, and names the cause.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from conformance.bus.errors import BenchError
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.causes import Causes, Standing
from conformance.run.leaving import Leaving
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import as_answer, is_answer
from conformance.sdo.describe import describe, in_words
from conformance.sdo.frames import (
    Abort,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
)
from conformance.sdo.kinds import kind_of
from conformance.sdo.rules import (
    MULTIPLEXER,
    NOT_REFUSED,
    SPECIFIER,
    UNSOLICITED,
    Cause,
    Level,
    Rule,
    Violation,
)
from conformance.sdo.rules.defects import REFUSED_LATE
from conformance.sdo.seen import Received, Seen

# An answer that breaks these may be one to something else.
WRONG_ANSWERS = frozenset(rule.id for rule in (SPECIFIER, NOT_REFUSED, MULTIPLEXER))


@dataclass(frozen=True, slots=True)
class Point:
    """What a case is about: its rule, and the rules of the registry that it tests.

    ``generated``: it is one of very many that a machine made, and need not repeat what another of
    them has shown.
    """

    rule: Rule
    cites: tuple[Rule, ...] = ()
    generated: bool = False

    def is_own(self, rule: Rule) -> bool:
        """Say whether a breach of a rule is what the case is about, wherever it was met.

        A generated case cites what holds for every answer: of those, one is its point.
        """
        cited = not self.generated and any(rule.id == each.id for each in self.cites)
        return rule.id == self.rule.id or cited

    def registered(self, rule: Rule) -> Rule:
        """Return a rule as the registry has it: the case's own is one that it cites."""
        return self.cites[0] if self.cites and rule.id == self.rule.id else rule


class Judgement:
    """Makes the verdict of one case from its breaches; the first one that fails it counts."""

    def __init__(
        self,
        result: CaseResult,
        point: Point,
        causes: Causes,
        in_doubt: Callable[[], bool] = lambda: False,
        explains: Callable[[], Cause | None] = lambda: None,
    ) -> None:
        """``causes`` are those that other cases have met; a new one is added.

        None is added while it is ``in_doubt`` whether it is the device's: nothing else would fail
        for it any more. ``explains`` returns what was met before in this case, and is the cause of
        whatever ends it.
        """
        self._result = result
        self._point = point
        self._causes = causes
        self._in_doubt = in_doubt
        self._explains = explains
        # The bytes of the frames that the verdict is about.
        self.frames: Sequence[bytes] = ()

    def ended(self, error: BaseException | None, asked: Request, *, own: bool = False) -> None:
        """Take what ended the case; ``asked`` is what it had sent last.

        ``own``: it is what the case is about, whatever its rule.
        """
        result = self._result
        match error:
            case None:
                return
            case Violation():
                self.breach(error, asked, own=own, in_the_way=True)
            case ServerAborted():
                self.breach(error.as_violation(), asked, in_the_way=True)
            case NotTestable():
                result.verdict, result.actual = Verdict.NOT_TESTABLE, str(error)
                result.missing = error.missing
            case Unimplemented():
                result.verdict, result.actual = Verdict.UNIMPLEMENTED, str(error)
                self.frames = error.frames
            case BenchError():
                result.verdict, result.actual = Verdict.BENCH_ERROR, str(error)
            case _:
                result.verdict, result.actual = Verdict.FAIL, f"{type(error).__name__}: {error}"

    def breach(
        self,
        violation: Violation,
        asked: Request,
        *,
        own: bool = False,
        in_the_way: bool = False,
    ) -> None:
        """Take a breach. ``own``: it is what the case is about, whatever its rule.

        ``in_the_way``: the case ended there.
        """
        result = self._result
        explained = self._explains() if in_the_way else None
        cause = explained or self.cause(violation, asked)
        own = explained is None and (own or self._point.is_own(violation.rule))
        if violation.level is Level.SHOULD:
            if result.verdict in (Verdict.PASS, Verdict.INFO, Verdict.NON_STRICT):
                self._blame(Verdict.NON_STRICT, violation, cause)
            return
        known = self._causes.get(cause)
        told = known is not None and not (known.aside and in_the_way)
        shown = known is not None and self._point.rule.id in known.shown_by
        repeated = (shown and self._point.generated) if own else told
        if known is not None and repeated:
            if in_the_way and result.verdict is not Verdict.FAIL:
                self._step_back(cause, known, violation, own=own)
            elif cause not in result.met:
                result.met.append(cause)
            return
        if not self._in_doubt():
            known = self._causes.add(cause, result.case_id, violation, aside=False)
            if own:
                known.shown_by.add(self._point.rule.id)
        if result.verdict in (Verdict.FAIL, Verdict.BENCH_ERROR):
            result.notes.append(f"also {violation}")
            return
        self._blame(Verdict.FAIL, violation, cause)

    def aside(self, violation: Violation, asked: Request) -> None:
        """Take a breach that the suite's own tidying has met: no case fails for it."""
        if not self._in_doubt():
            cause = self.cause(violation, asked)
            self._causes.add(cause, self._result.case_id, violation, aside=True)

    def cause(self, violation: Violation, asked: Request) -> Cause:
        """Return the cause of a breach that was met in this case."""
        rule, request = self._point.registered(violation.rule), violation.asked or asked
        cause = self._causes.of(violation, rule, request)
        point = self._point
        return self._causes.told_as(cause, request, point.rule.id, generated=point.generated)

    def _blame(self, verdict: Verdict, violation: Violation, cause: Cause) -> None:
        result = self._result
        result.verdict, result.cause = verdict, cause
        result.level = violation.level.value
        result.broken_rule, result.broken_sentence = violation.rule.id, violation.rule.sentence
        result.expected, result.actual = violation.expected, violation.actual
        self.frames = violation.seen.frames

    def _step_back(self, cause: Cause, known: Standing, violation: Violation, *, own: bool) -> None:
        result = self._result
        result.verdict, result.cause = Verdict.NOT_TESTABLE, cause
        why = "was reported before" if own else "prevents this case"
        result.actual = (
            f"{cause} {why}, see {known.first_case}: "
            f"expected {violation.expected}; got {violation.actual}"
        )
        self.frames = violation.seen.frames


def crossing(
    error: BaseException | None, stray: Sequence[Response], asked: Request
) -> Violation | None:
    """Return what was wrong where the true answer came behind what was taken for it.

    ``stray`` is what came behind that. None where it has no answer to ``asked``.
    """
    match error:
        case ServerAborted():
            actual: Seen = Received(error.abort)
        case Violation() if error.rule.id in WRONG_ANSWERS:
            actual = error.seen
        case _:
            return None
    if not is_answer(as_answer(stray[0]), asked):
        return None
    return Violation(
        UNSOLICITED, expected=f"nothing before the answer to: {describe(asked)}", actual=actual
    )


def confirmed_and_refused(
    error: BaseException | None, leaving: Leaving, asked: Request
) -> Violation | None:
    """Return what was wrong where an abort came behind the confirmation of a download.

    ``leaving`` has what came when the case was over, ``asked`` is what it had sent last. An abort
    behind that of the suite answers this one.
    """
    last = isinstance(asked, DownloadSegment) and asked.last
    if not (isinstance(error, Violation) and last and leaving.stray) or leaving.answers_abort:
        return None
    abort = as_answer(leaving.stray[0])
    confirmed = error.seen.kind == kind_of(DownloadSegmentResponse)
    if not confirmed or not isinstance(abort, Abort):
        return None
    both = error.seen.remarking(f", and {in_words(abort)} behind it")
    return Violation(UNSOLICITED, expected=error.expected, actual=both, told_as=REFUSED_LATE)
