"""What each verdict becomes in junit.xml, and that the numbers are those of the results."""

from pathlib import Path

import pytest
from reporting_results import TIMESTAMP, found, result, written

from conformance.run.verdict import Afterwards, Verdict

CHILDREN = [
    (Verdict.PASS, False, ["system-out"]),
    (Verdict.INFO, False, ["system-out"]),
    (Verdict.NON_STRICT, False, ["system-out"]),
    (Verdict.NON_STRICT, True, ["failure"]),
    (Verdict.FAIL, False, ["failure"]),
    (Verdict.BENCH_ERROR, False, ["error"]),
    (Verdict.UNIMPLEMENTED, False, ["skipped", "system-out"]),
    (Verdict.NOT_TESTABLE, False, ["skipped", "system-out"]),
    (Verdict.STALE, False, ["failure"]),
    (Verdict.PASS, True, ["system-out"]),
    (Verdict.INFO, True, ["system-out"]),
]


@pytest.mark.parametrize(("verdict", "strict", "children"), CHILDREN)
@pytest.mark.parametrize("actual", ["abort 1000h:00", ""])
def test_verdict(
    tmp_path: Path, verdict: Verdict, strict: bool, children: list[str], actual: str
) -> None:
    root = written(tmp_path / "junit.xml", [result(verdict, actual=actual)], strict=strict)
    case = found(root, "testsuite/testcase")
    assert [child.tag for child in case] == children
    if children != ["system-out"]:
        assert (actual or verdict.value) in case[0].attrib["message"]


@pytest.mark.parametrize(
    ("verdict", "kind", "message"),
    [
        (Verdict.FAIL, "fail", "abort 1000h:00"),
        (Verdict.STALE, "stale deviation", "abort 1000h:00"),
        (Verdict.BENCH_ERROR, "bench error", "abort 1000h:00"),
        (Verdict.UNIMPLEMENTED, "skipped", "unimplemented: abort 1000h:00"),
        (Verdict.NOT_TESTABLE, "skipped", "not testable: abort 1000h:00"),
    ],
)
def test_type_and_message(tmp_path: Path, verdict: Verdict, kind: str, message: str) -> None:
    root = written(tmp_path / "junit.xml", [result(verdict, actual="abort 1000h:00")])
    child = found(root, "testsuite/testcase")[0]
    assert (child.get("type"), child.get("message")) == (kind, message)


def test_a_known_deviation_shows_its_reason(tmp_path: Path) -> None:
    known = result(Verdict.KNOWN_DEVIATION, actual="abort 1000h:00", reason="ticket 1")
    root = written(tmp_path / "junit.xml", [known])
    child = found(root, "testsuite/testcase")[0]
    assert (child.tag, child.get("message")) == ("skipped", "known deviation: ticket 1")


def test_counts(tmp_path: Path) -> None:
    verdicts = [
        *[Verdict.PASS] * 5,
        *[Verdict.INFO] * 2,
        *[Verdict.NON_STRICT] * 3,
        *[Verdict.FAIL] * 4,
        *[Verdict.BENCH_ERROR] * 2,
        *[Verdict.UNIMPLEMENTED] * 1,
        *[Verdict.NOT_TESTABLE] * 3,
    ]
    results = [result(verdict, service="upload", duration=0.25) for verdict in verdicts] + [
        result(Verdict.FAIL, service="download", duration=2.0),
        result(service="download"),
    ]
    root = written(tmp_path / "junit.xml", results)
    numbers = ("name", "tests", "failures", "errors", "skipped", "time", "timestamp")
    assert [[suite.get(name) for name in numbers] for suite in root] == [
        ["upload", "20", "4", "2", "4", "5.000000", TIMESTAMP],
        ["download", "2", "1", "0", "0", "2.250000", TIMESTAMP],
    ]
    assert root.attrib == {
        "name": "CANopen SDO conformance",
        "tests": "22",
        "failures": "5",
        "errors": "2",
        "time": "7.250000",
    }
    strict = written(tmp_path / "strict.xml", results, strict=True)
    assert (strict[0].get("failures"), strict.get("failures")) == ("7", "8")


@pytest.mark.parametrize(
    ("duration", "time"),
    [
        (0.0, "0.000001"),
        (1e-7, "0.000001"),
        (0.25, "0.250000"),
        (12.3456789, "12.345679"),
        (86400.5, "86400.500000"),
    ],
)
def test_times_have_no_exponent(tmp_path: Path, duration: float, time: str) -> None:
    root = written(tmp_path / "junit.xml", [result(duration=duration)])
    assert found(root, "testsuite/testcase").get("time") == time
    for element in (root, root[0]):
        assert set(element.attrib["time"]) <= set("0123456789.")


def test_names(tmp_path: Path) -> None:
    results = [
        result(case_id="upload.size[8]", service="upload", node_id=5),
        result(case_id="upload.size[8]", service="upload", node_id=17),
    ]
    (suite,) = written(tmp_path / "junit.xml", results)
    assert [(case.get("classname"), case.get("name")) for case in suite] == [
        ("node-5.upload", "upload.size[8]"),
        ("node-17.upload", "upload.size[8]"),
    ]


def test_properties_stand_in_every_suite(tmp_path: Path) -> None:
    properties = {"node-id": "5", "vendor-id": "0x0000012E"}
    results = [result(service="upload"), result(service="download")]
    for suite in written(tmp_path / "junit.xml", results, properties):
        entries = found(suite, "properties")
        assert {entry.get("name"): entry.get("value") for entry in entries} == properties


def test_a_failure_holds_the_evidence(tmp_path: Path) -> None:
    failed = result(
        Verdict.FAIL,
        broken_rule="response.toggle",
        broken_sentence="The response to a segment repeats its toggle bit.",
        expected="t=0",
        actual="t=1",
        afterwards=Afterwards.NEEDED_ABORT,
        notes=["seen once"],
    )
    root = written(tmp_path / "junit.xml", [failed])
    assert found(root, "testsuite/testcase/failure").text == "\n".join(
        [
            "upload.device-type: FAIL (MUST, CiA 301 clause 7.5.2.1, node 5)",
            "  requirement: The device type (1000h), which every device has, reads as 4 bytes.",
            "  broken rule: response.toggle: The response to a segment repeats its toggle bit.",
            "  expected: t=0",
            "  actual: t=1",
            "  afterwards: needed an abort",
            "  note: seen once",
            "  frames (> sent, < received):",
            "        0.0 ms > 605#4000100000000000 upload initiate 1000h:00",
            "  to repeat what was sent:",
            "    cansend can0 605#4000100000000000",
        ]
    )
