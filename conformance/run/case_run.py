"""A case that is running: it begins, ends, and is judged by what it met and what it left behind."""

import time

from conformance.beginning.two_devices import either
from conformance.bus.errors import BenchError
from conformance.device.device import DEVICE_TYPE
from conformance.dialogue.causes import Standing
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.rule_families import INCIDENTAL
from conformance.dialogue.server_aborts import Way, leaves
from conformance.dialogue.tools import CaseTools
from conformance.run.judgement import Judgement, Point, confirmed_and_refused, crossing
from conformance.run.leaving import Leaving, Proof, leave, shift
from conformance.run.session import MOST_INCIDENTS, DeviceSession, Incident
from conformance.run.verdict import (
    FAILED,
    Afterwards,
    CaseResult,
    Verdict,
)
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import as_answer
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort, Request
from conformance.sdo.rules import IDLE_AFTERWARDS, NO_REBOOT, Cause, Level, Rule, Violation
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED
from conformance.sdo.seen import NoAnswer


def as_violation(error: BaseException | None) -> BaseException | None:
    """Return a refusal as the breach that it is, anything else as it is."""
    if not isinstance(error, ServerAborted):
        return error
    return error.as_violation()


def begin_case(
    session: DeviceSession,
    case_id: str,
    service: str,
    rule: Rule,
    cites: tuple[Rule, ...] = (),
    *,
    generated: bool = False,
    own: bool = False,
) -> "CaseRun":
    """Start a case.

    ``cites`` are the rules of the registry that it tests; a ``generated`` one need not show what
    another of its kind has shown. One of the suite's ``own`` takes strings and domains as it finds
    them, and may leave them with another value: see ``Restorer``.
    """
    sdo = session.begin(case_id, rule, as_before=not own)
    result = CaseResult(
        case_id,
        service,
        session.device.node_id,
        rule.level.value,
        rule.clause,
        rule.sentence,
        rules=[each.id for each in cites],
    )
    proof = Proof.FENCE if generated else Proof.ANEW
    return CaseRun(session, sdo, result, Point(rule, cites, generated), proof, leaves_values=own)


