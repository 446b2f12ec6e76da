"""Logs of every form that recorders write, and files that are none."""

import gzip
import io
import os
import struct
import sys
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import can
import pytest

from conformance.__main__ import main
from conformance.commands.status import BROKEN_BENCH, DONE, WRONG_USE
from conformance.logs import reading as recorded_logs
from conformance.logs.reading import LARGEST_CONTAINER, MOST_BLANK_LINES, LogError, RecordedLog

LINES = (
    "(1700000000.000100) can0 605#4018100100000000\n",
    "(1700000000.000200) can0 585#4318100104000000\n",
)
ASKED = "605#4018100100000000"


def read(path: Path) -> list[str]:
    return [str(seen.frame) for seen in RecordedLog(str(path))]


def written(tmp_path: Path, content: str | bytes, name: str = "bus.log") -> Path:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def refused(path: Path) -> str:
    with pytest.raises(LogError) as error:
        read(path)
    return str(error.value)


@pytest.mark.parametrize(
    ("line", "frame"),
    [
        ("(1.000000) can0 605#R", "605#R"),
        ("(1.000000) can0 605#R8", "605#R8"),
        ("(1.000000) can0 00000605#40", "00000605#40"),
        ("(1.000000)  vcan0  605#  R", "605#"),
        ("(1.0) can0 605#4000100000000000_9 T", "605#4000100000000000"),
        ("(1.0) can0 605##14000100000000000", None),
        ("(1.0) can0 20000088#0000000000000000", None),
        ("", None),
    ],
)
def test_lines_as_candump_writes_them(tmp_path: Path, line: str, frame: str | None) -> None:
    assert read(written(tmp_path, line + "\n")) == ([] if frame is None else [frame])


def test_a_frame_has_the_number_of_its_line_and_begins_at_time_0(tmp_path: Path) -> None:
    seen = list(RecordedLog(str(written(tmp_path, "\n" + "\n".join(LINES)))))
    assert [(one.number, round(one.time, 6)) for one in seen] == [(2, 0.0), (4, 0.0001)]


@pytest.mark.parametrize(
    "line",
    [
        "nonsense", "(1.0) can0", "(1.0) can0 605#4", "(1.0) can0 605#GG", "(x) can0 605#40",
        "(nan) can0 605#40", "(1.0) can0 6#40", "(1.0) can0 605#" + "00" * 9, "\x1b]0;title\x07",
    ],
)  # fmt: skip
def test_a_broken_line_is_named(tmp_path: Path, line: str) -> None:
    told = refused(written(tmp_path, f"{LINES[0]}{line}\n"))
    assert told.startswith(f"{tmp_path / 'bus.log'}, line 2: ")
    assert "is no frame as candump -L writes it" in told
    assert told.isprintable()


REQUEST, RESPONSE = "40 18 10 01 00 00 00 00", "43 18 10 01 04 00 00 00"
PASTED = {
    "candump": f"  can0  605   [8]  {REQUEST}\n  can0  585   [8]  {RESPONSE}   'C.......'\n",
    "candump -t a": (
        f" (1700000000.000100)  can0  605   [8]  {REQUEST}\n"
        f" (1700000000.000200)  can0  585   [8]  {RESPONSE}\n"
    ),
    "candump -t A": (
        f" (2023-11-14 22:13:20.000100)  can0  605   [8]  {REQUEST}\n"
        f" (2023-11-14 22:13:20.000200)  can0  585   [8]  {RESPONSE}\n"
    ),
    "candump -t d": (
        f" (000.000000)  can0  605   [8]  {REQUEST}\n (000.000100)  can0  585   [8]  {RESPONSE}\n"
    ),
    "candump -x": (
        f"  can0  TX - -  605   [8]  {REQUEST}\n  can0  RX - -  585   [8]  {RESPONSE}\n"
    ),
    "colours": f"\x1b[31m  can0  605   [8]\x1b[0m  {REQUEST}\n  can0  585   [8]  {RESPONSE}\n",
    "a byte order mark": "\ufeff" + "".join(LINES),
    "comments": f"# power on\n{LINES[0]}; then\n// and\n{LINES[1]}",
    "SavvyCAN": (
        "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n"
        f"1000,00000605,false,Tx,0,8,{REQUEST.replace(' ', ',')},\n"
        f"1100,00000585,false,Rx,0,8,{RESPONSE.replace(' ', ',')},\n"
    ),
    "trc 1.1": (
        f"     1)         0.1  Tx         0605  8  {REQUEST}\n"
        f"     2)         0.2  Rx         0585  8  {RESPONSE}\n"
    ),
    "trc 2.0": (
        f"      1         0.100 DT     0605 Tx 8  {REQUEST}\n"
        f"      2         0.200 DT     0585 Rx 8  {RESPONSE}\n"
    ),
    "asc": (
        f"   0.000100 1  605             Tx   d 8 {REQUEST}\n"
        f"   0.000200 1  585             Rx   d 8 {RESPONSE}  Length = 244000 BitCount = 124\n"
    ),
}


