"""Tries a case again if its failure may have been chance.

The server may end a running transfer at any time; the bus may have lost, repeated or swapped a
frame.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import pytest

from conformance.bus.errors import BenchError
from conformance.bus.stop import RunStopped
from conformance.device.effort import TRIES_OF_CASE, TRIES_OF_TRANSFER
from conformance.device.not_testable import NotTestable
from conformance.dialogue.server_aborts import Way, is_systematic
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.plugin.items import CaseFunction
from conformance.plugin.state import CASE_RUN, ItemCase
from conformance.plugin.suite_errors import conclude
from conformance.run.case_run import CaseRun, begin_case
from conformance.run.frame_loss import Stumble, is_certain
from conformance.run.second_try import doubt, stumble, take_back
from conformance.run.session import DeviceSession
from conformance.run.verdict import BREACHES, CaseResult

# Services whose cases are generated.
GENERATED = ("matrix", "state pairs")


def begin_attempt(session: DeviceSession, case: ItemCase) -> CaseRun:
    """Begin a case on a device."""
    generated = case.service in GENERATED
    run = begin_case(
        session,
        case.case_id,
        case.service,
        case.rule,
        case.cites,
        generated=generated,
        own=case.own,
    )
    run.result.name, run.result.state, run.result.stimulus = case.name, case.state, case.stimulus
    return run


def try_again(
    item: pytest.Item,
    run: CaseRun,
    error: BaseException | None,
    begin_again: Callable[[], CaseRun],
) -> tuple[CaseRun, BaseException | None]:
    """Return the try of a case that counts, and the error that ended it; ``error`` ended the first.

    A case of the suite is tried again while the server ends it early, some times at most. If each
    try ended at another place, the case gets no verdict on the device.
    """
    if not (isinstance(item, CaseFunction) and item.is_own):
        return run, error
    ways: list[Way] = []
    while (way := run.way_left(error)) is not None:
        ways.append(way)
        if is_systematic(ways):
            return run, error
        try:
            if not run.retreat(len(ways)):
                return run, error
            if len(ways) == TRIES_OF_TRANSFER:
                return run, NotTestable(_in_words(ways))
            before, run = run, begin_again()
        except BenchError:
            return run, error  # it is met again when the case is concluded
        run.follow(before)
        item.stash[CASE_RUN] = run
        error = call_case(item, run)
    if ways:
        run.sdo.info(f"{_in_words(ways)}; the case was repeated")
    return run, error


def conclude_tries(
    item: pytest.Item,
    run: CaseRun,
    error: BaseException | None,
    begin_again: Callable[[], CaseRun],
    before: Callable[[], str] = lambda: "",
) -> tuple[CaseRun, BaseException | None, CaseResult]:
    """Conclude a case that was ended by ``error``, if by any; return the try that counts.

    A failure that a lost frame may explain is tried again from the start: values can be read again,
    and written ones are restored. The case fails once the failure is certain. If it does not fail
    again alone, it is tried once more behind the previous case; ``before`` performs that case and
    returns its id.
    """
    run, error = try_again(item, run, error, begin_again)
    result = _conclude(item, run, error)
    tries: list[Stumble] = []
    failed = result
    while isinstance(item, CaseFunction) and item.is_own and (way := stumble(run)) is not None:
        tries.append(way)
        if is_certain(tries):
            return run, error, result
        failed = result
        take_back(run)
        if len(tries) == TRIES_OF_CASE:
            break
        run = begin_again()
        item.stash[CASE_RUN] = run
        run, error = try_again(item, run, call_case(item, run), begin_again)
        result = _conclude(item, run, error)
    if not tries or (result.verdict in BREACHES and len(tries) < TRIES_OF_CASE):
        return run, error, result
    if isinstance(item, CaseFunction) and len(tries) == 1 and result.verdict not in BREACHES:
        shown = run.session.frames
        again = _behind(item, before, begin_again, tries[0])
        if again is not None:
            return again
        item.stash[CASE_RUN] = run
        run.session.show(shown)
    doubt(run, failed, tries[-1])
    return run, error, result


def _behind(
    item: CaseFunction,
    before: Callable[[], str],
    begin_again: Callable[[], CaseRun],
    stumbled: Stumble,
) -> tuple[CaseRun, BaseException | None, CaseResult] | None:
    """Try a case behind the one before it; return the try if it fails as it did, else None.

    Then the failure depends on the previous case, and no frame was lost.
    """
    name = before()
    if not name:
        return None
    run = begin_again()
    item.stash[CASE_RUN] = run
    error = call_case(item, run)
    result = _conclude(item, run, error)
    if result.verdict not in BREACHES or result.cause != stumbled.cause:
        take_back(run)
        return None
    result.notes.append(f"the case fails behind {name} each time, and does not fail by itself")
    return run, error, result


@dataclass(frozen=True, slots=True)
class Performed:
    """A case of the suite that was performed, with the arguments that it was ``given``."""

    item: CaseFunction
    given: dict[str, object]

    def repeat(self, begin_again: Callable[[], CaseRun]) -> str:
        """Perform the case once more for its effects; return its id, empty if it could not be.

        Its breaches have been judged before.
        """
        run = begin_again()
        self.item.given.update(self.given)
        try:
            run.conclude(call_case(self.item, run))
        except BenchError:
            return ""
        finally:
            self.item.given.clear()
        take_back(run)
        return self.item.case_id


def _conclude(item: pytest.Item, run: CaseRun, error: BaseException | None) -> CaseResult:
    return conclude(item, run, NotTestable(str(error)) if is_told(error) else error)


def is_told(error: BaseException | None) -> bool:
    """Say whether a test has said itself that it cannot be run."""
    return isinstance(error, pytest.skip.Exception | pytest.xfail.Exception)


def call_case(item: CaseFunction, run: CaseRun) -> BaseException | None:
    """Call the function of a case of the suite with the tools of a try; return the error.

    Raises RunStopped.
    """
    given = item.given
    for tool in fields(run.tools):
        if tool.name in given:
            given[tool.name] = getattr(run.tools, tool.name)
    for value in given.values():
        if isinstance(value, ConversationSearch):
            value.begin_again(run)
    try:
        item.obj()
    except RunStopped:
        raise
    except (KeyboardInterrupt, pytest.exit.Exception):
        run.conclude(None)  # the values are put back all the same
        raise
    except BaseException as error:
        # Also what derives from BaseException alone, as the outcomes of pytest do.
        return error
    return None


def _in_words(ways: list[Way]) -> str:
    codes = ", ".join(dict.fromkeys(f"{way.abort.code:08X}h" for way in ways))
    times = "once" if len(ways) == 1 else f"in each of {len(ways)} tries, not at the same place"
    if 1 < len(ways) < TRIES_OF_TRANSFER:
        times = f"in {len(ways)} tries"
    return f"the server aborted a running transfer {times} ({codes}), which is always allowed"
