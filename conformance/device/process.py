"""The device as a program on this machine, and the command that brings a bench device back.

[process]
command = ["./my_server", "vcan0"]   # started for the run, stopped afterwards
recover = "./power-cycle.sh"         # for a bench device
"""

import os
import shlex
import signal
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from conformance.bus.errors import ProcessFailed
from conformance.sdo.inert import inert

# How long things may take, in seconds: to end when asked to, to recover a device, to start one.
END_LIMIT = 5.0
RECOVER_LIMIT = 60.0
START_LIMIT = 30.0
MOST_ATTEMPTS = 3
TAIL_LINES = 20
_TAIL_BYTES = 8192
# It waits for no group that has ended: to signal that fails, and so does the guard.
_GUARD = """
import os, signal, sys, time
limit, told = float(sys.argv[1]), sys.stdin.buffer.read()
if not told:
    sys.exit()
group = int(told)
os.killpg(group, signal.SIGTERM)
for _ in range(int(limit / 0.05)):
    time.sleep(0.05)
    os.killpg(group, 0)
os.killpg(group, signal.SIGKILL)
"""
NODE_ID = "{node_id}"


@dataclass(frozen=True, slots=True)
class ProcessSettings:
    """How a device is started and brought back; in both texts ``{node_id}`` is replaced.

    ``command`` is empty for a device that runs by itself; ``recover`` is None where nothing brings
    it back. It is tried ``attempts`` times whenever it is lost; to start takes at most
    ``start_limit`` seconds. Each is run in a folder of its own, None for the one that pytest was
    started in.
    """

    command: list[str] = field(default_factory=list)
    recover: str | None = None
    attempts: int = MOST_ATTEMPTS
    start_limit: float = START_LIMIT
    folder: Path | None = None
    recover_folder: Path | None = None

    @property
    def names_node_id(self) -> bool:
        """Whether the command says where the node-ID goes, which several devices need."""
        return any(NODE_ID in part for part in self.command)

    def of(self, node_id: int) -> "ProcessSettings":
        """Return the settings of one device."""
        return replace(
            self,
            command=[part.replace(NODE_ID, str(node_id)) for part in self.command],
            recover=None if self.recover is None else self.recover.replace(NODE_ID, str(node_id)),
        )


class DeviceProcess:
    """A device's program: started, stopped, its output kept in a file. A context manager."""

    def __init__(self, settings: ProcessSettings, log: Path) -> None:
        """``log`` takes what the program and the command to recover write."""
        self._settings = settings
        self._log = log
        self._process: subprocess.Popen[bytes] | None = None
        self._guard: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.stop()

    def start(self) -> None:
        """Start the program, if there is one; raises ProcessFailed."""
        command = self._settings.command
        if not command:
            return
        try:
            # It is there before the program: a run may be killed at any moment.
            self._guard = guard()
            with self._output() as log:
                # Ctrl-C at the terminal ends the run; the device has to live until its values are
                # put back.
                self._process = subprocess.Popen(  # noqa: S603 - it is what the user named
                    command,
                    cwd=self._settings.folder,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                )
            tell(self._guard, self._process.pid)
        except OSError as error:
            dismiss(self._guard)
            raise ProcessFailed(
                f"The device's program cannot be started: {shlex.join(command)}: {error.strerror}. "
                f"Check its path, which is relative to {self._settings.folder or Path.cwd()}."
            ) from error

    def stop(self) -> None:
        """Ask the program and what it has started to end, and end it if it does not."""
        process, self._process = self._process, None
        if process is None:
            return
        guard, self._guard = self._guard, None
        for how in (signal.SIGTERM, signal.SIGKILL):
            _signal_group(process, how)
            try:
                process.wait(END_LIMIT)
                break
            except subprocess.TimeoutExpired:
                continue
        dismiss(guard)

    def _output(self) -> BinaryIO:
        """Open the file that takes what is written; where that cannot be, nothing does."""
        try:
            return self._log.open("ab")
        except OSError:
            return Path(os.devnull).open("ab")

    def recover(self) -> None:
        """Run the command that brings a bench device back, if there is one."""
        if self._settings.recover is None:
            return
        try:
            with self._output() as log:
                subprocess.run(  # noqa: S603 - it is what the user named
                    shlex.split(self._settings.recover),
                    cwd=self._settings.recover_folder,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    timeout=RECOVER_LIMIT,
                    check=True,
                    start_new_session=True,  # Ctrl-C must not leave it half done
                )
        except (OSError, ValueError, subprocess.SubprocessError) as error:
            raise ProcessFailed(
                f"The command that recovers the device failed: {error}.{self.last_words()}"
            ) from error

    def check(self) -> None:
        """Raise ProcessFailed when the program has ended by itself."""
        if self._process is not None and self._process.poll() is not None:
            raise ProcessFailed(
                f"The device's program has ended with exit status {self._process.returncode} "
                f"before it answered: {shlex.join(self._settings.command)}.{self.last_words()}"
            )

    def tail(self) -> list[str]:
        """Return the last lines that were written; what would steer a terminal stands as text."""
        try:
            with self._log.open("rb") as log:
                log.seek(max(0, self._log.stat().st_size - _TAIL_BYTES))
                lines = log.read().decode("utf-8", "replace").splitlines()[-TAIL_LINES:]
                return [inert(line, keep="\t") for line in lines]
        except OSError:
            return []

    def last_words(self) -> str:
        """Return the last lines as the end of an error message."""
        lines = [f"    {line}" for line in self.tail()]
        return "\n".join([" Its output ends with:", *lines]) if lines else ""


def guard() -> subprocess.Popen[bytes] | None:
    """Start what ends a group of processes when this process is gone, however that has ended.

    It reads the number of the group, see ``tell``, from a pipe that ends with this process. None
    where no process can be started; what it is for needs none then.
    """
    try:
        return subprocess.Popen(  # noqa: S603 - it is our own
            [sys.executable, "-I", "-S", "-c", _GUARD, str(END_LIMIT)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError:
        return None


def tell(guard: subprocess.Popen[bytes] | None, group: int) -> None:
    """Tell a guard which group of processes it is for."""
    if guard is not None and guard.stdin is not None:
        guard.stdin.write(str(group).encode())
        guard.stdin.flush()


def dismiss(guard: subprocess.Popen[bytes] | None) -> None:
    """End a guard: there is nothing for it to do any more."""
    if guard is not None:
        guard.kill()
        guard.communicate()


def _signal_group(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        return
