"""pytest's own --junitxml: what each case is about and what it found stand in its properties."""

import xml.etree.ElementTree as ElementTree

import pytest
from plugin_runs import QUICK, parsed, reference, reports, run, self_test, the_report

pytest_plugins = ["pytester"]

MIXED = "upload.identity or abort.frame or extended-ignored or test_expedited_download and stored"
SERVER = (
    "--sdo-fault=answers-extended",
    "--sdo-object=2001=unsigned8",
    "--sdo-object=2002=unsigned16",
)
ELSEWHERE = """
    from conformance.sdo.layout import Multiplexer

    def test_elsewhere(sdo):
        '''Writes without a permission.'''
        sdo.download(Multiplexer(0x1004), bytes(2))

    def test_wrong(sdo):
        assert sdo.upload(Multiplexer(0x1018, 1)) == b"ours"
"""


def junit(pytester: pytest.Pytester, *arguments: str) -> dict[str, ElementTree.Element]:
    """Return the cases of a run by name."""
    self_test(pytester, "--junitxml=junit.xml", *arguments)
    return cases(pytester)


def cases(pytester: pytest.Pytester) -> dict[str, ElementTree.Element]:
    found = parsed(pytester.path / "junit.xml").iter("testcase")
    return {case.attrib["name"]: case for case in found}


def properties(case: ElementTree.Element) -> dict[str, str]:
    """Return the properties of a case; each is there once."""
    pairs = [(p.attrib["name"], p.attrib["value"]) for p in case.iter("property")]
    values = dict(pairs)
    assert len(values) == len(pairs)
    return values


def child(case: ElementTree.Element, kind: str) -> ElementTree.Element:
    """Return the outcome of a case, which is the only one."""
    (found,) = [element for element in case if element.tag in ("failure", "error", "skipped")]
    assert found.tag == kind
    return found


def test_a_case_that_passed(pytester: pytest.Pytester) -> None:
    case = junit(pytester, "-k", "upload.device-type")["upload.device-type"]
    assert [element.tag for element in case] == ["properties"]
    found = properties(case)
    assert found.pop("trace") == "", "what merely passed needs no evidence"
    assert float(found.pop("latency-ms")) > 0
    assert found == {
        "id": "upload.device-type",
        "node-id": "5",
        "clause": "7.5.2.1",
        "level": "MUST",
        "rules": "object.mandatory response.not-refused",
        "verdict": "pass",
        "requirement": "The device type (1000h), which every device has, reads as 4 bytes.",
        "expected": "",
        "actual": "",
        "afterwards": "idle",
    }


def test_a_case_that_failed(pytester: pytest.Pytester) -> None:
    found = junit(pytester, "--sdo-fault=identity-count-wrong", "-k", "upload.identity")
    case = found["upload.identity"]
    failure = child(case, "failure")
    values = properties(case)
    assert values["verdict"] == "fail"
    assert values["expected"]
    assert values["actual"]
    message = f"expected {values['expected']}; got {values['actual']}"
    assert failure.attrib["message"] == message
    text = failure.text or ""
    assert text.startswith("upload.identity: FAIL (MUST, CiA 301 clause 7.5.2.21, node 5)\n")
    for line in (*values["trace"].splitlines(), values["expected"], values["actual"]):
        assert line.strip() in text
    assert "cansend" not in text, "which knows no virtual bus"
    assert "Traceback" not in text


def test_what_is_not_supported_or_lacks_something_is_skipped(pytester: pytest.Pytester) -> None:
    without = "--sdo-fault=no-block-transfer"
    found = junit(
        pytester,
        without,
        "--sdo-object=2001=unsigned8",
        "-k",
        "specifier.block-upload or write-only",
    )
    refused = found["specifier.block-upload[True]"]
    message = child(refused, "skipped").attrib["message"]
    assert message.startswith("unimplemented: abort 1000h:00, 05040001h")
    assert properties(refused)["verdict"] == "unimplemented"
    assert "block upload initiate" in properties(refused)["trace"]
    lacking = found["download.write-only"]
    message = child(lacking, "skipped").attrib["message"]
    assert message.startswith("not testable: needs a write-only object")
    values = properties(lacking)
    assert (values["id"], values["verdict"]) == ("download.write-only", "not testable")
    assert (values["clause"], values["level"]) == ("7.2.4.3.3", "MUST")
    assert values["requirement"] == "A write-only object takes a value."


def test_a_broken_bench_is_an_error_and_no_failure(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=ELSEWHERE)
    found = junit(pytester, "test_mine.py")
    case = found["test_elsewhere"]
    assert "1004h:00" in child(case, "error").attrib["message"]
    assert "requirement: Writes without a permission." in (child(case, "error").text or "")
    assert properties(case)["verdict"] == "bench error"
    assert child(found["test_wrong"], "failure") is not None
    suite = next(parsed(pytester.path / "junit.xml").iter("testsuite"))
    assert (suite.attrib["errors"], suite.attrib["failures"]) == ("1", "1")


@pytest.mark.parametrize("strict", [False, True])
def test_both_junit_files_count_the_same(pytester: pytest.Pytester, strict: bool) -> None:
    """The one that pytest writes and the one of the report."""
    arguments = ["--strict"] if strict else []
    found = junit(pytester, *SERVER, *arguments, "-k", MIXED)
    total = {"tests": 0, "failures": 0, "errors": 0, "skipped": 0}
    for suite in parsed(the_report(pytester) / "junit.xml").iter("testsuite"):
        for name in total:
            total[name] += int(suite.attrib[name])
    suite = next(parsed(pytester.path / "junit.xml").iter("testsuite"))
    assert {name: int(suite.attrib[name]) for name in total} == total
    assert total == {"tests": len(found), "failures": int(strict), "errors": 0, "skipped": 2}


def test_one_case_on_two_devices(pytester: pytest.Pytester) -> None:
    found = junit(pytester, "--node-id=5,9", "-k", "abort.frame")
    assert {name: properties(case)["node-id"] for name, case in found.items()} == {
        "abort.frame@5": "5",
        "abort.frame@9": "9",
    }
    assert {properties(case)["id"] for case in found.values()} == {"abort.frame"}


def test_workers_tell_the_same(pytester: pytest.Pytester) -> None:
    chosen = ("--self-test", "--sdo-fault=answers-extended", "-k", MIXED, "--junitxml=junit.xml")
    told = []
    for workers in ("0", "1"):
        folder = f"--sdo-report-dir={reports(pytester)}"
        pytester.runpytest_subprocess(*QUICK, folder, "-n", workers, *chosen)
        found = {}
        for name, case in cases(pytester).items():
            values = properties(case)
            del values["latency-ms"], values["trace"]
            outcomes = [(child.tag, child.get("message")) for child in case]
            found[name] = case.attrib["classname"], outcomes, values
        told.append(found)
    assert len(told[0]) > 5
    assert told[0] == told[1]


def test_a_device_of_the_users_own(pytester: pytest.Pytester) -> None:
    with reference() as options:
        run(pytester, *options, "--junitxml=junit.xml", "-k", "abort.frame")
    assert properties(cases(pytester)["abort.frame"])["verdict"] == "pass"
