"""``conformance decode`` on a bus that runs, and with the names of objects from an EDS."""

import signal
from collections.abc import Callable
from pathlib import Path

import can
import pytest
from can.interfaces.virtual import VirtualBus

from conformance.__main__ import main
from conformance.bus.opening import BusSettings
from conformance.commands import decode
from conformance.commands.status import BROKEN_BENCH, DONE, NOT_ALLOWED, WRONG_USE
from conformance.device.eds_listing import ListedObject, Listing, ObjectType
from conformance.device.known_objects import KnownObject
from conformance.logs.object_names import ObjectNames
from conformance.run.bench import private_channel
from conformance.sdo.layout import Multiplexer

RIGHT = ("605#4018100100000000", "585#4318100104000000")
WRONG = ("605#4018100100000000", "585#6018100100000000")
FILES = Path(__file__).parent.parent / "eds" / "files"
EDS = f"--eds={FILES / 'io_module.eds'}"


class Running(VirtualBus):
    """A bus on which frames come, and then a signal to the program; nothing may be sent there."""

    frames: tuple[str, ...] = ()
    signal = signal.SIGINT

    def recv(self, timeout: float | None = None) -> can.Message | None:
        if not self.frames:
            signal.raise_signal(self.signal)
            return None
        (can_id, _, data), self.frames = self.frames[0].partition("#"), self.frames[1:]
        return can.Message(
            arbitration_id=int(can_id, 16), data=bytes.fromhex(data), is_extended_id=False
        )

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise AssertionError("something was sent")


@pytest.fixture
def running(monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """Return a function that decodes a bus on which these frames come."""

    def run(frames: tuple[str, ...], *options: str, by: signal.Signals = signal.SIGINT) -> int:
        bus = Running(private_channel())
        bus.frames, bus.signal = frames, by

        def opened(settings: BusSettings) -> can.BusABC:
            assert settings.channel == "can7"
            return bus

        monkeypatch.setattr(decode, "open_bus", opened)
        return main(["decode", "--can-channel=can7", *options])

    return run


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_frames_are_shown_until_a_signal(
    by: signal.Signals, running: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    assert running((*RIGHT, "6E5#00"), by=by) == DONE
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before
    told = capsys.readouterr()
    assert told.err == "listening on socketcan can7 until Ctrl-C\n"
    asked, answered = told.out.splitlines()
    assert asked == "       0.0 ms can7 605#4018100100000000 node 5: upload initiate 1018h:01"
    assert answered.endswith("upload initiate response 1018h:01, expedited, 4 bytes: 04 00 00 00")


@pytest.mark.parametrize(("frames", "status"), [(RIGHT, DONE), (WRONG, NOT_ALLOWED)])
def test_a_bus_is_judged_while_it_runs(
    frames: tuple[str, ...],
    status: int,
    running: Callable[..., int],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A response before shows that no transfer is open."""
    assert running((*RIGHT, *frames), "--judge") == status
    told = capsys.readouterr().out
    assert ("1 not allowed" in told) == (status == NOT_ALLOWED)
    assert "can7, node 5: 2 requests, 2 responses" in told


@pytest.mark.parametrize("arguments", [[], ["bus.log", "--can-channel=can0"]])
def test_a_log_or_a_bus(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["decode", *arguments]) == WRONG_USE
    assert "either a log, or a bus" in capsys.readouterr().err


def test_a_bus_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["decode", "--can-channel=nowhere0"]) == BROKEN_BENCH
    assert "nowhere0 cannot be opened" in capsys.readouterr().err


def test_objects_have_the_names_of_an_eds(
    running: Callable[..., int], capsys: pytest.CaptureFixture[str]
) -> None:
    assert running((*RIGHT, "605#40FF5F0200000000"), EDS) == DONE
    asked, _, other = capsys.readouterr().out.splitlines()
    assert asked.endswith("upload initiate 1018h:01 (Identity object, Vendor-ID)")
    assert other.endswith("upload initiate 5FFFh:02")


def test_a_judgement_names_them_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "a.log"
    log.write_text("".join(f"(1.0) can0 {frame}\n" for frame in (*RIGHT, *WRONG)))
    assert main(["decode", "--judge", EDS, str(log)]) == NOT_ALLOWED
    assert "1018h:01 (Identity object, Vendor-ID)" in capsys.readouterr().out


def test_a_name_is_inert() -> None:
    entry = KnownObject(Multiplexer(0x2001), name="Speed\x1b[31m")
    listed = ListedObject(0x2001, ObjectType.VAR, {0: entry}, name="Speed\x1b[31m")
    names = ObjectNames(Listing({0x2001: listed}))
    assert names.in_line("abort 2001h:00, 2001h:01") == (
        "abort 2001h:00 (Speed\\x1b[31m), 2001h:01"
    )
