"""What a run says at its end."""

from typing import Literal

import pytest
from reporting_results import result

from conformance.device.device import Device
from conformance.device.eds_listing import Listing
from conformance.device.learned import Learned
from conformance.device.not_testable import Lack, Missing
from conformance.reporting.summary import (
    MOST_REASONS,
    device_properties,
    found_lines,
    summary_lines,
)
from conformance.run.verdict import Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer


def test_verdicts_are_counted_and_remarks_told() -> None:
    lack = "needs a writable string or domain: name one"
    results = [
        result(),
        result(),
        result(Verdict.FAIL, case_id="upload.toggle", actual="t=1"),
        result(Verdict.NON_STRICT, case_id="upload.filler", actual="FF in bytes without data"),
        result(Verdict.INFO, case_id="upload.order", notes=["first this", "then that"]),
        result(Verdict.NOT_TESTABLE, case_id="download.a", actual=lack),
        result(Verdict.NOT_TESTABLE, case_id="download.b", actual=lack),
        result(waited=0.5),
        result(waited=0.75),
    ]
    counts, share, filler, order, lacks, waited = [
        "4 pass, 1 non-strict, 1 info, 2 not testable, 1 fail",
        "7 of 9 cases tested (77 %)",
        "non-strict: upload.filler: FF in bytes without data",
        "info: upload.order: first this; then that",
        f"not testable (2 cases): {lack}",
        "waited 1.2 s in total for answers that did not come",
    ]
    assert summary_lines(results, whole=False) == [counts, share, filler, order, lacks, waited]


def test_nothing_is_said_of_what_did_not_happen() -> None:
    unhurried = result(progress="20 of 20 examples", waited=0.01)
    assert summary_lines([result(), unhurried], whole=False) == ["2 pass"]


def test_how_far_a_search_came_is_told_where_all_is() -> None:
    results = [result(case_id="random.all", progress="20 of 20 examples in 1 s")]
    assert summary_lines(results, whole=False) == ["1 pass"]
    assert summary_lines(results, whole=True)[1] == "random.all: 20 of 20 examples in 1 s"


def test_many_lines_of_a_kind_are_not_all_shown() -> None:
    lacks = [f"needs {number}" for number in range(12)]
    results = [result(Verdict.NOT_TESTABLE, actual=lack) for lack in [lacks[7], *lacks]]
    _, share, *shown, rest = summary_lines(results, whole=False)
    assert share == "0 of 13 cases tested (0 %)"
    assert shown[0] == "not testable (2 cases): needs 7"
    assert len(shown) == MOST_REASONS
    assert (
        rest
        == f"{12 - MOST_REASONS} more reasons why cases are not testable: see the reports, or -v"
    )
    assert len(summary_lines(results, whole=True)) == 2 + 12


def test_what_one_addition_gives_is_one_reason() -> None:
    nmt, probes = (Missing(Lack.PERMISSION, name) for name in ("nmt", "read-only-probes"))
    reasons = [
        ("needs an EDS", Missing(Lack.EDS)),
        *[("the device would take it: permit it", probes)] * 2,
        *[("needs to write to 1000h:00", probes)] * 3,
        *[("needs permission", nmt)] * 4,
    ]
    results = [
        result(Verdict.NOT_TESTABLE, actual=reason, missing=missing) for reason, missing in reasons
    ]
    assert summary_lines(results, whole=False)[1:] == [
        "0 of 10 cases tested (0 %)",
        "not testable (5 cases): needs to write to 1000h:00",
        "not testable (4 cases): needs permission",
        "not testable (1 case): needs an EDS",
    ]


REFUSAL = Abort(Multiplexer(0x1000), AbortCode.COMMAND_NOT_VALID)


@pytest.mark.parametrize(
    ("refusal", "words"),
    [
        (None, "unknown"),
        (False, "served"),
        (REFUSAL, f"refused ({in_words(REFUSAL)})"),
    ],
)
def test_what_was_found_by_reading(refusal: Abort | Literal[False] | None, words: str) -> None:
    """Of a device without EDS."""
    values = {
        Multiplexer(0x1000): bytes(4),
        Multiplexer(0x1008): b"a name",
        Multiplexer(0x1001): b"0",
    }
    device = Device(5, values=values, learned=Learned(block_upload_refusal=refusal))
    lengths = "1: 1, 4: 1, more: 1 (up to 6, 1008h:00)"
    found = f"3 objects, by length in bytes {lengths}; block upload: {words}"
    assert found_lines(device_properties(device, alone=True)) == [f"found by reading: {found}"]
    assert found_lines(device_properties(device, alone=False)) == [
        f"node 5: found by reading: {found}"
    ]


def test_a_device_with_an_eds_is_known() -> None:
    device = Device(5, listing=Listing(is_complete=True))
    assert found_lines(device_properties(device, alone=True)) == []


def test_a_device_that_lets_nothing_be_read() -> None:
    (line,) = found_lines(device_properties(Device(5), alone=True))
    assert line == "found by reading: 0 objects; block upload: unknown"
