"""Settings in pytest's ini file and in the environment: as options, and overridden by them."""

from pathlib import Path

import pytest
from plugin_runs import QUICK, case_ids, hosted, reports, run, self_test, the_report

from conformance.faults.catalogue import build_node

pytest_plugins = ["pytester"]

OWN = """
def test_own(sdo):
    assert sdo.upload(__import__("conformance").device.device.VENDOR_ID)
"""


def header(result: pytest.RunResult) -> str:
    return "\n".join(line for line in result.outlines if line.startswith("conformance: "))


def ini(pytester: pytest.Pytester, *lines: str) -> Path:
    return Path(pytester.makepyprojecttoml("\n".join(("[tool.pytest.ini_options]", *lines))))


@pytest.fixture(autouse=True)
def no_variables(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("CAN_INTERFACE", "CAN_CHANNEL", "CAN_BITRATE", "CAN_CONFIG", "CANOPEN_NODE_ID"):
        monkeypatch.delenv(name, raising=False)


def test_a_project_names_its_device_once(pytester: pytest.Pytester) -> None:
    """The suite's cases are asked for by their folder, its own tests by nothing."""
    pytester.makepyfile(test_mine=OWN)
    with hosted(build_node(None, 7)) as (interface, channel):
        ini(
            pytester,
            "node_id = 7",
            f"can_interface = '{interface.partition('=')[2]}'",
            f"can_channel = '{channel.partition('=')[2]}'",
            "sdo_object = ['2004=unsigned32', '2001=unsigned8']",
            "sdo_response_timeout = '0.5'",
        )
        alone = run(pytester)
        alone.assert_outcomes(passed=1)
        assert alone.ret == pytest.ExitCode.OK
        assert "target: node 7 on virtual" in header(alone)
        assert "response time-out: 500 ms" in header(alone)
        assert "objects: 2 named" in header(alone)
        assert case_ids(the_report(pytester) / "junit.xml") == ["test_own"]
        cases = run(pytester, "abort.own")
        assert cases.ret == pytest.ExitCode.OK
        assert cases.parseoutcomes()["passed"] == 1


def test_tests_that_need_no_device_need_no_bus(pytester: pytest.Pytester) -> None:
    ini(pytester, "node_id = '5'", "can_interface = 'virtual'", "can_channel = 'nobody is here'")
    pytester.makepyfile(test_mine="def test_plain(): pass")
    result = run(pytester)
    result.assert_outcomes(passed=1)
    assert result.ret == pytest.ExitCode.OK
    assert not reports(pytester).exists()


def test_paths_are_relative_to_the_ini_file(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    ini(pytester, "sdo_device = 'bench/drive.toml'", "sdo_report_dir = 'left'")
    folder = pytester.mkdir("bench")
    (folder / "drive.toml").write_text("node-id = 9\n[can]\ninterface = 'virtual'\n")
    monkeypatch.chdir(folder)
    result = pytester.runpytest_inprocess(
        *QUICK, "cases", "--collect-only", "-q", "-k", "abort.own"
    )
    assert result.ret == pytest.ExitCode.OK
    wanted = pytester.runpytest_inprocess(*QUICK, "--sdo-restore", "abort.frame")
    assert (pytester.path / "left").is_dir()
    assert wanted.ret == 10, "the node is silent"


def test_the_environment_overrides_the_file_and_the_command_line_both(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = ("cases", "--collect-only", "-k", "abort.frame")
    ini(pytester, "node_id = '7'", "can_interface = 'virtual'", "can_channel = 'of the file'")
    assert "target: node 7 on virtual of the file" in header(run(pytester, *listed))
    monkeypatch.setenv("CANOPEN_NODE_ID", "8")
    monkeypatch.setenv("CANOPEN_OBJECT", "2001=unsigned8 2002")
    monkeypatch.setenv("CAN_CHANNEL", "of the environment")
    found = header(run(pytester, *listed))
    assert "target: node 8 on virtual of the environment" in found
    assert "objects: 2 named" in found
    options = ("--node-id=9", "--can-channel=of the command line")
    assert "node 9 on virtual of the command line" in header(run(pytester, *listed, *options))


def test_a_self_test_has_its_own_device(pytester: pytest.Pytester) -> None:
    ini(pytester, "node_id = '7'", "can_interface = 'pcan'", "sdo_device = 'none.toml'")
    result = self_test(pytester, "-k", "abort.frame")
    assert result.ret == pytest.ExitCode.OK
    assert "built-in reference server, node 5 on virtual" in header(result)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("node_id = '200'", "argument --node-id: '200': node-IDs go from 1 to 127"),
        ("sdo_allow = ['nmtt']", "There is no permission called 'nmtt'. Did you mean 'nmt'?"),
        ("sdo_device = 'none.toml'", "none.toml: the file cannot be read"),
    ],
)
def test_what_is_wrong_is_told_in_one_sentence(
    pytester: pytest.Pytester, line: str, sentence: str
) -> None:
    ini(pytester, line)
    result = run(pytester)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert sentence in result.stderr.str()


def test_the_help_lists_them(pytester: pytest.Pytester) -> None:
    listed = " ".join(run(pytester, "--help").stdout.str().split())
    assert "node_id (string): as --node-id; also the environment variable CANOPEN_NODE_ID" in listed
    assert "sdo_device (string): as --sdo-device" in listed
