"""Which cases come before all others in a run: those that show most in a tenth of its requests."""

from collections.abc import Collection, Mapping, Sequence
from functools import cache

from conformance.faults.catalogue import build_node
from conformance.plugin import case_order
from conformance.reference.built_in_eds import listing_of
from conformance.reporting.rule_listing import scripted_cases
from conformance.run.risks import Kind

# This part of all requests is sent by the cases that come early, and no more than this by each.
EARLY, EARLY_EACH = 0.1, 0.01


@cache
def risks() -> dict[str, Kind]:
    """Return the cases of the built-in device by their ids, and what they risk."""
    listing = listing_of(build_node(None, 5))
    return {
        case_id: risk.kind if (risk := case.risk_of(arguments)) else Kind.ORDINARY
        for case in scripted_cases()
        for case_id, arguments in case.variations(listing)
    }


def early_cases(
    order: Sequence[str],
    quick: Collection[str],
    usual: Mapping[str, Mapping[str, float]],
    costs: Mapping[str, int],
    total: int,
) -> set[str]:
    """Return the cases that come before all others, but for those of frames that no client sends.

    They are those of a quick run, which shows the most at its requests, the cheapest ones for what
    it does not show, and more in their order.
    """
    early = {case for case in quick if risks()[case] in case_order.FAMILIAR}
    left = EARLY * total - sum(costs[case] for case in early)
    familiar = [
        case for case in order if case not in early and risks()[case] in case_order.FAMILIAR
    ]
    missing = [found for found in usual.values() if found.keys().isdisjoint(early)]
    for case in sorted(familiar, key=costs.__getitem__):
        if costs[case] <= left and any(case in found for found in missing):
            left -= costs[case]
            early.add(case)
            missing = [found for found in missing if case not in found]
    for case in familiar:
        if case not in early and costs[case] <= min(left, EARLY_EACH * total):
            left -= costs[case]
            early.add(case)
    return early