class CaseRun:
    """A case that is running."""

    def __init__(
        self,
        session: DeviceSession,
        sdo: Dialogue,
        result: CaseResult,
        point: Point,
        proof: Proof,
        *,
        leaves_values: bool,
    ) -> None:
        """Start the clock of the case."""
        self.tools = CaseTools.of(sdo)
        self.result = result
        self._session = session
        self._leaves_values = leaves_values
        self._proof = proof
        self._judgement = Judgement(
            result,
            point,
            session.causes,
            in_doubt=lambda: sdo.wire.pauses.in_doubt,
            explains=sdo.record.explains,
        )
        contents = session.device.contents
        self._found = {mux: contents.current.get(mux) for mux in contents.left()}
        self._boot_ups = session.channel.boot_ups
        self._causes = session.causes.state()
        self.bench_error: BenchError | None = None
        self._minor: list[Violation] = []
        self._tidies = False
        self.is_over = False
        self.own_frames = 0
        self._begin = time.monotonic()

    def conclude(self, error: BaseException | None) -> CaseResult:
        """Judge what happened, leave the server idle and the values as they were.

        ``error`` is what ended the case. A bench error makes the verdict; nothing excuses it. One
        that was met only here is kept as ``bench_error``. Raises RunStopped where the
        user does not want to wait for that.
        """
        self.is_over = True
        self.sdo.record.in_case = False
        self.sdo.wire.timing.allowance = None
        with self._session.channel.link.stop.putting_back():
            return self._conclude(error)

    def _conclude(self, error: BaseException | None) -> CaseResult:
        result = self.result
        own_frames = self.own_frames = self._session.frames_so_far()
        asked = self.sdo.wire.last_sent
        leaving: Leaving | None = None
        try:
            leaving = self._leave(error)
        except BenchError as bench_error:
            if not isinstance(error, BenchError):
                self.bench_error = error = bench_error
        self._judge(error, asked, leaving)
        left_wrong = leaving is not None and self._judge_leaving(asked, leaving)
        try:
            self._put_back(leaving)
        except BenchError as bench_error:
            if not isinstance(error, BenchError):
                self.bench_error = bench_error
                self._judgement.ended(bench_error, asked)
        # The wait for answers that did not come is the price of a silent device.
        timing = self.sdo.wire.timing
        result.waited, result.latency = timing.waited, timing.latency
        result.answers, result.answering = timing.answers, timing.answering
        result.duration = time.monotonic() - self._begin
        result.notes += self.sdo.record.notes
        if result.verdict is Verdict.FAIL and self._session.device.learned.answers_twice:
            result.notes.append(either(self._session.device.node_id))
        if result.verdict is not Verdict.PASS:
            result.trace, result.decisive = self._session.trace(
                own_frames,
                self.sdo.record.channels,
                aside=left_wrong,
                decisive=isinstance(error, Violation | ServerAborted),
                shown=self._judgement.frames,
            )
            result.reproduce = self._session.reproduce(own_frames)
        self._session.end()
        return result

    def way_left(self, error: BaseException | None) -> Way | None:
        """Say in which way the server has left the case early; None where it did not do that.

        Nor where that is known of it.
        """
        sdo = self.sdo
        asked = sdo.wire.last_sent
        if sdo.wire.pauses.excuse or sdo.record.is_known(as_violation(error), asked):
            return None
        return sdo.record.early.way(error, asked)

    @property
    def sdo(self) -> Dialogue:
        """The conversation of the case on its own channel."""
        return self.tools.sdo

    @property
    def session(self) -> DeviceSession:
        """The device's part of the run."""
        return self._session

    @property
    def causes_before(self) -> dict[Cause, Standing]:
        """What was known to be wrong with the device when the case began."""
        return self._causes

    def retreat(self, tries: int) -> bool:
        """Leave a case that is to be tried again; say whether the server is as it was before.

        After each of the ``tries``, another number of transfers comes before the next.
        """
        sdo, session = self.sdo, self._session
        sdo.record.in_case = False
        sdo.wire.timing.allowance = None
        self._minor = list(sdo.record.minor)
        self.tools.network.end()
        if sdo.record.early.has_crossed:
            sdo.channel.abort(sdo.line.latest or DEVICE_TYPE, AbortCode.GENERAL_ERROR)
            sdo.drain()
        leaving = leave(sdo, failed=True)
        # What crossed with the abort has met an idle server, which may refuse it.
        refused = all(isinstance(as_answer(stray), Abort) for stray in leaving.stray)
        booted = session.channel.boot_ups - self._boot_ups > self.tools.network.expected_boot_ups
        if leaving.afterwards is not Afterwards.IDLE or not refused or booted:
            return False
        session.restorer.restore(sdo, found=self._found)
        session.keep_late(self.result.case_id)
        shift(sdo, tries * tries)
        return True

    def follow(self, before: "CaseRun") -> None:
        """Go on as the next try of a case: what was wrong in the one before stays."""
        self.sdo.record.minor += before._minor
        self._begin = before._begin

    def give_up(self, error: BenchError) -> CaseResult:
        """End a case that could not be concluded; what it wrote stays listed."""
        result = self.result
        self.bench_error = error
        result.verdict, result.actual = Verdict.BENCH_ERROR, str(error)
        frames = self._session.frames_so_far()
        channels = self.sdo.record.channels
        trace = self._session.trace(frames, channels, aside=True, decisive=False)
        result.trace, result.decisive = trace
        self._session.end()
        return result

    def _leave(self, error: BaseException | None) -> Leaving:
        self._tidies = self.sdo.line.open is not None
        self._minor = list(self.sdo.record.minor)
        failed = error is not None or any(found.level is Level.MUST for found in self._minor)
        self.tools.network.end()
        return leave(self.sdo, failed=failed, proof=self._proof)

    def _judge(self, error: BaseException | None, asked: Request, leaving: Leaving | None) -> None:
        sdo, judgement = self.sdo, self._judgement
        stray = leaving.stray if leaving is not None else ()
        crossed = crossing(error, stray, asked) if stray else None
        if crossed is not None:
            # What was taken for the answer had come for something else.
            crossed.asked, error = sdo.wire.sent_before, crossed
        refused = confirmed_and_refused(error, leaving, asked) if leaving is not None else None
        error = refused or error
        misshapen = sdo.wire.misshapen
        if misshapen is not None and isinstance(error, Violation | ServerAborted):
            error = misshapen  # what it holds is no answer either
        if isinstance(error, Violation):
            lost = leaving is not None and leaving.afterwards is Afterwards.LOST
            sdo.wire.explain(error, lost=lost)
        judgement.ended(error, asked, own=error in sdo.record.own)
        for violation in self._minor:
            if violation.rule not in INCIDENTAL:
                judgement.breach(violation, asked, own=violation in sdo.record.own)
        if self.result.verdict is Verdict.PASS and sdo.record.notes:
            self.result.verdict = Verdict.INFO

    def _judge_leaving(self, asked: Request, leaving: Leaving) -> bool:
        """Judge what was found when the case was over; say whether that fails it."""
        result, sdo, session = self.result, self.sdo, self._session
        failed = result.verdict in FAILED
        result.afterwards = leaving.afterwards
        found = [*sdo.record.minor[len(self._minor) :]]
        late = sdo.wire.timing.answered_after
        if late is not None and leaving.stray:
            answer = in_words(leaving.stray[0])
            result.actual += f"; answered after {late * 1000:.0f} ms: {answer}"
        elif leaving.violation is not None:
            follows = result.cause and result.verdict is Verdict.NOT_TESTABLE
            if follows and leaving.afterwards is not Afterwards.LOST:
                # What comes behind the answer that was in the way comes of it.
                result.notes.append(f"also {leaving.violation}")
            elif self._tidies and leaving.violation.rule is ABORT_NOT_ANSWERED:
                # One for a reason of the server's own has crossed with that of the suite.
                if not all(leaves(stray, sdo.line.latest) for stray in leaving.stray):
                    self._judgement.aside(leaving.violation, asked)
            else:
                found.append(leaving.violation)
        lost = leaving.afterwards is Afterwards.LOST
        for violation in found:
            sdo.wire.explain(violation, lost=lost)
            if violation.rule not in INCIDENTAL:
                self._judgement.breach(violation, asked, own=lost)
        if session.channel.boot_ups - self._boot_ups > self.tools.network.expected_boot_ups:
            sdo.device.contents.current.clear()
            booted = Violation(NO_REBOOT, expected="no boot-up message", actual="the device booted")
            self._judgement.breach(booted, asked)
        return not failed and result.verdict in FAILED

    def _put_back(self, leaving: Leaving | None) -> None:
        session = self._session
        if leaving is None:
            return
        if leaving.afterwards is Afterwards.LOST:
            session.lost = True
            if session.revival is not None:
                process = session.revival.process
                self.result.output = process.tail()
                if process.ended:
                    self.result.notes.append(process.ended)
        else:
            # A reset brings back what is stored: that is verified, for the next reset to find it.
            # What a device has made of a request that it got wrong is for no other case to read.
            leaves_values = self._leaves_values and not self.tools.network.expected_boot_ups
            in_doubt = self.result.verdict in FAILED
            session.restorer.restore(self.sdo, leaves_values=leaves_values, in_doubt=in_doubt)
            session.keep_late(self.result.case_id)
            if session.restorer.gone:
                session.lost, self.result.afterwards = True, Afterwards.LOST
                expected = "an ordinary answer where a value is put back"
                gone = Violation(IDLE_AFTERWARDS, expected=expected, actual=NoAnswer())
                self._judgement.aside(gone, self.sdo.wire.last_sent)
        kept = MOST_INCIDENTS - len(session.whole_run.incidents)
        incidental = [found for found in self.sdo.record.minor if found.rule in INCIDENTAL]
        session.whole_run.incidents += [
            Incident(self.result.case_id, found) for found in incidental[:kept]
        ]
