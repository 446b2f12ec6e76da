"""A run takes so many requests at most: of very many objects it leaves some out, and says so."""

import json
from collections import Counter
from math import ceil
from types import SimpleNamespace
from typing import cast

import pytest
from plugin_runs import case_ids, parsed, self_test, the_report

from conformance.plugin import allowance
from conformance.plugin.items import CaseFunction
from conformance.plugin.options import Options
from conformance.plugin.worth import table
from conformance.reporting.workload import work_of
from conformance.run import first_reading, further

pytest_plugins = ["pytester"]

ENOUGH = 6
CHOSEN = ("--sdo-simulated", "-k", "test_object_dictionary.py or specifier.unknown")
# What the run needs of it before its first case, and behind what it may leave out.
MOST, BEHIND = 1700, 400


@pytest.fixture(autouse=True)
def _very_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the objects of the built-in device be very many."""
    monkeypatch.setattr(further, "ENOUGH", ENOUGH)
    monkeypatch.setattr(allowance, "MOST", MOST)
    monkeypatch.setattr(allowance, "BEHIND", BEHIND)
    monkeypatch.setattr(allowance, "END", 0)


def recorded(pytester: pytest.Pytester) -> list[dict[str, object]]:
    """Return the results of a run, in the order in which they came."""
    text = (the_report(pytester) / "results.jsonl").read_text("utf-8")
    return [line["result"] for line in map(json.loads, text.splitlines()) if "result" in line]


def split(results: list[dict[str, object]]) -> tuple[list[str], list[str]]:
    """Return the ids of the cases that were run, and of those that were not."""
    ids: tuple[list[str], list[str]] = ([], [])
    for result in results:
        ids[result["verdict"] == "not run"].append(str(result["case_id"]))
    return ids


def test_what_is_left_out_is_told_in_all_reports(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *CHOSEN, "--junitxml=all.xml")
    assert result.ret == pytest.ExitCode.OK
    results = recorded(pytester)
    _, left = split(results)
    assert len(left) > 100
    assert all(case_id.startswith("od.") for case_id in left)
    assert sum(int(str(each["answers"])) for each in results) <= MOST
    result.stdout.fnmatch_lines([f"not run: {len(left)} cases of node 5: *requests*thorough*"])
    for file in (pytester.path / "all.xml", the_report(pytester) / "junit.xml"):
        messages = [each.attrib["message"] for each in parsed(file).iter("skipped")]
        assert messages.count(f"not run: {allowance.WHY}") == len(left)
    last = (the_report(pytester) / "results.jsonl").read_text("utf-8").splitlines()[-1]
    assert json.loads(last)["how"] == allowance.WHY


def test_the_first_of_each_case_are_run_and_what_comes_behind(pytester: pytest.Pytester) -> None:
    self_test(pytester, *CHOSEN)
    run, left = split(recorded(pytester))
    for function in {case_id.partition("[")[0] for case_id in left}:
        assert sum(case_id.startswith(f"{function}[") for case_id in run) >= ENOUGH
    assert run[-1].startswith("specifier.unknown"), "it may be too much for a device"


def test_further_objects_come_behind_all_others(pytester: pytest.Pytester) -> None:
    """By their cases, as these are written: what an object is comes before how it is read."""
    self_test(pytester, *CHOSEN, "--sdo-thorough", "--junitxml=all.xml")
    ids = case_ids(pytester.path / "all.xml")
    entries = [case_id for case_id in ids if case_id.startswith("od.read[")]
    assert len(entries) > 50
    further_ones = [ids.index(case_id) for case_id in entries[ENOUGH:]]
    assert further_ones == list(range(further_ones[0], further_ones[-1] + 1))
    late = [case_id for case_id in ids if case_id not in table() or not table()[case_id].early]
    ordinary = [case_id for case_id in late if not case_id.startswith("specifier.")]
    before = ordinary[: ordinary.index(entries[ENOUGH])]
    assert {case_id.partition("[")[0] for case_id in before} > {"od.read", "od.block-read"}
    assert ids.index("od.block-read[1000h:00]") < further_ones[0]
    assert ids[-1].startswith("specifier.unknown")


def test_a_thorough_run_leaves_out_nothing(pytester: pytest.Pytester) -> None:
    self_test(pytester, *CHOSEN, "--sdo-thorough")
    results = recorded(pytester)
    assert not split(results)[1]
    assert sum(int(str(each["answers"])) for each in results) > MOST


def test_a_defect_among_the_first_is_found_all_the_same(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *CHOSEN, "--sdo-fault=strings-padded")
    assert result.ret == pytest.ExitCode.TESTS_FAILED


def case(name: str, further: int = 0) -> CaseFunction:
    """Return a case on listed objects, one of ``further`` ones or not."""
    info = SimpleNamespace(rule=SimpleNamespace(id=name), is_of_listed=True)
    item = SimpleNamespace(further=further, node_id=5, case=info, nodeid=f"cases/test_x.py::{name}")
    return cast("CaseFunction", item)


def requests_of(parts: int = 1) -> allowance.RequestsOfRun:
    options = SimpleNamespace(thorough=False, share=SimpleNamespace(parts=parts))
    return allowance.RequestsOfRun(cast("Options", options))


@pytest.mark.parametrize("parts", [1, 4])
def test_workers_share_what_a_device_may_be_asked(parts: int) -> None:
    requests, last = requests_of(parts), (MOST - BEHIND) // parts
    assert not requests.why_not(case("od.read", further=1), last)
    assert requests.why_not(case("od.read", further=1), last + 1) == allowance.WHY
    assert not requests.why_not(case("od.read"), last + 1)


def test_what_a_case_takes_on_all_objects_is_limited() -> None:
    """Where they have long values: a case that takes some requests on each never comes so far."""
    requests = requests_of()
    requests.take(case("od.read"), allowance.MOST_OF_CASE)
    assert not requests.why_not(case("od.read"), 0)
    requests.take(case("od.read", further=1), 1)
    assert not requests.why_not(case("od.read"), 0)
    requests.take(case("od.read"), 1)
    assert requests.why_not(case("od.read"), 0) == allowance.WHY_CASE
    assert not requests.why_not(case("od.write-back"), 0)
    assert not requests.why_not(case("od.read", further=1), 0)


def test_what_would_be_too_much_in_the_end_is_left_out() -> None:
    """Whatever it is: a case that looks at what the others saw takes none."""
    requests, due = requests_of(), ceil(work_of("cases/test_x.py::od.read").answers)
    assert due > 0
    assert not requests.why_not(case("od.read"), MOST - due)
    assert requests.why_not(case("od.read"), MOST - due + 1) == allowance.WHY


def test_the_last_cases_are_left_out_of_a_run_that_takes_too_much(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(allowance, "MOST", 400)
    self_test(pytester, *CHOSEN)
    results = recorded(pytester)
    run, left = split(results)
    assert 100 < sum(int(str(each["answers"])) for each in results) <= 400
    assert left[-1].startswith("specifier.unknown")
    assert run


def test_what_was_not_read_before_is_read_and_not_written(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor is the node reset, as that may change what could not be put back."""
    monkeypatch.setattr(first_reading, "MOST_FURTHER", 10)
    monkeypatch.setattr(allowance, "MOST", 60_000)
    cases = "od.read or od.write-back or nmt.reset-boots"
    result = self_test(pytester, "--sdo-simulated", "-k", cases)
    assert result.ret == pytest.ExitCode.OK
    verdicts: dict[str, Counter[str]] = {}
    for each in recorded(pytester):
        of_case = verdicts.setdefault(str(each["case_id"]).partition("[")[0], Counter())
        of_case[str(each["verdict"])] += 1
    assert verdicts["od.read"].keys() == {"pass"}
    assert verdicts["od.read"].total() > 60
    assert verdicts["od.write-back"].keys() == {"pass", "not testable"}
    assert verdicts["nmt.reset-boots"] == {"not testable": 2}
    result.stdout.no_fnmatch_line("*not restored*")