@pytest.mark.parametrize(("form", "text"), PASTED.items())
def test_logs_as_people_paste_them(tmp_path: Path, form: str, text: str) -> None:
    for ending in ("log", form.partition(" ")[0]):
        path = written(tmp_path, text, f"bus.{ending}")
        assert read(path) == [ASKED, "585#4318100104000000"]
    times = [seen.time for seen in RecordedLog(str(path))]
    has_times = form not in ("candump", "candump -x", "colours")
    assert times == pytest.approx([0.0, 0.0001 if has_times else 0.0], abs=2e-6)


def test_savvycan_writes_csv_as_python_can_does(tmp_path: Path) -> None:
    assert len(read(written(tmp_path, PASTED["SavvyCAN"], "bus.csv"))) == 2


def test_differences_of_time_are_added(tmp_path: Path) -> None:
    lines = [f" (000.{time:06})  can0  605   [8]  {REQUEST}\n" for time in (0, 5000, 1000, 2000)]
    times = [seen.time for seen in RecordedLog(str(written(tmp_path, "".join(lines))))]
    assert times == pytest.approx([0.0, 0.005, 0.006, 0.008])


@pytest.mark.parametrize(
    "line",
    [
        "  can0  605   [8]  40 18 10",
        "  can0  605   [9]  40 18 10 01 00 00 00 00 00",
        "1000,00000605,false,Tx,0,8,40,18",
        " (2023-13-14 22:13:20.000100) can0",
    ],
)
def test_a_line_that_is_cut_off_is_named_with_all_forms(tmp_path: Path, line: str) -> None:
    told = refused(written(tmp_path, f"{line}\n"))
    assert "line 1" in told
    assert "nor one as candump shows it, nor a line of SavvyCAN's CSV" in told


@pytest.mark.parametrize("cut", ["(1700000000.0003", "(1700000000.000300) can0 605#40181001"])
def test_a_last_line_that_is_cut_off_is_left_out(tmp_path: Path, cut: str) -> None:
    log = RecordedLog(str(written(tmp_path, "".join(LINES) + cut)))
    assert len(list(log)) == 2
    (note,) = log.notes
    assert note.endswith("line 3: the last line is cut off, and left out")


def test_a_last_line_that_is_whole_needs_no_line_end(tmp_path: Path) -> None:
    assert read(written(tmp_path, "".join(LINES).rstrip())) == [ASKED, "585#4318100104000000"]


class Endless(io.RawIOBase):
    """Zeros without end, and how many were taken."""

    taken = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: object) -> int:
        view = memoryview(buffer)  # type: ignore[arg-type]
        view[:] = bytes(len(view))
        self.taken += len(view)
        return len(view)


def test_of_a_line_without_end_little_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    endless = Endless()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BufferedReader(endless)))
    with pytest.raises(LogError, match="standard input, line 1: more than 8192 bytes"):
        list(RecordedLog("-"))
    assert endless.taken < 100_000


