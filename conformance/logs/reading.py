"""Logs of a bus, as recorders write them: frame by frame, whatever the file holds.

Lines of ``candump -L``, and those that people paste, are read here, so that a bad one is told with
its number, and a log may be of any size, packed by gzip, or a pipe that still grows. All other
forms are read by python-can.
"""

import gzip
import io
import math
import re
import sqlite3
import struct
import sys
import zlib
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Protocol, cast

import can
from can.io.blf import BLFParseError

from conformance.bus.messages import to_frame
from conformance.device.files import shortened
from conformance.logs.pasted import is_no_frame, parse_pasted, plain
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.printable_text import inert

STANDARD_INPUT = "-"
# Formats that python-can knows by the end of the name; .gz may follow.
TEXT_READERS = {".asc": can.ASCReader, ".csv": can.CSVReader, ".trc": can.TRCReader}
# How those begin that python-can reads.
HEADS = {".asc": b"date", ".csv": b"timestamp,", ".trc": b";"}
SAVVY_HEAD = b"time stamp,id,"
BLOCKS = ".blf"
OTHER_FORMS = (*TEXT_READERS, BLOCKS, ".db", ".mf4")
PACKED = b"\x1f\x8b"
# A line of the longest frame that candump knows, CAN XL, has some 4200 bytes; an object in a BLF
# is a container of some 128 KiB.
LONGEST_LINE = 8192
LARGEST_BLOCK = 16 * 2**20
LARGEST_CONTAINER = 4 * 2**20
MOST_BLANK_LINES = 10_000
# Everything is followed for each bus by itself.
MOST_BUSES = 64
_LINE = re.compile(
    rb"\((\d{1,15}\.\d{1,9})\) +(\S{1,64}) +"
    rb"(?:([0-9A-Fa-f]{8})|([0-9A-Fa-f]{3}))"
    rb"#(?:((?:[0-9A-Fa-f]{2}){0,8})|(R)([0-8])?|(#\S*|[^\s:]*:\S*))"
    rb"(?:_[0-9A-Fa-f])?(?: +(\S{1,8}))?\s*"
)
_SENT = b"T"
_ERROR_FRAME = 0x20000000
# How an object of a BLF begins: signature, lengths, and its type.
_HEAD = struct.Struct("<4s8xL")
_CONTAINER = (b"LOBJ", 10)
_CONTAINER_HEAD = 16
_ZLIB = 2
# Exceptions of python-can's readers, besides its own, for a file of another format.
_UNREADABLE = (
    ArithmeticError, AttributeError, EOFError, LookupError, NotImplementedError, TypeError,
    ValueError, BLFParseError, can.CanError, sqlite3.Error, struct.error, zlib.error,
)  # fmt: skip


class LogError(ValueError):
    """A log cannot be read from some place on; the message names it."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A frame of the log: its number, from 1, its time in seconds, and the bus that it is from.

    The number is that of its line where the log has lines. ``sent`` is True where the line says
    that the recorder has sent the frame.
    """

    number: int
    time: float
    bus: str
    frame: CanFrame
    sent: bool = False


class Log(Protocol):
    """Frames in the order in which they were on a bus; ``unit`` is what their numbers count."""

    unit: str

    def __iter__(self) -> Iterator[Seen]:
        """Yield the frames, the first at time 0."""
        ...


class _Lines(io.TextIOWrapper):
    """Text for a reader of python-can, which would take any line into memory."""

    def __next__(self) -> str:  # type: ignore[override]
        line = self.readline(LONGEST_LINE)
        if not line:
            raise StopIteration
        if len(line) >= LONGEST_LINE:
            raise ValueError(f"a line of more than {LONGEST_LINE} characters")
        return line


class _Blocks(io.BufferedReader):
    """Bytes for a reader of python-can, which believes any length that stands in the file.

    Most objects of a BLF are containers, packed by zlib, which are read right behind their heads.
    """

    _in_container = False

    def read(self, size: int | None = -1, /) -> bytes:
        if size is None or not 0 <= size <= LARGEST_BLOCK:
            raise ValueError(f"an object of {size} bytes")
        data = super().read(size)
        if self._in_container:
            if len(data) < size:
                raise EOFError(f"an object of {size} bytes is cut off")
            _check_container(data)
        self._in_container = len(data) == _HEAD.size and _HEAD.unpack(data) == _CONTAINER
        return data


