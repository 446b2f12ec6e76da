"""What a run leaves to reproduce a failure does reproduce it."""

from pathlib import Path

import pytest
from plugin_runs import NODE_ID, hosted, self_test, the_report

from conformance.__main__ import main
from conformance.commands.status import DONE, NOT_ALLOWED
from conformance.faults.catalogue import build_node
from conformance.reporting.reproduction import FOLDER

pytest_plugins = ["pytester"]

FAULT = "upload-toggle-ignored"


@pytest.fixture
def log(pytester: pytest.Pytester) -> Path:
    """Return the log of the cause that a run on a faulty server has found."""
    self_test(pytester, "--sdo-simulated", f"--sdo-fault={FAULT}", "-k", "segmented-upload.toggle-")
    (path,) = (the_report(pytester) / FOLDER).iterdir()
    assert path.name == "01-segmented-upload.toggle.log"
    return path


@pytest.mark.parametrize(("server", "status"), [(FAULT, NOT_ALLOWED), (None, DONE)])
def test_a_failure_comes_again_until_it_is_gone(
    server: str | None, status: int, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    with hosted(build_node(server, NODE_ID)) as bus:
        assert main(["replay", str(log), "--writes", *bus]) == status
    assert ("segmented-upload.toggle (MUST)" in capsys.readouterr().out) == (server is not None)


def test_a_run_without_failures_has_nothing_to_reproduce(pytester: pytest.Pytester) -> None:
    self_test(pytester, "--sdo-simulated", "-k", "segmented-upload.toggle-first")
    assert not (the_report(pytester) / FOLDER).exists()
