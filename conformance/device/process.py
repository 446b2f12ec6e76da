"""The device as a program on this machine, and the command that brings a bench device back.

[process]
command = ["./my_server", "vcan0"]   # started for the run, stopped afterwards
recover = "./power-cycle.sh"         # for a bench device
"""

import shlex
import signal
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import TracebackType
from typing import Self

from conformance.bus.errors import ProcessFailed
from conformance.device import programs
from conformance.device.bounded_log import BoundedLog
from conformance.device.effort import TRIES_OF_PROGRAM
from conformance.sdo.printable_text import inert

# How long things may take, in seconds: to recover a device, to start one.
RECOVER_LIMIT = 60.0
START_LIMIT = 30.0
TAIL_LINES = 20
_TAIL_BYTES = 8192
NODE_ID = "{node_id}"


@dataclass(frozen=True, slots=True)
class ProcessSettings:
    """How a device is started and brought back; in both commands ``{node_id}`` is replaced.

    ``command`` is empty for a device that runs by itself; ``recover`` is None where nothing brings
    it back. It is tried ``attempts`` times whenever it is lost; to start takes at most
    ``start_limit`` seconds. Each is run in a folder of its own, None for the one that pytest was
    started in.
    """

    command: list[str] = field(default_factory=list)
    recover: list[str] | None = None
    attempts: int = TRIES_OF_PROGRAM
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
            command=_named(self.command, node_id),
            recover=None if self.recover is None else _named(self.recover, node_id),
        )


class DeviceProcess:
    """A device's program: started, stopped, its output kept in a file. A context manager."""

    def __init__(self, settings: ProcessSettings, log: Path) -> None:
        """``log`` takes the output of the program and of the command to recover."""
        self._settings = settings
        self._log = BoundedLog(log)
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
            self._guard = programs.guard()
            with self._log.taking() as log:
                # Ctrl-C at the terminal ends the run; the device has to live until its values are
                # put back.
                self._process = subprocess.Popen(  # noqa: S603 - it is what the user named
                    command,
                    cwd=self._settings.folder,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    start_new_session=True,
                    creationflags=programs.APART,
                )
            programs.tell(self._guard, self._process.pid)
        except OSError as error:
            programs.dismiss(self._guard)
            raise ProcessFailed(
                f"The device's program cannot be started: {shlex.join(command)}: {error.strerror}. "
                f"Check its path, which is relative to {self._settings.folder or Path.cwd()}."
            ) from error

    def stop(self) -> None:
        """Ask the program and its children to end, and end them if they do not."""
        process, self._process = self._process, None
        if process is None:
            return
        guard, self._guard = self._guard, None
        for how in (programs.ask_to_end, programs.end):
            how(process.pid)
            try:
                process.wait(programs.END_LIMIT)
            except subprocess.TimeoutExpired:
                continue
            if programs.wait_gone(process.pid, programs.END_LIMIT):
                break
        programs.dismiss(guard)
        self._log.settle()

    def recover(self) -> None:
        """Run the command that brings a bench device back, if there is one."""
        if self._settings.recover is None:
            return
        try:
            with self._log.taking() as log:
                subprocess.run(  # noqa: S603 - it is what the user named
                    self._settings.recover,
                    cwd=self._settings.recover_folder,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    timeout=RECOVER_LIMIT,
                    check=True,
                    start_new_session=True,  # Ctrl-C must not leave it half done
                    creationflags=programs.APART,
                )
        except (OSError, subprocess.SubprocessError) as error:
            raise ProcessFailed(
                f"The command that recovers the device failed: {error}.{self.last_words()}"
            ) from error

    def check(self) -> None:
        """Raise ProcessFailed when the program has ended by itself."""
        if ended := self.ended:
            raise ProcessFailed(
                f"{ended} before it answered: {shlex.join(self._settings.command)}."
                f"{self.last_words()}"
            )

    @property
    def ended(self) -> str:
        """How the program has ended by itself, as the beginning of a sentence; empty if it runs."""
        status = None if self._process is None else self._process.poll()
        if status is None:
            return ""
        if status < 0:
            return f"The device's program was ended by {_signal(-status)}"
        return f"The device's program has ended with exit status {status}"

    def tail(self) -> list[str]:
        """Return the last lines of the output; control characters stand as text."""
        try:
            with self._log.path.open("rb") as log:
                log.seek(max(0, self._log.path.stat().st_size - _TAIL_BYTES))
                lines = log.read().decode("utf-8", "replace").splitlines()[-TAIL_LINES:]
                return [inert(line, keep="\t") for line in lines]
        except OSError:
            return []

    def last_words(self) -> str:
        """Return the last lines as the end of an error message."""
        self._log.settle()
        lines = [f"    {line}" for line in self.tail()]
        return "\n".join([" Its output ends with:", *lines]) if lines else ""


def _signal(number: int) -> str:
    """Return the name of a signal, such as SIGSEGV."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _named(command: Sequence[str], node_id: int) -> list[str]:
    return [part.replace(NODE_ID, str(node_id)) for part in command]
