"""The foreign devices as programs: they say when they serve, and end when they are told to."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

# Only a program that hangs takes this time, in seconds, on any machine.
HANGS = 600
PROGRAMS = ("canopen_server.py", "durand_server.py")


def start(program: str, *options: str) -> subprocess.Popen[str]:
    """Start a program that lies beside this file."""
    return subprocess.Popen(  # noqa: S603 - it is our own
        [sys.executable, str(Path(__file__).with_name(program)), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("stopping", [signal.SIGTERM, signal.SIGINT])
def test_serves_until_told_to_stop(program: str, stopping: signal.Signals) -> None:
    options = ("--node-id=7", "--can-interface=virtual", "--can-channel=alone")
    with start(program, *options) as process:
        assert process.stdout is not None
        first = process.stdout.readline()
        process.send_signal(stopping)
        rest, errors = process.communicate(timeout=HANGS)
    assert (first, rest, errors) == ("serving node 7 on virtual alone\n", "", "")
    assert process.returncode == 0


@pytest.mark.parametrize("program", PROGRAMS)
def test_says_when_there_is_no_such_interface(program: str) -> None:
    with start(program, "--can-interface=virtuel") as process:
        _, errors = process.communicate(timeout=HANGS)
    assert "python-can has no interface called 'virtuel'" in errors
    assert process.returncode == 2
