"""The file for the output of a device's program: its beginning and its end, of any length."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

# The bytes of a log, and of its beginning, which stays.
MOST, BEGINNING = 10_000_000, 1_000_000
LEFT_OUT = b"\n[the output was too long: a part of it is left out here]\n"
# Bytes of one read.
CHUNK = 1 << 16
# How many seconds the output of a program that has ended may take to be there.
SETTLING = 1.0


class BoundedLog:
    """Takes the output of programs by pipes; where the file cannot be written, it goes nowhere."""

    def __init__(self, path: Path) -> None:
        """``path`` is added to."""
        self.path = path
        self._lock = threading.Lock()
        self._file: FileIO | None = None
        self._latest: threading.Thread | None = None

    @contextmanager
    def taking(self) -> Iterator[int]:
        """Within this, start a program with the file descriptor as its output."""
        source, output = os.pipe()
        self._latest = threading.Thread(target=self._pump, args=(source,), daemon=True)
        self._latest.start()
        try:
            yield output
        finally:
            os.close(output)

    def settle(self) -> None:
        """Wait for the output of a program that has ended; programs that it started may go on."""
        if self._latest is not None:
            self._latest.join(SETTLING)

    def _pump(self, source: int) -> None:
        try:
            self._open()
            while data := os.read(source, CHUNK):
                self._write(data)
        finally:
            os.close(source)

    def _open(self) -> None:
        with self._lock:
            if self._file is None:
                try:
                    self._file = FileIO(self.path, "ab")
                except OSError:
                    return

    def _write(self, data: bytes) -> None:
        with self._lock:
            if self._file is None:
                return
            try:
                self._file.write(data)
                if self._file.tell() > MOST:
                    self._file.truncate(BEGINNING)
                    self._file.write(LEFT_OUT + data)
            except OSError:
                self._file = None  # a disk that is full must not stop the device
