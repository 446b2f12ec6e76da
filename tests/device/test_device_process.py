"""A device's program: started, ended whatever it does, its output kept."""

import fcntl
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from conformance.bus.errors import ProcessFailed
from conformance.device import bounded_log, programs
from conformance.device.process import TAIL_LINES, DeviceProcess, ProcessSettings

# Only a program that hangs takes this time, in seconds, on any machine.
HANGS = 600.0
WAITS = """
import fcntl, time
held = open({lock!r}, "w")
fcntl.flock(held, fcntl.LOCK_EX)
print("ready", flush=True)
time.sleep(3600)
"""
STUBBORN = f"import signal\nsignal.signal(signal.SIGTERM, signal.SIG_IGN)\n{WAITS}"
PARENT = f"import subprocess, sys\nsubprocess.run([sys.executable, '-c', '''{WAITS}'''])"

# It ends when it is asked to, and what it has started does not.
LEAVES = f"""
import subprocess, sys, time
subprocess.Popen([sys.executable, '-c', '''{STUBBORN}'''])
time.sleep(3600)
"""


def program(text: str) -> ProcessSettings:
    return ProcessSettings([sys.executable, "-c", text])


def become(what: Callable[[], bool]) -> None:
    """Wait until something is so; what another process does is no event here."""
    deadline = time.monotonic() + HANGS
    while not what():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def is_free(lock: Path) -> bool:
    if not lock.exists():
        return True
    with lock.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


@pytest.mark.parametrize(
    "text", [WAITS, STUBBORN, PARENT, LEAVES], ids=["waits", "stubborn", "parent", "leaves"]
)
def test_it_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """Also one that does not want to, and what it has started itself."""
    monkeypatch.setattr(programs, "END_LIMIT", 0.3)
    log, lock = tmp_path / "log", tmp_path / "lock"
    with DeviceProcess(program(text.format(lock=str(lock))), log) as process:
        process.start()
        become(lambda: process.tail() == ["ready"])
        process.check()
        assert not is_free(lock)
    become(lambda: is_free(lock))


def test_one_that_ended_by_itself(tmp_path: Path) -> None:
    lines = TAIL_LINES + 5
    text = f"for n in range({lines}): print('line', n)\nraise SystemExit(7)"
    process = DeviceProcess(program(text), tmp_path / "log")
    process.start()
    said = []

    def has_ended() -> bool:
        try:
            process.check()
        except ProcessFailed as error:
            said.append(str(error))
        return bool(said)

    become(has_ended)
    assert "exit status 7" in said[0]
    assert said[0].endswith(f"    line {lines - 1}")
    assert process.tail() == [f"line {number}" for number in range(5, lines)]
    process.stop()


@pytest.mark.skipif(sys.platform == "win32", reason="no signal ends a program there")
def test_a_program_that_a_signal_ended_says_which(tmp_path: Path) -> None:
    text = "import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)"
    with DeviceProcess(program(text), tmp_path / "log") as process:
        process.start()
        become(lambda: process.ended == "The device's program was ended by SIGSEGV")


def test_what_it_writes_steers_no_terminal(tmp_path: Path) -> None:
    (tmp_path / "log").write_bytes(b"\x1b]0;title\x07\tgone\x1b[2J\n\xff\n")
    process = DeviceProcess(program("pass"), tmp_path / "log")
    assert process.tail() == ["\\x1b]0;title\\x07\tgone\\x1b[2J", "\ufffd"]


def test_the_output_of_all_starts_is_kept(tmp_path: Path) -> None:
    process = DeviceProcess(
        program("import os, time; os.write(1, b'hi\\n'); time.sleep(3600)"), tmp_path / "log"
    )
    process.start()
    become(lambda: process.tail() == ["hi"])
    process.stop()
    process.start()
    become(lambda: process.tail() == ["hi", "hi"])
    process.stop()


def test_nothing_to_start_and_nothing_to_recover(tmp_path: Path) -> None:
    process = DeviceProcess(ProcessSettings(), tmp_path / "log")
    process.start()
    process.check()
    process.recover()
    process.stop()
    assert not (tmp_path / "log").exists()


@pytest.mark.parametrize("command", ["./no-such-command", "false"])
def test_a_command_that_does_not_recover(tmp_path: Path, command: str) -> None:
    process = DeviceProcess(ProcessSettings(recover=[command]), tmp_path / "log")
    with pytest.raises(ProcessFailed, match="recovers the device failed"):
        process.recover()


def test_the_node_id_stands_where_it_should() -> None:
    settings = ProcessSettings(["./server", "--node={node_id}"], ["./power", "{node_id}"])
    assert settings.names_node_id
    assert settings.of(9) == ProcessSettings(["./server", "--node=9"], ["./power", "9"])
    assert not ProcessSettings(["./server"]).names_node_id


GUARDED = """
import sys, time
from pathlib import Path
from conformance.device.process import DeviceProcess, ProcessSettings
process = DeviceProcess(ProcessSettings([sys.executable, "-c", sys.argv[1]]), Path("log"))
process.start()
Path("started").touch()
time.sleep(3600)
"""


def test_no_program_outlives_a_suite_that_is_killed(tmp_path: Path) -> None:
    log, lock = tmp_path / "log", tmp_path / "lock"
    program_of_device = WAITS.format(lock=str(lock))
    with subprocess.Popen(  # noqa: S603 - it is our own
        [sys.executable, "-c", GUARDED, program_of_device], cwd=tmp_path
    ) as suite:
        become(lambda: log.exists() and log.read_bytes() == b"ready\n")
        # The program may be ready before it is known to what ends it behind a suite that is gone.
        become((tmp_path / "started").exists)
        assert not is_free(lock)
        suite.kill()
    become(lambda: is_free(lock))


def test_a_log_that_cannot_be_written_stops_no_device(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    gone = tmp_path / "gone" / "log"
    with DeviceProcess(program(WAITS.format(lock=str(lock))), gone) as process:
        process.start()
        become(lambda: not is_free(lock))
        assert process.tail() == []


def test_the_log_has_a_bound(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounded_log, "MOST", 300_000)
    monkeypatch.setattr(bounded_log, "BEGINNING", 1_000)
    text = "print('first')\nfor n in range(20_000): print('a line of the output', n)\nprint('last')"
    process = DeviceProcess(program(text), tmp_path / "log")
    process.start()
    become(lambda: process.tail()[-1:] == ["last"])
    process.stop()
    kept = (tmp_path / "log").read_bytes()
    assert len(kept) <= 300_000 + bounded_log.CHUNK
    assert kept.startswith(b"first\n")
    assert bounded_log.LEFT_OUT in kept
