"""Runs the cases of one bench: admits them, judges them, and counts the devices they stop."""

from collections import defaultdict
from contextlib import suppress
from functools import partial
from typing import NoReturn

import pytest

from conformance.bus.counters import lost_frames
from conformance.bus.errors import BenchError, DeviceLost, NotWritten, OtherDevice
from conformance.bus.link import Direction
from conformance.bus.stop import RunStopped
from conformance.plugin.attempts import Performed, begin_attempt, conclude_tries, is_told
from conformance.plugin.bench_opening import open_bench
from conformance.plugin.items import CaseFunction
from conformance.plugin.outcome import attach, end_with
from conformance.plugin.state import (
    CASE_RUN,
    EARLIER,
    RESULT,
    RunState,
    case_of,
    left_out,
)
from conformance.reporting.summary import device_properties
from conformance.run.bench import Bench
from conformance.run.case_run import CaseRun
from conformance.run.known_failures import account
from conformance.run.session import DeviceSession
from conformance.run.stopped_by import MOST_IN_A_ROW, Losses
from conformance.run.verdict import Afterwards, CaseResult, Verdict

# No further case can find anything about such a device.
BEHIND = "it answers each request when the next one comes"
# The case that judges late answers; if it was not selected, the run itself does.
LATE_ANSWERS = "run.no-late-response"


