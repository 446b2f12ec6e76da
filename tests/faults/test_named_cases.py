"""Every case is named by a faulty server that it has to fail: no case is left that cannot fail.

That it does fail is measured by ``detection.py``, which meets each fault with the cases it names.
"""

import pytest

from conformance.faults.catalogue import faults
from conformance.faults.registry import Deviation
from conformance.reporting.rule_listing import scripted_cases

# They need what the self-test does not have; each has a test that shows it fail.
SHOWN_ELSEWHERE = {
    "od.configured": "test_a_dcf_is_compared_with_the_configuration: needs a DCF",
    "od.scan": "test_scan: needs --scan",
}
CASES = sorted({case.rule.id for case in scripted_cases()})


def unnamed(cases: list[str], servers: list[Deviation]) -> list[str]:
    """Return the cases that no fault names; variations of a case stand for it."""
    named = {begin.partition("[")[0] for server in servers for begin in server.caught_by}
    return [case for case in cases if case not in named and case not in SHOWN_ELSEWHERE]


def test_a_faulty_server_names_each_case() -> None:
    assert unnamed(CASES, faults()) == [], "write a faulty server that each of these has to fail"


def test_a_case_that_no_fault_names_is_found() -> None:
    found = [fault for fault in faults() if "abort.repeated" not in fault.caught_by]
    assert unnamed(CASES, found) == ["abort.repeated"]


@pytest.mark.parametrize("fault", faults(), ids=lambda fault: fault.name)
def test_a_fault_names_cases_that_there_are(fault: Deviation) -> None:
    assert fault.caught_by
    for begin in fault.caught_by:
        stem, variation, _ = begin.partition("[")
        assert stem in CASES if variation else any(case.startswith(begin) for case in CASES)


def test_a_fault_takes_a_thorough_run_if_only_such_a_run_has_the_cases_that_it_names() -> None:
    reserved = {case.rule.id for case in scripted_cases() if case.thorough}
    assert reserved
    for fault in faults():
        named = {begin.partition("[")[0] for begin in fault.caught_by}
        assert fault.thorough == (named <= reserved), fault.name


@pytest.mark.parametrize("case", SHOWN_ELSEWHERE)
def test_what_is_shown_elsewhere_is_a_case(case: str) -> None:
    assert case in CASES
