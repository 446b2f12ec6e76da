"""How a program ends on Windows: the part for that system, run here with what it calls noted."""

import os
import runpy
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from conformance.device import programs

NUMBER = 4711
CTRL_BREAK = 1


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Mapping[str, Any]:
    """Return what the module defines there. The file ``calls`` has what taskkill was told."""
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0x200, raising=False)
    monkeypatch.setattr(signal, "CTRL_BREAK_EVENT", CTRL_BREAK, raising=False)
    defined = runpy.run_path(str(programs.__file__))
    monkeypatch.undo()
    program = tmp_path / "taskkill"
    program.write_text(f'#!/bin/sh\necho "$*" >> {tmp_path / "calls"}\n', encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setattr(signal, "CTRL_BREAK_EVENT", CTRL_BREAK, raising=False)
    return defined


def test_a_program_is_kept_from_the_keys_of_the_console(windows: Mapping[str, Any]) -> None:
    assert windows["APART"] == 0x200


def test_it_is_asked_and_then_ended_with_what_it_started(
    windows: Mapping[str, Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    sent: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "kill", lambda process, how: sent.append((process, how)))
    windows["ask_to_end"](NUMBER)
    assert sent == [(NUMBER, CTRL_BREAK)]
    windows["end"](NUMBER)
    assert (tmp_path / "calls").read_text(encoding="utf-8") == f"/T /F /PID {NUMBER}\n"


def test_the_guard_ends_it_when_the_suite_is_gone(
    windows: Mapping[str, Any], tmp_path: Path
) -> None:
    for told, calls in ((b"", False), (str(NUMBER).encode(), True)):
        command = (sys.executable, "-I", "-S", "-c", windows["_GUARD"], "5.0")
        subprocess.run(command, input=told, check=True)  # noqa: S603 - it is our own
        assert (tmp_path / "calls").exists() == calls
    assert (tmp_path / "calls").read_text(encoding="utf-8") == f"/T /F /PID {NUMBER}\n"


def test_backslashes_are_those_of_paths(windows: Mapping[str, Any]) -> None:
    command = r'"C:\my tools\server.exe" can0 --log=C:\logs\{node_id}'
    assert windows["words"](command) == [
        r"C:\my tools\server.exe", "can0", r"--log=C:\logs\{node_id}",
    ]  # fmt: skip
