"""Which cases a run has, and in which order."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from conformance.device.eds_listing import Listing
from conformance.device.effort import Effort
from conformance.plugin.items import (
    CaseFunction,
    make_items,
    make_module,
    ordered,
    parametrize,
)
from conformance.plugin.marks import check_expression, mark
from conformance.plugin.quick import beyond_quick, quick_properties
from conformance.plugin.selection import NAMED, is_beside
from conformance.plugin.state import STATE, RunState, is_left_to
from conformance.plugin.time_left import say
from conformance.run.case import case_info


class Collecting:
    """The hooks of the collection.

    They are registered behind all plugins that configure themselves, and so are called before
    them: ``--stepwise`` skips the cases before a failure, and has to see the cases in order.
    A plugin that asks to reorder tests first, as pytest-randomly does, comes before them.
    """

    def pytest_collect_file(
        self, file_path: Path, parent: pytest.Collector
    ) -> pytest.Module | None:
        """Collect the suite's own files also if a project has other names for its test files."""
        patterns = parent.config.getini("python_files")
        if parent.session.isinitpath(file_path) or any(map(file_path.match, patterns)):
            return None  # pytest does
        return make_module(file_path, parent)

    def pytest_pycollect_makemodule(
        self, module_path: Path, parent: pytest.Collector
    ) -> pytest.Module | None:
        """Collect the suite's own files under stable names."""
        return make_module(module_path, parent)

    @pytest.hookimpl(tryfirst=True)
    def pytest_pycollect_makeitem(
        self, collector: pytest.Collector, obj: object
    ) -> list[CaseFunction] | None:
        """Turn marked functions into cases, some only in a thorough run or where they are named."""
        info = case_info(obj)
        if info is None:
            return None
        state = collector.config.stash.get(STATE, None)
        if info.thorough and not _is_asked_for(collector, state):
            if state is not None:
                state.reserved.append(info)
            return []
        listings = {0: Listing()} if state is None else state.options.run.all_listings
        alone = state is None or len(state.options.node_ids) == 1
        items = make_items(collector, obj, listings, alone=alone)
        mark(items or ())
        return items

    @pytest.hookimpl(tryfirst=True)
    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Give the cases their variations, before those of other plugins."""
        parametrize(metafunc)

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Choose and order the cases; a worker keeps its own.

        A list of cases is read, and keeps each file together.
        """
        state = config.stash.get(STATE, None)
        if state is not None:
            check_expression(config, items)
        named = config.stash.get(NAMED, {})
        _deselect(config, items, [item for item in items if is_beside(item, named)])
        if state is not None and state.options.effort is Effort.HASTE:
            left_out = beyond_quick(items, state.options)
            state.findings.properties |= quick_properties(items, left_out, state.options)
            _deselect(config, items, left_out)
        items[:] = ordered(items, as_files=config.option.collectonly)
        if state is not None and state.options.share.worker:
            items[:] = [
                item for place, item in enumerate(items) if is_left_to(state.options, item, place)
            ]

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Where -k chooses nothing, say so of cases that a thorough run would have."""
        state = session.config.stash.get(STATE, None)
        if state is None or session.items:
            return
        words = re.findall(r"[\w.-]+", session.config.option.keyword)
        names = [info.rule.id for info in state.reserved]
        if chosen := [name for name in names if name.startswith(tuple(words))]:
            say(session.config, f"only --sdo-thorough, or an argument, runs {', '.join(chosen)}")


def _is_asked_for(collector: pytest.Collector, state: RunState | None) -> bool:
    """Say whether the cases of a file are run that are not for any run."""
    thorough = state is not None and state.options.effort is Effort.THOROUGH
    return thorough or collector.session.isinitpath(collector.path)


def _deselect(
    config: pytest.Config, items: list[pytest.Item], left_out: Sequence[pytest.Item]
) -> None:
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        gone = set(left_out)
        items[:] = [item for item in items if item not in gone]