def _check_container(data: bytes) -> None:
    """Raise ValueError for a container that python-can would skip or unpack whatever comes."""
    method = int.from_bytes(data[:2], "little")
    if method == _ZLIB:
        unpacked = zlib.decompressobj().decompress(data[_CONTAINER_HEAD:], LARGEST_CONTAINER + 1)
        if len(unpacked) > LARGEST_CONTAINER:
            raise ValueError(f"a container of more than {LARGEST_CONTAINER} bytes")
    elif method:
        raise ValueError(f"a container that is packed by method {method}")


class RecordedLog:
    """The frames of a log; ``notes`` are sentences on what was left out, once it is read."""

    def __init__(self, name: str) -> None:
        """Take the name of a file, ``-`` for the standard input."""
        self._name = name
        self._begin: float | None = None
        self._buses: dict[object, str] = {}
        self._blank_lines = 0
        self.notes: list[str] = []
        suffixes = [suffix.lower() for suffix in Path(name).suffixes[-2:]]
        form = suffixes[-2:-1] if suffixes[-1:] == [".gz"] else suffixes[-1:]
        self._form = next((form for form in form if form in OTHER_FORMS), "")
        if self._form in HEADS and not self._has_head():
            self._form = ""
        self.unit = "frame" if self._form else "line"
        self._raw_time = self._time = 0.0
        self._has_deltas = False

    def _has_head(self) -> bool:
        """Say whether a log begins as python-can asks for; a part that was pasted does not."""
        if not Path(self._name).is_file():
            return True
        with ExitStack() as stack:
            try:
                first = plain(self._open(stack).readline(LONGEST_LINE))
            except (EOFError, zlib.error, gzip.BadGzipFile):
                return True
        # An empty file, and what is no text, are for python-can to refuse.
        known = parse_pasted(first) is not None or first.lower().startswith(SAVVY_HEAD)
        return not known or first.lower().startswith(HEADS[self._form])

    def __iter__(self) -> Iterator[Seen]:
        """Read the log, the first frame at time 0; raises LogError and OSError."""
        return self._by_reader() if self._form else self._by_lines()

    def _place(self, number: int) -> str:
        name = "standard input" if self._name == STANDARD_INPUT else self._name
        return f"{name}, {self.unit} {number}"

    def _seen(
        self, number: int, time: float, bus: object, frame: CanFrame, *, sent: bool = False
    ) -> Seen:
        if self._begin is None:
            self._begin = time
        if bus not in self._buses:
            if len(self._buses) >= MOST_BUSES:
                raise LogError(
                    f"{self._place(number)}: frames of more than {MOST_BUSES} interfaces, the last "
                    f"is {shortened(_text(bus))}: this is no log of a bench."
                )
            self._buses[bus] = inert(_text(bus))
        return Seen(number, time - self._begin, self._buses[bus], frame, sent)

    # candump -L

    def _by_lines(self) -> Iterator[Seen]:
        number = 0
        with ExitStack() as stack:
            file = self._open(stack)
            try:
                while line := file.readline(LONGEST_LINE):
                    number += 1
                    seen = self._line(number, line)
                    if seen is not None:
                        yield seen
            except (EOFError, zlib.error, gzip.BadGzipFile):
                # As a run leaves it that was killed.
                self.notes.append(f"{self._place(number)}: the packed log is cut off behind it")

    def _open(self, stack: ExitStack) -> BinaryIO:
        if self._name == STANDARD_INPUT:
            file = cast(io.BufferedReader, sys.stdin.buffer)
        elif Path(self._name).is_dir():
            raise LogError(
                f"{self._name} is a folder: name a log in it, such as the bus.log of a run."
            )
        else:
            file = stack.enter_context(open(self._name, "rb"))  # noqa: SIM115 - the stack is one
        if file.peek(len(PACKED))[: len(PACKED)] == PACKED:
            return cast(BinaryIO, stack.enter_context(gzip.GzipFile(fileobj=file)))
        return file

    def _line(self, number: int, line: bytes) -> Seen | None:
        """Return the frame of a line, None for one that is none of SDO or NMT; raises LogError."""
        found = _LINE.fullmatch(line)
        if found is None:
            return self._pasted(number, line)
        time, bus, long_id, short_id, data, remote, length, other, mark = found.groups()
        if data is not None and len(data) < 2 * FRAME_LENGTH and not line.endswith(b"\n"):
            self.notes.append(f"{self._place(number)}: the last line is cut off, and left out")
            return None
        can_id = int(long_id or short_id, 16)
        if other or (long_id and can_id & _ERROR_FRAME):  # CAN FD, CAN XL
            return None
        frame = CanFrame(
            can_id,
            bytes.fromhex(data.decode("ascii")) if data else b"",
            bool(long_id),
            bool(remote),
            int(length or 0) if remote else None,
        )
        return self._seen(number, float(time), bus, frame, sent=mark == _SENT)

    def _pasted(self, number: int, line: bytes) -> Seen | None:
        """Return the frame of a line of another form than that of candump -L."""
        content = plain(line)
        if content and _LINE.fullmatch(content) and content != line.strip():
            return self._line(number, content + b"\n")
        pasted = parse_pasted(content) if len(line) < LONGEST_LINE else None
        if pasted is None:
            if not is_no_frame(content):
                self._no_frame(number, line)
            return None
        return self._seen(
            number, self._moment(pasted.time), pasted.bus, pasted.frame, sent=pasted.sent
        )

    def _moment(self, time: float | None) -> float:
        """Return the time of a line; of what has none, that of the line before.

        What candump shows with -t d are differences: the first that is less than the one before it
        gives them away.
        """
        if time is None:
            return self._time
        if self._begin is None:
            self._raw_time = self._time = time
            return time
        self._has_deltas = self._has_deltas or time < self._raw_time
        self._time += time if self._has_deltas else time - self._raw_time
        self._raw_time = time
        return self._time

    def _no_frame(self, number: int, line: bytes) -> None:
        place = self._place(number)
        if not line.strip():
            self._blank_lines += 1
            if self._blank_lines > MOST_BLANK_LINES:
                raise LogError(
                    f"{place}: {self._blank_lines} lines are blank: this is no log of candump -L."
                )
            return
        if len(line) >= LONGEST_LINE:
            raise LogError(
                f"{place}: more than {LONGEST_LINE} bytes: this is no log of candump -L."
            )
        if not line.endswith(b"\n"):
            self.notes.append(f"{place}: the last line is cut off, and left out")
            return
        raise LogError(
            f"{place}: {shortened(_text(line.strip()))} is no frame as candump -L writes it, "
            "(1700000000.000000) can0 605#4000100000000000, nor one as candump shows it, nor a "
            "line of SavvyCAN's CSV, of a .trc or of an .asc file."
        )

    # Formats of python-can

    def _by_reader(self) -> Iterator[Seen]:
        number = 0
        try:
            with ExitStack() as stack:
                for number, message in enumerate(self._reader(stack), start=1):
                    if message.is_error_frame or message.is_fd:
                        continue
                    if not math.isfinite(message.timestamp):
                        raise ValueError("its time is no number")
                    yield self._seen(number, message.timestamp, message.channel, to_frame(message))
        except LogError:
            raise
        except _UNREADABLE as error:
            why = f"{error}" or type(error).__name__
            raise LogError(
                f"{self._place(number + 1)}: python-can cannot read on: {shortened(why)}"
            ) from error

    def _reader(self, stack: ExitStack) -> Iterable[can.Message]:
        if self._form in TEXT_READERS:
            lines = _Lines(self._open(stack), encoding="utf-8", errors="backslashreplace")
            return stack.enter_context(TEXT_READERS[self._form](lines))
        if self._form == BLOCKS:
            # A file that is packed is no raw one, but has all that is needed of one.
            blocks = _Blocks(cast(io.RawIOBase, self._open(stack)))
            return stack.enter_context(can.BLFReader(blocks))
        reader: can.io.generic.MessageReader = can.LogReader(self._name)
        return stack.enter_context(reader)


def _text(name: object) -> str:
    if isinstance(name, bytes):
        return name.decode("utf-8", "backslashreplace")
    # A bare number is no name of an interface.
    return f"can{name}" if isinstance(name, int) else str(name)
