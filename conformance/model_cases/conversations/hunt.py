"""Looks for a conversation that a device gets wrong, and for the shortest one like it.

hypothesis draws conversations and shrinks the first that fails. It tells failures apart by the
type of the exception, so each rule gets one of its own: what is left breaks the same rule. Both
are bounded in time, and the second in answers; after that nothing is sent any more, and the report
says how far it came. A failure of which other cases have told the cause stays as long as it is.
"""

import time
from collections.abc import Callable
from math import inf

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import Flaky

from conformance.model_cases.conversations.conversation import Conversation, Kind
from conformance.model_cases.conversations.device_objects import DeviceObjects
from conformance.model_cases.conversations.plan import SearchPlan
from conformance.model_cases.conversations.strategies import drawn
from conformance.model_cases.conversations.trials import Failure, Trials
from conformance.sdo.rules import Rule

# They mind examples that are slow or large: a device is as slow as it is.
NO_HEALTH_CHECKS = list(HealthCheck)


class Broken(Exception):
    """A conversation broke a rule; each rule has a subclass."""

    def __init__(self, failure: Failure) -> None:
        """Keep what failed."""
        super().__init__(str(failure.violation))
        self.failure = failure


class Hunt:
    """One search by hypothesis: what was tried, and what came of it."""

    def __init__(self, trials: Trials, plan: SearchPlan, note: Callable[[str], None]) -> None:
        """``note`` takes remarks on what was found."""
        self.done = 0
        self._trials = trials
        self._plan = plan
        self._note = note
        self._deadline = 0.0
        self._most_answers = inf
        self._previous: Conversation = ()
        # Once one has failed: what came of each. hypothesis repeats some, and counts on the same.
        self._outcomes: dict[Conversation, Failure | None] = {}
        self._settled: Failure | None = None
        self._kinds: dict[Rule, type[Broken]] = {}

    def run(self, kind: Kind, objects: DeviceObjects, case_id: str) -> Failure | None:
        """Draw conversations of a kind; return the shortest failure that was found."""
        self._deadline = time.monotonic() + self._plan.search_seconds

        @seed(f"{self._plan.seed}/{case_id}")
        @settings(
            max_examples=self._plan.examples,
            phases=(Phase.generate, Phase.shrink),
            database=None,
            deadline=None,
            report_multiple_bugs=False,
            print_blob=False,
            suppress_health_check=NO_HEALTH_CHECKS,
        )
        @given(drawn(kind, objects))
        def examine(conversation: Conversation) -> None:
            self._examine(conversation)

        try:
            examine()
        except Broken as broken:
            return self._confirmed(broken.failure)
        except Flaky:
            # hypothesis has seen a conversation fail, and then not: the device changes its mind.
            failed = [failure for failure in self._outcomes.values() if failure is not None]
            if not failed:
                raise
            return self._confirmed(min(failed, key=lambda failure: len(failure.conversation)))
        return self._settled

    def _examine(self, conversation: Conversation) -> None:
        """Try one conversation; raises Broken for one that fails."""
        if conversation not in self._outcomes:
            if self._settled or self._is_over():
                return
            if not self._outcomes:
                self._look(conversation)
            else:
                self._outcomes[conversation] = self._trials.attempt(conversation)
        failure = self._outcomes.get(conversation)
        if failure is not None:
            kind = type("Broken", (Broken,), {"__doc__": failure.rule.sentence})
            raise self._kinds.setdefault(failure.rule, kind)(failure)

    def _look(self, conversation: Conversation) -> None:
        """Try a conversation as long as none has failed."""
        failure = self._trials.attempt(conversation)
        self.done += not self._trials.ended or failure is not None
        if failure is None:
            self._previous = conversation
            return
        self._note(f"found by example {self.done} of {self._plan.examples}")
        if failure.is_known:
            self._settled = failure
            return
        self._deadline = time.monotonic() + self._plan.shrink_seconds
        self._most_answers = self._trials.answers + self._plan.shrink_answers
        again = self._trials.attempt(conversation, failure.rule)
        if again is not None:
            self._outcomes[conversation] = again
        else:
            self._settled = self._with_previous(failure)

    def _is_over(self) -> bool:
        return time.monotonic() > self._deadline or self._trials.answers > self._most_answers

    def _with_previous(self, failure: Failure) -> Failure:
        """Repeat a failure that takes more than its own conversation: what went before, or luck.

        Then single transfers are left out as long as it fails like that.
        """
        shortest = self._trials.attempt(self._previous + failure.conversation, failure.rule)
        if shortest is None:
            self._note("it did not fail again when it was repeated")
            return failure
        position = 0
        while position < len(shortest.conversation) and not self._is_over():
            whole = shortest.conversation
            rest = whole[:position] + whole[position + 1 :]
            shorter = self._trials.attempt(rest, failure.rule)
            shortest, position = (shorter, position) if shorter else (shortest, position + 1)
        return shortest

    def _confirmed(self, failure: Failure) -> Failure:
        """Repeat the shortest failure, to know whether the server still does it."""
        again = self._trials.attempt(failure.conversation, failure.rule)
        if again is None and not self._trials.ended:
            self._note("it did not fail again when it was repeated")
        return again or failure
