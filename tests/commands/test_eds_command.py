"""``conformance eds``: findings as text, as JSON lines and as JUnit; and its exit status."""

import json
from pathlib import Path

import pytest
from junitparser import JUnitXml

from conformance.__main__ import main
from conformance.eds.rules import RULES

FILES = Path(__file__).parents[1] / "eds" / "files"
FAULTY, RIGHT = FILES / "faulty" / "access-unknown.eds", FILES / "right.eds"
# It has warnings alone.
DRIVE = FILES / "drive.eds"


def test_a_finding_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eds", str(FAULTY)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2:] == [
        f"{FAULTY}:69: error: [6300] AccessType=UNKNOWN is unknown. No case is about the entry. "
        "[eds.access, CiA 306-1 clause 6.6.3.2]",
        f"{FAULTY}: 1 error, 2 warnings, 0 remarks; 3 objects, 4 entries",
    ]


@pytest.mark.parametrize(
    ("path", "options", "status"),
    [
        (RIGHT, (), 0),
        (RIGHT, ("--strict",), 0),
        (DRIVE, (), 0),
        (DRIVE, ("--strict",), 3),
        (FAULTY, ("--strict",), 1),
        (FILES, (), 1),
        (FILES / "none.eds", (), 1),
    ],
)
def test_the_exit_status(path: Path, options: tuple[str, ...], status: int) -> None:
    assert main(["eds", str(path), *options]) == status


def test_what_is_no_description_is_a_finding_and_the_others_are_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "text.eds"
    path.write_text("nothing of the kind", encoding="utf-8")
    assert main(["eds", str(path), str(RIGHT)]) == 1
    first, _, last = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{path}: error: there is no section of an object, as [1000],")
    assert first.endswith("[eds.readable, CiA 306-1 clause 6]")
    assert last == f"{RIGHT}: 0 errors, 0 warnings, 0 remarks; 16 objects, 34 entries"


def test_json_lines(capsys: pytest.CaptureFixture[str]) -> None:
    main(["eds", "--json", str(FAULTY)])
    found = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert found[-1] == {
        "file": str(FAULTY),
        "line": 69,
        "section": "6300",
        "rule": "eds.access",
        "clause": "CiA 306-1 clause 6.6.3.2",
        "severity": "error",
        "sentence": "AccessType=UNKNOWN is unknown",
        "made": "No case is about the entry",
        "text": f"{FAULTY}:69: error: [6300] AccessType=UNKNOWN is unknown. No case is about the "
        "entry. [eds.access, CiA 306-1 clause 6.6.3.2]",
    }


@pytest.mark.parametrize(("options", "failures"), [((), 1), (("--strict",), 3)])
def test_a_suite_for_each_file(tmp_path: Path, options: tuple[str, ...], failures: int) -> None:
    path = tmp_path / "eds.xml"
    main(["eds", f"--junitxml={path}", *options, str(FAULTY), str(RIGHT)])
    suites = list(JUnitXml.fromfile(str(path)))
    assert [suite.name for suite in suites] == [
        "description access-unknown.eds",
        "description right.eds",
    ]
    assert [(suite.tests, suite.failures) for suite in suites] == [
        (len(RULES), failures),
        (len(RULES), 0),
    ]


def test_a_device_has_one_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eds", str(RIGHT), str(DRIVE), "--node-id=5"]) == 2
    assert "--node-id goes with one file" in capsys.readouterr().err


def test_rules_for_descriptions_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rules", "eds.limit-order"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "descriptions of devices:",
        "  eds.limit-order  error  CiA 306-1 clause 6.6.3.2",
        "      LowLimit is not above HighLimit.",
        "      checked by: conformance eds",
    ]
    assert main(["rules"]) == 0
    assert f"; {len(RULES)} rules for descriptions of devices" in capsys.readouterr().out
