"""Which known deviations the cases of a run say something of."""

from collections.abc import Collection, Sequence

import pytest

from conformance.device.known_deviations import unknown_case
from conformance.plugin.state import RunState, case_of
from conformance.run.known_failures import Scope
from conformance.sdo.rules import RULES


class DeviationScope:
    """The hooks of the collection in a process that talks to devices."""

    def __init__(self, state: RunState) -> None:
        """Take the state of the run."""
        self._state = state
        self._scope: Scope | None = None

    # Before anything is deselected.
    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Hold the known deviations to the cases and rules that there are."""
        options = self._state.options
        if not options.deviations or not options.run.node_ids:
            return
        some = config.args_source is pytest.Config.ArgsSource.ARGS or config.getoption(
            "lf", default=False
        )
        cases = [(case.case_id, case.tested_rules) for case in map(case_of, items)]
        reserved = [
            (case_id, info.tested_rules)
            for info in self._state.reserved
            for case_id, _ in info.variations()
        ]
        self._scope = Scope(options.deviations, [tested for _, tested in (*cases, *reserved)])
        if some:
            self._state.findings.partly += map(str, self._scope.shared)
            return
        self._note_left_out(reserved)
        unknown = unknown_case(
            options.deviations,
            (case_id for case_id, _ in (*cases, *reserved)),
            {rule.id for rule in RULES}.union(*[tested for _, tested in cases]),
        )
        if unknown is None:
            return
        if not options.share.worker:
            raise pytest.UsageError(unknown)
        self._state.findings.wrong_use = unknown
        self._state.leave_out_all("wrong use")

    def pytest_deselected(self, items: Sequence[pytest.Item]) -> None:
        """Note which known deviations a selection says nothing of: it leaves out their cases."""
        self._note_left_out([(case.case_id, case.tested_rules) for case in map(case_of, items)])

    def _note_left_out(self, cases: Collection[tuple[str, Collection[str]]]) -> None:
        if self._scope is None:
            return
        self._state.findings.partly += [
            str(known)
            for known in self._scope.shared
            if any(self._scope.is_about(known, case_id, tested) for case_id, tested in cases)
        ]
