"""A program with all that it starts: its words, how it is kept apart from this process, its end.

On POSIX it is a session of its own: a signal reaches its whole group, with orphans. Windows only
asks a group to end; there ``taskkill`` ends a program and its children.
"""

import os
import shlex
import signal
import subprocess
import sys
import time
from contextlib import suppress

# How long a program may take to end when it is asked to, in seconds.
END_LIMIT = 5.0
# Seconds between two looks whether it has.
LOOK = 0.02

if sys.platform == "win32":
    # An argument of Popen that keeps a program from the Ctrl-C of a terminal.
    APART = subprocess.CREATE_NEW_PROCESS_GROUP
    _GUARD = """
import subprocess, sys
told = sys.stdin.buffer.read().decode()
if told:
    subprocess.run(["taskkill", "/T", "/F", "/PID", told])
"""

    def words(command: str) -> list[str]:
        """Return the words of a command; backslashes belong to paths. Raises ValueError."""
        parts = shlex.split(command, posix=False)
        return [part[1:-1] if part[:1] == part[-1:] == '"' else part for part in parts]

    def ask_to_end(group: int) -> None:
        """Ask a program to end; the number is that of its process."""
        with suppress(OSError):
            os.kill(group, signal.CTRL_BREAK_EVENT)

    def end(group: int) -> None:
        """End a program and what it has started."""
        command = ("taskkill", "/T", "/F", "/PID", str(group))
        subprocess.run(command, capture_output=True, check=False)  # noqa: S603 - of the system

    def is_gone(group: int) -> bool:
        """Say whether nothing is left of a program that has ended: Windows does not say it."""
        del group
        return True

else:
    APART = 0
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

    def words(command: str) -> list[str]:
        """Return the words of a command as a shell reads them. Raises ValueError."""
        return shlex.split(command)

    def ask_to_end(group: int) -> None:
        """Ask a program and its children to end; the number is that of its process."""
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGTERM)

    def end(group: int) -> None:
        """End a program and what it has started."""
        with suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)

    def is_gone(group: int) -> bool:
        """Say whether no child of a program that has ended is running."""
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        return False


def wait_gone(group: int, seconds: float) -> bool:
    """Wait until nothing is left of a program that has ended; say whether that was reached.

    No event tells of the end of processes that are not one's own.
    """
    deadline = time.monotonic() + seconds
    while not is_gone(group):
        if time.monotonic() > deadline:
            return False
        time.sleep(LOOK)
    return True


def guard() -> subprocess.Popen[bytes] | None:
    """Start a guard that ends a program when this process is gone, in any way.

    It reads the number of the program, see ``tell``, from a pipe that ends with this process. None
    if no process can be started: then there is no program to guard either.
    """
    try:
        return subprocess.Popen(  # noqa: S603 - it is our own
            [sys.executable, "-I", "-S", "-c", _GUARD, str(END_LIMIT)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            creationflags=APART,
        )
    except OSError:
        return None


def tell(guard: subprocess.Popen[bytes] | None, group: int) -> None:
    """Tell a guard which program it is for."""
    if guard is not None and guard.stdin is not None:
        guard.stdin.write(str(group).encode())
        guard.stdin.flush()


def dismiss(guard: subprocess.Popen[bytes] | None) -> None:
    """End a guard: there is nothing for it to do any more."""
    if guard is not None:
        guard.kill()
        guard.communicate()
