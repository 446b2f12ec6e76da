"""A file that grows line by line, and never stops what is being reported on.

A full disk is no failure of a device. What could not be written is kept in memory, and tried again
with each line.
"""

import os
from contextlib import suppress
from pathlib import Path

# Bytes that wait for room: of a file that must be whole, and of one of which a part will do.
UNLIMITED = None


class GrowingFile:
    """Appends bytes to a new file."""

    def __init__(self, path: Path, most_waiting: int | None = UNLIMITED) -> None:
        """Begin the file anew. Of what cannot be written, ``most_waiting`` bytes are kept."""
        self._path = path
        self._error: OSError | None = None
        self._lost = 0
        self._most_waiting = most_waiting
        self._waiting = bytearray()
        self._descriptor: int | None = None
        self._open()

    def _open(self) -> None:
        # A link that was put there would lead elsewhere.
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_NOFOLLOW", 0)
        try:
            self._descriptor = os.open(self._path, flags | getattr(os, "O_BINARY", 0), 0o666)
        except OSError as error:
            self._error = self._error or error

    @property
    def trouble(self) -> str:
        """Say that the file is not whole, or not where it was, and why; empty when all is well."""
        self.append(b"")
        if not self._waiting and not self._lost and self._is_there():
            return ""
        return f"{self._path} could not be written: {self._error or 'it has gone away'}"

    def _is_there(self) -> bool:
        """Whether the file has still its place: its folder may have gone away."""
        if self._descriptor is None:
            return False
        try:
            return os.path.samestat(os.fstat(self._descriptor), self._path.stat())
        except OSError:
            return False

    def append(self, data: bytes) -> None:
        """Write some bytes, and what waits before them; what cannot be written waits."""
        self._waiting += data
        if self._descriptor is not None:
            try:
                while self._waiting:
                    del self._waiting[: os.write(self._descriptor, self._waiting)]
            except OSError as error:
                self._error = self._error or error
        most = self._most_waiting
        if most is not None and len(self._waiting) > most:
            self._lost += len(self._waiting) - most
            del self._waiting[most:]

    def close(self) -> str:
        """Write what waits, if there is room now, and close the file; return its ``trouble``."""
        trouble = self.trouble
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            with suppress(OSError):
                os.close(descriptor)
        return trouble