def test_a_log_of_no_bench_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each bus is followed by itself: memory stays flat."""
    monkeypatch.setattr(recorded_logs, "MOST_BUSES", 3)
    lines = "".join(f"(1.0) can{bus} {ASKED}\n" for bus in range(4))
    told = refused(written(tmp_path, lines))
    assert "line 4: frames of more than 3 interfaces, the last is 'can3'" in told


def test_packed_logs_and_pipes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    packed = gzip.compress("".join(LINES).encode())
    assert len(read(written(tmp_path, packed, "bus.log.gz"))) == 2
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BufferedReader(io.BytesIO(packed))))
    assert len(list(RecordedLog("-"))) == 2


def test_a_packed_log_that_is_cut_off_is_read_up_to_there(tmp_path: Path) -> None:
    packed = gzip.compress("".join(LINES * 500).encode())
    log = RecordedLog(str(written(tmp_path, packed[:-9], "bus.log.gz")))
    assert len(list(log)) > 900
    assert log.notes[0].endswith("the packed log is cut off behind it")


@pytest.mark.parametrize("name", ["bus.asc", "bus.blf", "bus.trc", "bus.csv", "bus.asc.gz"])
def test_what_python_can_writes(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with can.Logger(str(path)) as logger:
        for second, data in enumerate(("4018100100000000", "4318100104000000")):
            logger.on_message_received(
                can.Message(
                    timestamp=1.7e9 + second,
                    arbitration_id=0x605 - 0x80 * second,
                    data=bytes.fromhex(data),
                    is_extended_id=False,
                    channel=0,
                )
            )
    assert read(path) == [ASKED, "585#4318100104000000"]


@pytest.mark.parametrize("name", ["bus.asc", "bus.blf", "bus.trc", "bus.db", "bus.asc.gz"])
@pytest.mark.parametrize(
    "content", [b"", b"nonsense", b"\0" * 400, b"0.0 1 605 Rx d 8 xx\n" * 3, b"A" * 10_000]
)
def test_what_python_can_cannot_read_is_a_sentence(
    tmp_path: Path, name: str, content: bytes
) -> None:
    path = written(tmp_path, content, name)
    frames, told = [], str(path)
    try:
        frames = read(path)
    except LogError as error:
        told = str(error)
    assert not frames
    assert told.startswith(str(path))


def headed_by(size: int) -> bytes:
    """Return the beginning of a BLF whose first object says that it has ``size`` bytes."""
    head = b"LOGG" + (144).to_bytes(4, "little") + bytes(136)
    return head + b"LOBJ" + bytes([16, 0, 1, 0]) + size.to_bytes(4, "little") + bytes([10, 0, 0, 0])


@pytest.mark.parametrize("size", [0, 2**31])
def test_no_length_in_a_blf_is_believed(tmp_path: Path, size: int) -> None:
    path = written(tmp_path, headed_by(size) + bytes(100), "bus.blf")
    assert "frame 1: python-can cannot read on: 'an object of" in refused(path)


def blf(tmp_path: Path, body: bytes, *, cut: int = 0) -> Path:
    """Write a BLF whose only object is a container."""
    path = tmp_path / "bus.blf"
    with can.BLFWriter(str(path)):
        pass
    head = path.read_bytes()[:144]
    container = struct.pack("<4sHHLL", b"LOBJ", 16, 1, 16 + len(body), 10) + body
    path.write_bytes((head + container)[: -cut or None])
    return path


def packed(data: bytes, method: int = 2) -> bytes:
    return struct.pack("<H6xL4x", method, len(data)) + zlib.compress(data)


@pytest.mark.parametrize(
    ("body", "cut", "why"),
    [
        (packed(bytes(LARGEST_CONTAINER + 1)), 0, f"a container of more than {LARGEST_CONTAINER}"),
        (packed(bytes(100), method=9), 0, "a container that is packed by method 9"),
        (packed(bytes(100)), 7, "an object of 28 bytes is cut off"),
        (packed(bytes(100))[:20] + bytes(40), 0, "rror -3 while decompressing data"),
    ],
)
def test_a_container_of_a_blf_is_looked_at(tmp_path: Path, body: bytes, cut: int, why: str) -> None:
    sentence = refused(blf(tmp_path, body, cut=cut))
    assert "bus.blf, frame 1: python-can cannot read on: " in sentence
    assert why in sentence


def test_many_blank_lines_are_no_log(tmp_path: Path) -> None:
    blank = "\n" * MOST_BLANK_LINES
    assert len(read(written(tmp_path, blank + LINES[0]))) == 1
    assert f"{MOST_BLANK_LINES + 1} lines are blank" in refused(written(tmp_path, blank + "\n"))


def test_interface_names_are_made_inert(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, f"(1.0) can\x1b[31m0\u202e {ASKED}\n")
    for options in ((), ("--judge",)):
        assert main(["decode", *options, str(path)]) == DONE
        text = capsys.readouterr().out
        assert r"can\x1b[31m0\u202e" in text
        assert text.replace("\n", "").isprintable()


@pytest.mark.parametrize(
    ("prepared", "status"),
    [
        (lambda path: path.mkdir(), WRONG_USE),
        (lambda path: None, BROKEN_BENCH),
        (lambda path: path.write_bytes(b"\x80" * 10_000), WRONG_USE),
    ],
)
def test_what_is_no_log_is_a_sentence(
    prepared: Callable[[Path], None], status: int, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    path = tmp_path / "bus\x1b.log"
    prepared(path)
    assert main(["decode", "--judge", str(path)]) == status
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("conformance: ")
    assert line.isprintable()


@pytest.mark.parametrize(
    ("only", "shown"),
    [
        ((), ["000#8205", "000#0100", "705#00", "706#05", "085#1081010000000000", ASKED]),
        (("--node-id=5",), ["000#8205", "000#0100", "705#00", "085#1081010000000000", ASKED]),
        (("--node-id=6",), ["000#0100", "706#05"]),
    ],
)
def test_network_management_is_shown_in_words(
    only: tuple[str, ...], shown: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = ["000#8205", "000#0100", "705#00", "706#05", "085#1081010000000000", "6E5#00", ASKED]
    path = written(tmp_path, "".join(f"(1.0) can0 {frame}\n" for frame in frames))
    assert main(["decode", str(path), *only]) == DONE
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[3] for line in lines] == shown
    if "706#05" in shown:
        assert any(line.endswith("heartbeat of node 6: operational") for line in lines)


def test_a_folder_is_no_log(tmp_path: Path) -> None:
    assert refused(tmp_path).startswith(f"{tmp_path} is a folder: name a log in it")


def test_a_device_that_never_ends_is_no_log() -> None:
    assert refused(Path("/dev/zero")).startswith("/dev/zero, line 1: more than 8192 bytes")


def test_a_named_pipe_is_read_while_it_is_written(tmp_path: Path) -> None:
    pipe = tmp_path / "bus.fifo"
    os.mkfifo(pipe)
    with ThreadPoolExecutor(1) as pool:
        writing = pool.submit(pipe.write_text, "".join(LINES))
        assert read(pipe) == ["605#4018100100000000", "585#4318100104000000"]
        writing.result()
