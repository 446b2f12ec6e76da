"""What the table of worth says holds for the cases and the faults that there are."""

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from catches import candidates
from early import risks

from conformance.device.effort import REQUESTS_OF_SMALL_CASE
from conformance.faults.catalogue import faults
from conformance.faults.registry import About, Defect
from conformance.plugin import case_order
from conformance.plugin.case_order import FAMILIAR, place_in_run, quick_choice, table
from conformance.run.risks import Kind

# Of the faults that cases show where the server declares no time-out; one shows before the first.
# A quick run sends 560 of its requests beside the cases, most of them before the first.
MOST, MOST_OF_QUICK = 0.94, 0.93
BEFORE_CASES = "dies-at-once"
SHOWN = {
    fault.name: fault
    for fault in faults()
    if not (fault.timed or fault.thorough) and fault.name != BEFORE_CASES
}


def services() -> dict[str, str]:
    """Return what each case is about, by the beginning of its id; none judges the whole run."""
    stems = {case_id: case_id.partition(".")[0] for case_id in risks()}
    return {case_id: stem for case_id, stem in stems.items() if stem != "run"}


def kept() -> dict[str, Any]:
    text = Path(case_order.__file__).with_suffix(".json").read_text("utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def caught_by(cases: set[str]) -> set[str]:
    return {fault for case in cases for fault in table()[case].faults} & SHOWN.keys()


def test_each_case_is_one_that_there_is() -> None:
    assert table().keys() <= risks().keys()


def test_each_case_and_each_fault_stands_there_once() -> None:
    text = Path(case_order.__file__).with_suffix(".json").read_text("utf-8")
    pairs: list[tuple[str, object]] = json.loads(text, object_pairs_hook=list)
    cases: list[tuple[str, object]] = dict(pairs)["cases"]  # type: ignore[assignment]
    assert max(Counter(name for name, _ in cases).values()) == 1
    assert max(Counter(kept()["faults"]).values()) == 1


def test_each_fault_is_in_it() -> None:
    """Run ``tests/faults/worth.py`` when there is a new one; not if it takes a thorough run."""
    assert set(kept()["faults"]) == {fault.name for fault in faults() if not fault.thorough}


def test_the_first_tenth_of_a_run_shows_nearly_all_faults() -> None:
    """By what the table says each case catches, and by the requests of a run in this order."""
    early = {
        case
        for case in table().keys() & services().keys()
        if not place_in_run(case, risks()[case])[0]
    }
    assert kept()["early"] <= 0.1 * kept()["requests"]
    found = caught_by(early)
    assert len(found) >= MOST * len(SHOWN), len(found) / len(SHOWN)


def test_nothing_that_no_client_sends_comes_early() -> None:
    late = {case_id for case_id, kind in risks().items() if kind not in FAMILIAR}
    assert late
    assert all(place_in_run(case_id, risks()[case_id])[0] for case_id in late)


# A quick run


def test_a_quick_run_shows_nearly_all_faults() -> None:
    """How many requests it sends is counted in ``tests/plugin/test_plugin_quick.py``."""
    chosen = quick_choice(services(), writes=True)
    found = caught_by(chosen)
    assert len(found) >= MOST_OF_QUICK * len(SHOWN), len(found) / len(SHOWN)


def test_a_quick_run_shows_each_kind_of_fault() -> None:
    found = [SHOWN[name] for name in caught_by(quick_choice(services(), writes=True))]
    assert {fault.defect for fault in found} == set(Defect)
    assert {fault.about for fault in found} == set(About)


def test_a_quick_run_has_a_case_of_each_service() -> None:
    chosen = quick_choice(services(), writes=True)
    few = {case_id for case_id, each in table().items() if each.requests <= REQUESTS_OF_SMALL_CASE}
    known = {services()[case_id] for case_id in few & services().keys()}
    assert {services()[case_id] for case_id in chosen} == known


def test_where_nothing_may_be_written_others_take_the_places() -> None:
    chosen = quick_choice(services(), writes=False)
    assert not any(table()[case_id].writes for case_id in chosen)
    readable = {case for case in services().keys() & table().keys() if not table()[case].writes}
    assert len(caught_by(chosen)) >= MOST * len(caught_by(readable)) > 100


def test_a_device_without_the_first_choice_gets_the_next() -> None:
    """What another case catches too is found all the same, but for what that one has no room."""
    lacking = max(table(), key=lambda case_id: len(table()[case_id].faults))
    rest = {case_id: service for case_id, service in services().items() if case_id != lacking}
    others = (services().keys() & table().keys()) - {lacking}
    wanted = table()[lacking].faults & caught_by(others)
    assert wanted
    found = wanted & caught_by(quick_choice(rest, writes=True))
    assert len(found) >= 0.9 * len(wanted)


def test_nothing_to_choose_from() -> None:
    assert quick_choice({}, writes=True) == set()


# How the table is made


def test_few_variations_are_measured() -> None:
    costs = {f"upload.size[{size}]": 5 for size in range(30)} | {"upload.long": 1000, "matrix.x": 5}
    found = candidates(costs)
    assert 0 < len(found) <= 3
    assert all(case.startswith("upload.size") for case in found)


@pytest.mark.parametrize("case_id", ["of.my-own", "matrix.idle[40h]"])
def test_what_is_not_known_keeps_its_place_behind_what_is(case_id: str) -> None:
    place = place_in_run(case_id, Kind.ORDINARY)
    known = [place_in_run(each, Kind.ORDINARY) for each in table()]
    assert all(place > each for each in known)
