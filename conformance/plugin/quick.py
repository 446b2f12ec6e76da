"""--sdo-quick: the cases of each device that show most in few requests; it counts the others."""

from collections import Counter
from collections.abc import Iterable, Sequence

import pytest

from conformance.plugin.case_order import quick_choice
from conformance.plugin.items import CaseFunction, judges_run
from conformance.plugin.options import Options
from conformance.reporting.summary import QUICK
from conformance.run.bench import RunSettings


def beyond_quick(items: Iterable[pytest.Item], options: Options) -> list[pytest.Item]:
    """Return the cases that a quick run leaves out: no tests of the user, no cases on the run."""
    cases = [each for each in items if isinstance(each, CaseFunction) and not judges_run(each)]
    chosen = {
        node_id: quick_choice(
            {case.case_id: case.service for case in cases if case.node_id == node_id},
            writes=_may_write(options.run, node_id),
        )
        for node_id in {case.node_id for case in cases}
    }
    return [case for case in cases if case.is_own and case.case_id not in chosen[case.node_id]]


def _may_write(run: RunSettings, node_id: int) -> bool:
    named = any(known.access.writable for known in run.permits.named)
    return named or bool(run.permits.allowed(run.all_listings[node_id].entries))


def _of_device(items: Iterable[pytest.Item], node_id: int) -> list[CaseFunction]:
    return [each for each in items if isinstance(each, CaseFunction) and each.node_id == node_id]


def quick_properties(
    items: Sequence[pytest.Item], left_out: Sequence[pytest.Item], options: Options
) -> dict[str, str]:
    """Say of each device how many cases are left out, for the reports."""
    said = {}
    for node_id in options.run.node_ids:
        own = _of_device(items, node_id)
        gone = _of_device(left_out, node_id)
        services = Counter(each.service for each in gone)
        listed = ", ".join(f"{service} {number}" for service, number in services.most_common())
        prefix = "" if len(options.node_ids) == 1 else f"node-{node_id}."
        text = f"{len(own) - len(gone)} of {len(own)} cases; left out: {listed or 'none'}"
        said[f"{prefix}{QUICK}"] = text
    return said
