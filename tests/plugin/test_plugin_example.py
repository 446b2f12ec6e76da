"""examples/drive: own tests and the suite, in one run and one report, as its README says."""

import re
import shutil
from pathlib import Path

import pytest
from plugin_runs import case_ids, parsed, reference, run, self_test, the_report

import conformance
from conformance import own_tests

pytest_plugins = ["pytester"]

EXAMPLE = Path(__file__).parents[2] / "examples" / "drive"
OWN = 6


@pytest.fixture
def project(pytester: pytest.Pytester) -> pytest.Pytester:
    shutil.copytree(EXAMPLE, pytester.path, dirs_exist_ok=True)
    return pytester


def test_its_own_tests_find_the_device(project: pytest.Pytester) -> None:
    with reference() as (_, *bus):
        result = run(project, *bus)
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(passed=OWN)
    assert result.stdout.str().count("target: node 5 on virtual") == 1
    log = (the_report(project) / "bus.log").read_text(encoding="utf-8")
    assert "605#23042000B80B0000" in log, "3000 is written"
    assert log.rindex("605#2304200011223344") > log.index("605#23042000B80B0000"), "and put back"


def test_both_are_one_run_with_one_report(project: pytest.Pytester) -> None:
    with reference() as (_, *bus):
        result = run(project, *bus, "tests", "abort", "upload.device-type")
    assert result.ret == pytest.ExitCode.OK
    ids = case_ids(the_report(project) / "junit.xml")
    assert {"test_a_speed_is_taken[3000]", "abort.frame", "upload.device-type"} <= set(ids)
    services = {suite.attrib["name"] for suite in parsed(the_report(project) / "junit.xml")}
    assert {"test_drive", "abort"} <= services


def test_without_a_device_it_is_shown_by_the_self_test(project: pytest.Pytester) -> None:
    result = self_test(project, "tests")
    assert result.parseoutcomes() == {"passed": OWN}


def test_its_readme_says_how_to_run_it_without_a_device(project: pytest.Pytester) -> None:
    text = (EXAMPLE / "README.md").read_text(encoding="utf-8")
    commands = re.findall(r"`pytest (--self-test[^`]*)`", text)
    assert len(commands) == 3
    own = [command for command in commands if "tests" in command.split()]
    suite = [command for command in commands if "cases" in command or command == "--self-test"]
    for command in commands:
        listed = self_test(project, *command.split()[1:], "--collect-only", "-q").outlines
        assert any("test_drive.py" in line for line in listed) is (command in own)
        assert any(line.startswith("cases/") for line in listed) is (command in suite)


def test_the_names_for_own_tests() -> None:
    """They come when they are asked for, and no others do."""
    assert all(getattr(conformance, name) is not None for name in own_tests.__all__)
    assert own_tests.__all__ == sorted(own_tests.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'Server'"):
        conformance.Server  # noqa: B018
