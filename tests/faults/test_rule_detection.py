"""Every rule that a server must keep is broken by a faulty one, and a case on the rule says so.

That the case fails for the fault is measured by ``detection.py``.
"""

import pytest

from conformance.faults.catalogue import faults
from conformance.faults.registry import Deviation
from conformance.rule_listing import scripted_cases
from conformance.run.case import CaseInfo
from conformance.sdo.rules import RULES, Level, Rule, rule_of

BROKEN_BY = {
    "1.5-operational": "nmt-operational-silent",
    "2.13-unused-count": "upload-n-not-zero-for-segmented",
    "2.13-toggle": "upload-toggle-not-answered",
    "2.13-size": "upload-size-8-bit",
    "2.13-block-size": "block-upload-one-segment-more",
    "2.13-sequence": "block-upload-numbering-goes-on",
    "2.13-last-segment": "upload-last-flag-early",
    "2.13-crc": "block-upload-crc-zero",
    "I32": "block-upload-threshold-not-compared",
    "D11": "unknown-specifier-ignored-in-download",
    "D12": "block-frames-ignored-in-download",
    "U2": "upload-toggle-ignored",
    "U4": "unknown-specifier-ignored-in-upload",
    "U10": "block-frames-ignored-in-upload",
    "B3": "block-download-segment-64-as-upload",
    "B6": "block-download-gap-not-noticed",
    "B7": "block-download-first-lost-not-noticed",
    "E1": "block-download-n-off-by-one",
    "F4": "block-upload-download-segment-confirmed",
    "F6": "block-upload-n-off-by-one",
    "F8": "block-upload-ackseq-0-taken-for-all",
    "G1": "block-upload-end-response-answered",
    "G4": "block-upload-abort-repeats-end",
    "3.11-value-kept": "abort-commits-download",
    "object.constant": "constant-text-consumed",
    "5-polynomial": "block-crc-starts-at-ffff",
    "5-covers": "block-upload-crc-of-repeated",
    "5-placement": "block-upload-crc-bytes-swapped",
    "5-server-without": "block-upload-crc-not-offered",
    "5-empty": "block-upload-crc-of-nothing",
    "8-ackseq": "block-download-sent-acknowledged",
    "8-multiple-of-7": "block-download-full-last-segment-lost",
    "8-end-of-sub-block": "block-upload-last-at-full-block-not-marked",
    "8-numbering": "block-upload-numbering-goes-on",
    "6-expedited-size": "upload-n-is-count",
    "6-short-data": "segmented-short-object-refused",
    "6-long-data": "upload-of-5-bytes-expedited",
    "6-variable-length": "short-text-refused",
    "7-client": "abort-ignored-in-download",
}
"""A fault that breaks the rule, for rules that no case names first."""

CASES = scripted_cases()
FAULTS = {fault.name: fault for fault in faults()}
REQUIRED = [
    rule for rule in RULES if rule.level is Level.MUST and any(rule in case.cites for case in CASES)
]


def catchers(fault: Deviation) -> list[CaseInfo]:
    """Return the cases that say what is wrong with a fault."""
    begin = fault.caught_by[0].partition("[")[0]
    exact = [case for case in CASES if case.rule.id == begin]
    return exact or [case for case in CASES if case.rule.id.startswith(begin)]


NAMED_FIRST = {
    found[0].cites[0].id for fault in FAULTS.values() if len(found := catchers(fault)) == 1
}


@pytest.mark.parametrize("rule", REQUIRED, ids=lambda rule: rule.id)
def test_a_faulty_server_breaks_it(rule: Rule) -> None:
    named = {rule_of(name).id for name in BROKEN_BY}
    assert rule.id in NAMED_FIRST | named, "write a faulty server that breaks this rule"


@pytest.mark.parametrize("name", BROKEN_BY)
def test_the_fault_is_caught_by_a_case_on_the_rule(name: str) -> None:
    rule, fault = rule_of(name), FAULTS[BROKEN_BY[name]]
    assert any(rule in case.cites for case in catchers(fault)), fault.caught_by


def test_every_fault_names_a_case() -> None:
    assert [name for name, fault in FAULTS.items() if not catchers(fault)] == []
