"""The interface goes down while it is in use: everybody says so in a sentence and ends."""

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from conformance.plugin.exit_code import ExitCode
from conformance.reference.built_in_device import REFERENCE_OBJECTS
from conformance.run.case_files import CASES

from .programs import (
    QUIET,
    REFERENCE,
    lines,
    named,
    read_to_end,
    serving,
    set_interface,
    start_suite,
)


@pytest.fixture
def errors(tmp_path: Path) -> Path:
    """The file for what the server has to say on standard error."""
    return tmp_path / "errors"


@pytest.fixture
def server(errors: Path) -> Iterator[subprocess.Popen[str]]:
    """The reference server; afterwards the interface is up again."""
    with serving(*REFERENCE, errors=errors) as process:
        yield process
    set_interface("up")


def test_a_run_and_its_server_end(
    server: subprocess.Popen[str], errors: Path, tmp_path: Path
) -> None:
    cases = str(CASES / "test_segmented_upload.py")
    with start_suite(tmp_path / "reports", *named(REFERENCE_OBJECTS), cases) as process:
        begun = next(line for line in lines(process) if "PASSED" in line)
        set_interface("down")
        output = begun + read_to_end(process)
    assert process.returncode == ExitCode.BENCH_ERROR, output
    assert "socketcan vcan0 failed in the middle of the run: " in output
    assert "Network is down" in output
    assert "Bring it up" in output
    # One case has met it, and the rest is not tried; no traceback of python-can is shown.
    assert re.search(r"\b1 error in ", output), output
    assert "socketcan.py" not in output
    assert server.wait(QUIET) == 1
    assert re.fullmatch(r"conformance: .*Network is down.*\n", errors.read_text())
