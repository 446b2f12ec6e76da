"""Every rule that a server must keep is broken by a faulty one, and a case on the rule says so.

That the case fails for the fault is measured by ``detection.py``.
"""

import pytest

from conformance.faults.catalogue import faults
from conformance.faults.registry import Deviation
from conformance.reporting.rule_listing import scripted_cases
from conformance.run.case import CaseInfo
from conformance.sdo.rules import RULES, Level, Rule, rule_of

BROKEN_BY = {
    "nmt.operational": "nmt-operational-silent",
    "response.unused-count": "upload-n-not-zero-for-segmented",
    "response.toggle": "upload-toggle-not-answered",
    "upload.size": "upload-size-8-bit",
    "block.size": "block-upload-one-segment-more",
    "block.sequence": "block-upload-numbers-from-0",
    "upload.ends": "upload-last-flag-early",
    "block.crc": "block-upload-crc-zero",
    "block-upload.above-threshold": "block-upload-threshold-not-compared",
    "segmented-download.unknown-specifier": "unknown-specifier-ignored-in-download",
    "segmented-download.block-frames": "block-frames-ignored-in-download",
    "segmented-upload.toggle": "upload-toggle-ignored",
    "segmented-upload.unknown-specifier": "unknown-specifier-ignored-in-upload",
    "segmented-upload.block-frames": "block-frames-ignored-in-upload",
    "block-download.segments-only": "block-download-segment-64-as-upload",
    "block-download.gap": "block-download-gap-not-noticed",
    "block-download.first-lost": "block-download-first-lost-not-noticed",
    "block-download.stored": "block-download-n-off-by-one",
    "block-upload.foreign-before-start": "block-upload-download-segment-confirmed",
    "block-upload.end": "block-upload-n-off-by-one",
    "block-upload.nothing-acknowledged": "block-upload-ackseq-0-taken-for-all",
    "block-upload.over": "block-upload-end-response-answered",
    "block-upload.client-abort-at-end": "block-upload-abort-repeats-end",
    "server.value-kept": "abort-commits-download",
    "object.constant": "constant-text-consumed",
    "crc.algorithm": "block-crc-starts-at-ffff",
    "crc.covers": "block-upload-crc-of-repeated",
    "crc.placement": "block-upload-crc-bytes-swapped",
    "crc.not-offered": "block-upload-crc-not-offered",
    "crc.empty": "block-upload-crc-of-nothing",
    "block.acknowledgement": "block-download-sent-acknowledged",
    "block.full-last-segment": "block-download-full-last-segment-lost",
    "block.ends-with-sub-block": "block-upload-last-at-full-block-not-marked",
    "data.expedited-size": "upload-n-is-count",
    "data.short-in-segments": "segmented-short-object-refused",
    "data.long-in-segments": "upload-of-5-bytes-expedited",
    "data.variable-length": "short-text-refused",
    "time-out.client": "abort-ignored-in-download",
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
    assert rule.id in NAMED_FIRST | BROKEN_BY.keys(), "write a faulty server that breaks this rule"


@pytest.mark.parametrize("name", BROKEN_BY)
def test_the_fault_is_caught_by_a_case_on_the_rule(name: str) -> None:
    rule, fault = rule_of(name), FAULTS[BROKEN_BY[name]]
    assert any(rule in case.cites for case in catchers(fault)), fault.caught_by
