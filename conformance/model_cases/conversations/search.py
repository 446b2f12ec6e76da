"""The search of a case: the conversation that failed the last time, then random ones."""

import time

from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.dialogue.dialogue import Dialogue
from conformance.model_cases.conversations.conversation import Conversation, Kind
from conformance.model_cases.conversations.device_objects import DeviceObjects, survey
from conformance.model_cases.conversations.plan import SearchPlan
from conformance.model_cases.conversations.store import FailingStore
from conformance.model_cases.conversations.trials import Failure, Trials
from conformance.run.case_run import CaseRun
from conformance.run.session import DeviceSession


class ConversationSearch:
    """The search of one case on one device."""

    def __init__(
        self, session: DeviceSession, run: CaseRun, plan: SearchPlan, store: FailingStore
    ) -> None:
        """``store`` has what failed the last time."""
        self._session = session
        self._run = run
        self._plan = plan
        self._store = store

    def begin_again(self, run: CaseRun) -> None:
        """Take the next try of the case."""
        self._run = run

    def run(self, kind: Kind, on: Dialogue | None = None) -> None:
        """Try what failed the last time, then random conversations of a kind.

        They run ``on`` a further channel where it is given.

        Raises Violation, with the frames of the shortest failing conversation as those of the
        case; NotTestable without a string or domain, or without examples; BenchError.
        """
        if not self._plan.examples:
            raise NotTestable(
                "no random conversations were asked for: leave out --sdo-examples=0",
                Missing(Lack.EXAMPLES),
            )
        # hypothesis takes long to import, and a run of chosen cases mostly draws nothing.
        from conformance.model_cases.conversations.hunt import Hunt

        sdo, result = on or self._run.sdo, self._run.result
        objects = survey(sdo)
        trials = Trials(self._session, sdo, objects)
        hunt = Hunt(trials, self._plan, sdo.info)
        begin = time.monotonic()
        failure = self._failed_before(trials, objects) or hunt.run(kind, objects, result.case_id)
        result.progress = (
            f"{hunt.done} of {self._plan.examples} examples in {time.monotonic() - begin:.1f} s"
        )
        if failure is not None:
            sdo.info(self._kept(failure.conversation))
            self._session.show(failure.frames)
            raise failure.violation
        if trials.bench_error is not None:
            raise trials.bench_error
        if hunt.done < self._plan.examples:
            sdo.info(f"{result.progress}, which is as long as it may take")

    def _kept(self, conversation: Conversation) -> str:
        """Keep what has failed for the next run; say where, or why that cannot be."""
        try:
            self._store.save(conversation)
        except OSError as error:
            return f"it could not be kept for the next run: {error}"
        return f"the next run tries it first; it is kept in {self._store.path}"

    def _failed_before(self, trials: Trials, objects: DeviceObjects) -> Failure | None:
        conversation = self._store.load()
        if conversation is None:
            return None
        gone = [one.target for one in conversation if not objects.offers(one)]
        if gone:
            self._run.sdo.info(
                f"a conversation that failed before was not tried: {gone[0]} is gone, or is not to "
                f"be used for it; it is kept in {self._store.path}"
            )
            return None
        failure = trials.attempt(conversation)
        if failure is not None:
            self._run.sdo.info("this conversation has failed before, and was tried first")
        elif not trials.ended:
            self._store.remove()
        return failure
