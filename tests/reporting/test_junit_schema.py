"""junit.xml is valid for Jenkins: by the schema where it is at hand, by its rules everywhere."""

import importlib
import xml.etree.ElementTree as ElementTree
from itertools import product
from pathlib import Path

import pytest
from junit_schema import XSD, breaches
from reporting_results import result, written

from conformance.run.verdict import CaseResult, Verdict

needs_xsd = pytest.mark.skipif(not XSD.exists(), reason="the schema is not beside the checkout")
DURATIONS = [0.0, 1e-9, 1e-7, 0.000123, 0.25, 59.9999999, 1234.5, 1e7]
PROPERTIES = {"node-id": "5", "vendor-id": "0x0000012E", "empty": ""}


def all_sorts() -> list[CaseResult]:
    """Return results of each verdict with each duration, in two services, some without texts."""
    return [
        result(
            verdict,
            case_id=f"case-{number}",
            service=("expedited-upload", "segmented-download")[number % 2],
            duration=duration,
            actual="" if number % 3 else "abort <1000h:00>",
            notes=["a & b"] * (number % 3),
        )
        for number, (verdict, duration) in enumerate(product(Verdict, DURATIONS))
    ]


def valid_by_xsd(path: Path) -> bool:
    etree = importlib.import_module("lxml.etree")
    schema = etree.XMLSchema(etree.parse(str(XSD)))
    return bool(schema.validate(etree.parse(str(path))))


@pytest.mark.parametrize("strict", [False, True])
@pytest.mark.parametrize("properties", [{}, PROPERTIES], ids=["bare", "properties"])
def test_rules(tmp_path: Path, strict: bool, properties: dict[str, str]) -> None:
    root = written(tmp_path / "junit.xml", all_sorts(), properties, strict=strict)
    assert root.tag == "testsuites"
    assert breaches(root) == []


def test_rules_without_results(tmp_path: Path) -> None:
    assert breaches(written(tmp_path / "junit.xml", [])) == []


@needs_xsd
@pytest.mark.parametrize("strict", [False, True])
def test_schema(tmp_path: Path, strict: bool) -> None:
    path = tmp_path / "junit.xml"
    written(path, all_sorts(), PROPERTIES, strict=strict)
    assert valid_by_xsd(path)


SUITE = '<testsuite name="s" tests="1" failures="0" errors="0"'
INVALID = {
    "disabled": f'{SUITE} disabled="0"/>',
    "suite-without-tests": '<testsuite name="s" failures="0" errors="0"/>',
    "exponent": f'{SUITE} time="1e-07"/>',
    "negative-time": f'{SUITE} time="-1.0"/>',
    "case-properties": f'{SUITE}><testcase name="c"><properties/></testcase></testsuite>',
    "case-without-name": f'{SUITE}><testcase classname="c"/></testsuite>',
    "case-status": f'{SUITE}><testcase name="c" status="run"/></testsuite>',
    "property-without-value": f'{SUITE}><properties><property name="p"/></properties></testsuite>',
    "text-in-suite": f"{SUITE}>text</testsuite>",
    "text-behind-case": f'{SUITE}><testcase name="c"/>text</testsuite>',
    "output-with-attribute": f'{SUITE}><system-out type="t"/></testsuite>',
    "unknown-element": f"{SUITE}><failure/></testsuite>",
}
VALID = {
    "time": f'{SUITE} time="0.000001"/>',
    "thousands": f'{SUITE} time="1,234.5"/>',
    "case": f'{SUITE}><testcase name="c" time="1"><failure message="m" type="t">text</failure>'
    "<system-out>text</system-out></testcase></testsuite>",
}


@pytest.mark.parametrize("name", INVALID)
def test_rules_refuse(name: str) -> None:
    assert len(breaches(ElementTree.fromstring(INVALID[name]))) == 1  # noqa: S314


@pytest.mark.parametrize("name", VALID)
def test_rules_allow(name: str) -> None:
    assert breaches(ElementTree.fromstring(VALID[name])) == []  # noqa: S314


@needs_xsd
@pytest.mark.parametrize(
    ("text", "valid"),
    [*((text, False) for text in INVALID.values()), *((text, True) for text in VALID.values())],
    ids=[*INVALID, *VALID],
)
def test_rules_and_schema_agree(tmp_path: Path, text: str, valid: bool) -> None:
    path = tmp_path / "junit.xml"
    path.write_text(text, encoding="utf-8")
    assert valid_by_xsd(path) is valid
