"""The command that runs the fleet, with runs that are made up, and the bus that they have."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import fleet
import pytest
from fleet_results import Comparison, Outcome, Row
from fleet_run import socketcan, stand_in
from fleet_servers import ForeignServer, Unavailable

PASSED = Outcome("upload.bytes", "pass", "", "")
FAILED = Outcome("upload.size", "fail", "upload.size: other data", "expected 7 bytes")
KEPT_AWAY = Outcome("block-upload.size", "not testable", "upload.size: other data", "in the way")


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[tuple[str, list[str]]]]:
    """Let every run have these results; the list holds which were asked for."""

    def prepare(*results: Outcome) -> list[tuple[str, list[str]]]:
        asked = []

        def run(server: ForeignServer, *others: object) -> tuple[Row, Comparison]:
            asked.append((server.name, list(others[-1])))  # type: ignore[call-overload]
            if not results:
                raise Unavailable("needs cargo")
            return Row.of(server.name, results, 1), Comparison.of(results, ())

        monkeypatch.setattr(fleet, "run", run)
        return asked

    return prepare


def test_runs_the_servers_that_are_named(
    runs: Callable[..., list[tuple[str, list[str]]]], capsys: pytest.CaptureFixture[str]
) -> None:
    asked = runs(PASSED)
    assert fleet.main(["node", "durand", "--", "-k", "upload"]) == 0
    assert asked == [("node", ["-k", "upload"]), ("durand", ["-k", "upload"])]
    assert capsys.readouterr().out.count("1/1 100%") == 4


def test_what_is_not_judged_yet_is_a_complaint(
    runs: Callable[..., list[tuple[str, list[str]]]], capsys: pytest.CaptureFixture[str]
) -> None:
    runs(PASSED, FAILED)
    assert fleet.main(["node"]) == 1
    assert "node: other causes than judged right" in capsys.readouterr().out


def test_too_few_cases_that_reach_their_point_are_a_complaint(
    runs: Callable[..., list[tuple[str, list[str]]]], capsys: pytest.CaptureFixture[str]
) -> None:
    runs(PASSED, KEPT_AWAY)
    assert fleet.main(["node"]) == 1
    assert "node: 50% of the cases reach their point" in capsys.readouterr().out


def test_goes_on_without_a_server_that_cannot_be_had(
    runs: Callable[..., list[tuple[str, list[str]]]], capsys: pytest.CaptureFixture[str]
) -> None:
    asked = runs()
    assert fleet.main([]) == 1
    assert len(asked) == 6
    assert "crate zencan-node 0.0.5: needs cargo; left out" in capsys.readouterr().out


def test_knows_its_servers(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        fleet.main(["nodejs"])
    assert "no such server: nodejs" in capsys.readouterr().err


def test_says_that_there_is_no_such_interface() -> None:
    with pytest.raises(Unavailable, match="no CAN interface vcan77"), socketcan("vcan77"):
        pass


TALK = """
import can
filters = [{"can_id": 0x585, "can_mask": 0x7FF}]
with can.Bus("vcan0", interface="socketcan", can_filters=filters) as client:
    with can.Bus("vcan0", interface="socketcan") as server:
        client.send(can.Message(arbitration_id=0x605, data=b"request", is_extended_id=False))
        print(server.recv(5))
        server.send(can.Message(arbitration_id=0x705, data=b"x", is_extended_id=False))
        server.send(can.Message(arbitration_id=0x585, is_remote_frame=True, dlc=4,
                                is_extended_id=False))
        print(client.recv(5))
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
@pytest.mark.skipif(sys.platform != "linux", reason="stands in for SocketCAN")
def test_the_stand_in_carries_frames(tmp_path: Path) -> None:
    with stand_in(tmp_path) as bus:
        assert bus.channel == "vcan0"
        done = subprocess.run(  # noqa: S603 - it is our own
            [sys.executable, "-c", TALK],
            env=os.environ | dict(bus.environment),
            capture_output=True,
            text=True,
            check=False,
        )
    assert not done.stderr
    request, answer = done.stdout.splitlines()
    assert "ID:      605" in request
    assert "72 65 71 75 65 73 74" in request
    assert "ID:      585" in answer
    assert "R" in answer