class CaseEngine:
    """The cases of a bench, from its opening to its end."""

    def __init__(self, config: pytest.Config, state: RunState) -> None:
        """Take the ``state``; nothing is opened yet."""
        self._config = config
        self._state = state
        self._losses: defaultdict[int, Losses] = defaultdict(Losses)
        # The case that each device has had last.
        self._latest: dict[int, Performed] = {}

    def open(self) -> str:
        """Open the bench; say why the run was stopped meanwhile, empty where it was not.

        If the bus cannot be opened, all devices are left out.
        """
        state = self._state
        try:
            open_bench(self._config, state)
        except BenchError as error:
            state.findings.bench_errors.append(error)
            other = isinstance(error, OtherDevice)
            why = "the values of another device were to be restored on it"
            state.leave_out_all(why if other else "the bus could not be opened")
        except RunStopped as stopped:
            state.leave_out_all(str(stopped))
            return str(stopped)
        return ""

    # A case

    def admit(self, item: pytest.Item) -> None:
        """Skip the cases of a device that is out of the run, and cases that would stop it again.

        Raises RunStopped.
        """
        self._state.stop.check()
        case = case_of(item)
        if (why := self._state.findings.out.get(case.node_id)) is not None:
            item.stash[RESULT] = left_out(case, Verdict.NOT_RUN, why)
        elif stopped := self._losses[case.node_id].why_not(case.case_id, case.risk):
            item.stash[RESULT] = left_out(case, Verdict.NOT_TESTABLE, stopped)
        else:
            return
        pytest.skip(f"{item.stash[RESULT].verdict.value}: {item.stash[RESULT].actual}")

    def end_stopped(self, item: pytest.Item) -> NoReturn:
        """End a case that a request to stop has interrupted; the run ends with it."""
        run = item.stash.get(CASE_RUN, None)
        stop = self._state.stop
        if run is not None and not stop.gives_up:
            with suppress(RunStopped):
                run.conclude(None)  # the values are put back all the same
        item.stash[RESULT] = left_out(
            case_of(item), Verdict.NOT_RUN, f"{stop.reason} during this case"
        )
        pytest.skip(f"{Verdict.NOT_RUN}: {stop.reason}")

    def judge(self, item: pytest.Item, run: CaseRun, error: BaseException | None) -> None:
        """Judge a case that ended by ``error``, if by any, and raise its outcome for pytest."""
        state = self._state
        session = state.session(case_of(item).node_id)
        again = partial(begin_attempt, session, case_of(item))
        before = partial(self._repeat, self._latest.get(case_of(item).node_id), session)
        run, error, result = conclude_tries(item, run, error, again, before)
        if isinstance(item, CaseFunction) and item.is_own:
            self._latest[item.node_id] = Performed(item, dict(item.given))
        self._look_after(item, session, result, run)
        account(result, state.options.deviations, strict=state.options.strict)
        result.notes += [
            f"run again: before it was {earlier.verdict} ({earlier.cause or earlier.actual})"
            for earlier in item.stash.get(EARLIER, ())
        ]
        item.stash[RESULT] = result
        attach(item, result)
        if result.case_id == LATE_ANSWERS:
            late = session.whole_run.late
            state.judged_late_answers[result.node_id] = len(late)
        if is_told(error) and error is not None and result.verdict is Verdict.NOT_TESTABLE:
            raise error
        end_with(result, run.bench_error or error, strict=state.options.strict)

    def _repeat(self, before: Performed | None, session: DeviceSession) -> str:
        """Perform a case once more, unless it may stop the device; return its id."""
        if before is None or before.item.risk is not None:
            return ""
        return before.repeat(partial(begin_attempt, session, case_of(before.item)))

    def _look_after(
        self, item: pytest.Item, session: DeviceSession, result: CaseResult, run: CaseRun
    ) -> None:
        """Bring a lost device back; where nothing can, it is out of the run."""
        losses = self._losses[result.node_id]
        wrongly = result.afterwards is Afterwards.ANSWERS_WRONGLY
        wedged = losses.is_wedged(answers_wrongly=wrongly) and session.revival is not None
        if not session.lost:
            losses.survived(result.case_id)
        if not session.lost and not wedged:
            if why := session.channel.pace.unsound:
                self._give_up(result, BEHIND if session.device.learned.is_behind else why)
            return
        sent = [each.frame for each in session.frames if each.direction is Direction.SENT]
        cause = "it answered wrongly whatever it was asked"
        if session.lost:
            cause = losses.add(result.case_id, case_of(item).risk, sent)
        try:
            why = session.revive()
        except BenchError as error:
            why = str(error)
        if not why and losses.is_hopeless:
            why = f"it was lost in {MOST_IN_A_ROW} different cases in a row"
        if not why:
            result.notes.append(f"the device was lost ({cause}), and has been brought back")
            return
        self._state.findings.bench_errors.append(session.loss())
        self._state.findings.out[result.node_id] = f"lost in {result.case_id}; {why}"

    def _give_up(self, result: CaseResult, why: str) -> None:
        """Take a device out of the run that answers, but not in a way that could be tested."""
        findings = self._state.findings
        findings.bench_errors.append(
            DeviceLost(f"Node {result.node_id} was given up after {result.case_id}: {why}.")
        )
        findings.out[result.node_id] = f"given up after {result.case_id}: {why}"

    # The end

    def close(self) -> None:
        """Close the bench, and report the findings outside the cases."""
        state = self._state
        for node_id, losses in self._losses.items():
            if node_id not in state.findings.out:
                state.findings.stopped += losses.lines()
        if state.bench is not None:
            self._close(state.bench)
        if state.values is not None:
            state.values.close(state.findings)
        if state.log is not None and (trouble := state.log.close()):
            state.findings.bench_errors.append(NotWritten(trouble))

    def _close(self, bench: Bench) -> None:
        state = self._state
        try:
            bench.close()
        except BenchError as error:
            state.findings.bench_errors.append(error)
        except RunStopped:
            pass  # values that are not restored are listed
        counted = bench.counted()
        if counted:
            counts = ", ".join(f"{name} {count}" for name, count in counted.items())
            state.findings.notes.append(f"the interface has counted since the run began: {counts}")
        if errors := bench.errors():
            state.findings.notes.append(
                f"the controller has reported errors on the bus since the run began: {errors}"
            )
        for node_id, device in bench.sessions.items():
            # Cases may have found out which services it refuses by its state.
            alone = len(state.options.node_ids) == 1
            state.findings.properties |= device_properties(device.device, alone=alone)
            judged, known = state.judged_late_answers[node_id], state.options.deviations
            state.findings.close(device, judged=judged, known=known, lost=lost_frames(counted))
