"""The numbers of cases that a draft of device.toml states are those of runs that lack all of it."""

import json
import re
from collections import Counter

import pytest
from plugin_runs import self_test, the_report

from conformance.device.protected_objects import PERMISSIONS
from conformance.proposing.additions import ALL_CASES, BY_OBJECT
from conformance.proposing.additions import PERMISSIONS as SAID
from conformance.reference.built_in_device import REFERENCE_OBJECTS

pytest_plugins = ["pytester"]

# What a case says that lacks an object, by how the draft calls that.
KINDS = {
    "needs a writable string or domain": "a string or domain",
    "needs a writable number of 4 bytes": "a number of 4 bytes",
    "needs a writable number:": "a number of 4 bytes",
    "needs a writable number of 2 bytes": "a number of 2 bytes",
    "needs a writable number of 1 byte": "a number of 1 byte",
    "needs a writable object": "any object",
    "needs a writable number of 8 bytes": "a number of 8 or 3 bytes",
}

# What is left out needs no permission, and moves more than all others. Of the matrix all but this
# is left out as well.
CHEAP = "not beyond and not 4097 and (not matrix or read-only or missing or other-node)"


@pytest.fixture(autouse=True)
def _nothing_is_permitted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conformance.plugin.options.PERMISSIONS", frozenset())


def lacking(pytester: pytest.Pytester, *arguments: str) -> tuple[list[str], int]:
    """Return what keeps cases from being run, and how many there are, those left out included."""
    run = self_test(pytester, "--sdo-simulated", "--sdo-no-page", *arguments)
    lines = (the_report(pytester) / "results.jsonl").read_text("utf-8").splitlines()
    results = [json.loads(line)["result"] for line in lines if '"record": "case"' in line]
    assert results
    count = len(results) + run.parseoutcomes().get("deselected", 0)
    return [one["actual"] for one in results if one["verdict"] == "not testable"], count


def is_about(said: int, counted: int) -> bool:
    return abs(said - counted) <= max(said * 0.3, 4)


def test_the_cases_that_need_a_permission(pytester: pytest.Pytester) -> None:
    objects = [
        f"--sdo-object={one.mux.index:04X}={one.data_type.name},{one.access}"
        for one in REFERENCE_OBJECTS
        if one.data_type is not None
    ]
    reasons, count = lacking(pytester, *objects, "-k", CHEAP)
    named = re.compile(r"--sdo-allow=([a-z-]+)|(read-only-probes) = true")
    counted = Counter(
        found[1] or found[2] for reason in reasons if (found := named.search(reason)) is not None
    )
    assert is_about(ALL_CASES, count)
    assert counted.keys() <= PERMISSIONS == {one.name for one in SAID}
    for permission in SAID:
        assert is_about(permission.cases, counted[permission.name]), (permission, counted)


def test_the_cases_that_need_an_object(pytester: pytest.Pytester) -> None:
    reasons, _ = lacking(pytester, "--sdo-object=1000=unsigned32,const")
    counted = Counter(
        what for reason in reasons for start, what in KINDS.items() if reason.startswith(start)
    )
    for what, said in BY_OBJECT.items():
        assert is_about(said, counted[what]), (what, counted)
