"""The runs and files of docs, on a device of the test: as printed, with its bus and few cases."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import can
import pytest
from test_authoring_guide import ROOT, blocks
from test_documented_commands import EDS, of

from conformance.__main__ import main
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.known_deviations import read_deviations, unknown_case
from conformance.faults.catalogue import build_node
from conformance.reference.host import NodeHost
from conformance.run.bench import private_channel
from conformance.sdo.rules import RULES_BY_ID

pytest_plugins = ["pytester"]

# What a machine with one virtual bus has not: other interfaces, programs, devices, a server beside.
ELSEWHERE = (
    *("--can-interface", "--sdo-process", "--sdo-recover", "--self-test"),
    *("-n", "-VV", "--node-id=1-"),
)
RUNS = [words for words in of("pytest") if not any(word.startswith(ELSEWHERE) for word in words)]
FEW = "abort.own or block-upload.object-missing or serial or hidden"
NOT_TESTED = 14


def example(page: str, begins: str) -> str:
    """Return an indented part of a page."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    (found,) = (each for each in blocks(text) if each.startswith(begins))
    return found


@pytest.fixture
def channel(pytester: pytest.Pytester) -> Iterator[str]:
    """Host node 5, in a folder with the files that docs name; yields its virtual channel."""
    shutil.copy(EDS, pytester.path / "drive.eds")
    deviations, _, _ = example("deviations.md", "[[deviations]]").partition("\n\npytest")
    files = {
        "drive.toml": example("device.md", "node-id"),
        "device.toml": "node-id = 5",
        "known.toml": deviations,
        "test_mine.py": example("own-tests.md", "from conformance").partition("\n\npytest")[0],
    }
    for name, text in files.items():
        (pytester.path / name).write_text(text, encoding="utf-8")
    name = private_channel()
    with NodeHost(open_bus(BusSettings("virtual", name)), build_node(None, 5)):
        yield name


def test_the_runs_are_found() -> None:
    assert len(RUNS) > 10


@pytest.mark.parametrize("words", RUNS, ids=" ".join)
def test_a_run(words: list[str], channel: str, pytester: pytest.Pytester) -> None:
    bus = ("--can-interface=virtual", f"--can-channel={channel}")
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider", *words, *bus, "-k", FEW)
    required = any(word.startswith("--sdo-require") for word in words)
    assert result.ret == (NOT_TESTED if required else pytest.ExitCode.OK)
    assert result.parseoutcomes()["passed"] > 0


COMMANDS = [
    [word for word in words if not word.startswith("--can-")]
    for words in of("conformance")
    if words[0] in ("restore", "replay") or (words[0] == "init" and "--node-id" in words)
]


def test_the_commands_are_found() -> None:
    assert {words[0] for words in COMMANDS} == {"init", "restore", "replay"}


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_command(words: list[str], channel: str, pytester: pytest.Pytester) -> None:
    fault = ("--self-test", "--sdo-simulated", "--sdo-fault=upload-toggle-ignored")
    pytester.runpytest_inprocess("-p", "no:cacheprovider", *fault, "-k", "segmented-upload.toggle")
    (folder,) = (pytester.path / "reports").iterdir()
    folder.rename(folder.with_name("RUN"))
    (pytester.path / "device.toml").unlink()  # init writes it
    assert main([*words, "--can-interface=virtual", f"--can-channel={channel}"]) == 0


def test_the_known_deviations(channel: str, pytester: pytest.Pytester) -> None:
    known = read_deviations(pytester.path / "known.toml")
    assert len(known) == 3
    cases = ("block-download.crc[1]", "matrix.block-download.segments[abort]")
    assert unknown_case(known, cases, RULES_BY_ID) is None


def test_the_settings(
    channel: str, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    printed = example("options.md", "# pyproject.toml")
    text, _, command = printed.partition("\n\nCANOPEN")
    (pytester.path / "pyproject.toml").write_text(text, encoding="utf-8")
    (pytester.path / "bench").mkdir()
    described = re.sub(r"\[can\][^[]*", "", (pytester.path / "drive.toml").read_text("utf-8"))
    (pytester.path / "bench" / "drive.toml").write_text(described, encoding="utf-8")
    shutil.copy(pytester.path / "drive.eds", pytester.path / "bench")
    *variables, pytest_, cases = f"CANOPEN{command}".split()
    assert pytest_ == "pytest"
    for name, value in (each.split("=") for each in variables):
        monkeypatch.setenv(name, value)
    result = pytester.runpytest_inprocess(cases, "--collect-only", "-k", FEW)
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["conformance: *target: node 7 on socketcan can1"])


def test_the_file_of_python_can(tmp_path: Path) -> None:
    path = tmp_path / "can.conf"
    path.write_text(example("options.md", "[default]"), encoding="utf-8")
    found = can.util.load_file_config(path)
    assert {"interface": "socketcand", "channel": "can0"}.items() <= found.items()
    assert re.fullmatch(r"\d+", found["port"])
