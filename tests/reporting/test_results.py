"""results.jsonl: each line as it comes, read back whatever became of the run."""

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from junit_schema import breaches
from reporting_results import ABOUT, DEVICE, END, PASSED, result

from conformance.reporting import recorded as module
from conformance.reporting.appending import GrowingFile
from conformance.reporting.bus_log import Place
from conformance.reporting.recorded import NotRecorded, read_run
from conformance.reporting.report import write_reports
from conformance.reporting.results import RESULTS, ResultsFile
from conformance.run.trace import TraceLine
from conformance.run.verdict import Verdict

PLACE = Place("bus.log", 3, 7)
CASES = [
    result(node_id=9),
    result(Verdict.FAIL, actual="\ud800 \x00 ü", trace=[TraceLine("a"), TraceLine("b")]),
]


def recorded(folder: Path, *, end: bool = True) -> ResultsFile:
    file = ResultsFile(folder)
    file.run(ABOUT)
    file.selected(3)
    file.device(DEVICE)
    for case in CASES:
        file.case(case, PLACE)
    if end:
        file.end(END)
    return file


def test_what_was_written_is_read_before_the_file_is_closed(tmp_path: Path) -> None:
    recorded(tmp_path)
    run = read_run(tmp_path)
    assert (run.results, run.places, run.selected) == (CASES, [PLACE, PLACE], 3)
    assert run.by_device == CASES[::-1]
    assert run.properties == {
        **ABOUT["properties"],
        "vendor-id": "0x0000012E",
        "not-restored": "x",
    }
    assert (run.broken_off, run.troubles) == ("", [])


def test_a_run_that_was_killed_at_any_byte(tmp_path: Path) -> None:
    """Each case whose line is whole is there; the rest of a line is none."""
    recorded(tmp_path).close()
    path = tmp_path / RESULTS
    whole = path.read_bytes()
    first = whole.index(b"\n") + 1
    for size in range(first, len(whole), 7):
        path.write_bytes(whole[:size])
        run = read_run(tmp_path)
        assert len(run.results) == whole[:size].count(b'"record": "case"') - (
            b'"record": "case"' in whole[:size].rpartition(b"\n")[2]
        )
        assert "the run was killed" in run.broken_off
    path.write_bytes(whole[: first - 1])
    with pytest.raises(NotRecorded, match="does not begin with"):
        read_run(tmp_path)


def test_the_report_of_a_run_that_was_killed_says_so(tmp_path: Path) -> None:
    """As an error: what is left of it must not look like a run that has passed."""
    recorded(tmp_path, end=False)
    path, *_ = write_reports(tmp_path, read_run(tmp_path))
    text = path.read_text(encoding="utf-8")
    assert 'message="the run was killed: its record has no end. 2 of 3 cases were finished"' in text
    assert 'errors="1"' in text
    assert breaches(ElementTree.parse(path).getroot()) == []  # noqa: S314 - it is our own file


def test_a_bench_error_that_no_case_shows(tmp_path: Path) -> None:
    file = recorded(tmp_path, end=False)
    file.end({**END, "bench_errors": ["can0 failed", "can0 failed"]})
    path, *_ = write_reports(tmp_path, read_run(tmp_path))
    text = path.read_text(encoding="utf-8")
    assert text.count('message="can0 failed"') == 1


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"{", "line 2 is no line of a record"),
        (b"[]", "line 2 is no line of a record"),
        (b'{"record": "case"}', "line 2 cannot be read"),
        (b'{"record": "case", "result": {"colour": 1}}', "line 2 cannot be read"),
    ],
)
def test_a_broken_line_is_named(tmp_path: Path, line: bytes, why: str) -> None:
    file = ResultsFile(tmp_path)
    file.run(ABOUT)
    with (tmp_path / RESULTS).open("ab") as broken:
        broken.write(line + b"\n")
    with pytest.raises(NotRecorded, match=why):
        read_run(tmp_path)


def test_records_of_a_later_version_are_passed_over(tmp_path: Path) -> None:
    ResultsFile(tmp_path).run(ABOUT)
    with (tmp_path / RESULTS).open("ab") as later:
        later.write(b'{"record": "colour"}\n')
    assert read_run(tmp_path).results == []


def test_a_folder_without_a_record(tmp_path: Path) -> None:
    with pytest.raises(NotRecorded, match="no record of a run"):
        read_run(tmp_path)


def test_another_format(tmp_path: Path) -> None:
    (tmp_path / RESULTS).write_text('{"record": "run", "format": 4}\n', encoding="utf-8")
    with pytest.raises(NotRecorded, match="has format 4"):
        read_run(tmp_path)


# What cannot be written


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_raises_nothing() -> None:
    file = GrowingFile(Path("/dev/full"), most_waiting=4)
    file.append(b"123456")
    assert "No space left" in file.trouble
    assert "No space left" in file.close()


class OftenFull:
    """Writes a part of what it is handed, and sometimes nothing."""

    def __init__(self) -> None:
        self.calls = 0
        self.written = b""

    def __call__(self, descriptor: int, data: bytes) -> int:
        self.calls += 1
        if self.calls % 3 == 0:
            raise OSError(28, "No space left on device")
        self.written += bytes(data[:2])
        return min(2, len(data))


def test_what_waits_is_written_when_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, disk = GrowingFile(tmp_path / "file"), OftenFull()
    monkeypatch.setattr(os, "write", disk)
    due = b""
    for number in range(20):
        file.append(b"%d\n" % number)
        due += b"%d\n" % number
    while file.trouble:
        assert due.startswith(disk.written)
    assert disk.written == due


def test_a_folder_that_goes_away(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    file = recorded(folder)
    assert file.trouble == ""
    folder.rename(tmp_path / "elsewhere")
    assert file.trouble.endswith("it has gone away")


def test_no_link_is_followed(tmp_path: Path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("kept", encoding="utf-8")
    (tmp_path / RESULTS).symlink_to(precious)
    assert ResultsFile(tmp_path).trouble
    assert precious.read_text(encoding="utf-8") == "kept"


def test_passed_is_one_line(tmp_path: Path) -> None:
    ResultsFile(tmp_path).case(PASSED)
    assert (tmp_path / RESULTS).read_bytes().count(b"\n") == 1


HOSTILE = {
    "no JSON": "nonsense",
    "no object": "[1, 2]",
    "no run": '{"record": "case"}',
    "no format": '{"record": "run"}',
    "no devices": '{"record": "run", "format": 1}',
    "deep": "[" * 100_000,
    "no case": '{"record": "run", "format": 1, "node_ids": [5], "properties": {}}\n'
    '{"record": "case", "result": {"case_id": 5}}',
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_what_is_no_record_is_a_sentence(tmp_path: Path, text: str) -> None:
    (tmp_path / RESULTS).write_text(text + "\n", encoding="utf-8")
    with pytest.raises(NotRecorded, match=rf"{RESULTS}\b.*(line \d+|does not begin|has format)"):
        read_run(tmp_path)


def test_of_a_line_without_end_little_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LONGEST_LINE", 1000)
    (tmp_path / RESULTS).write_bytes(bytes(5000))
    with pytest.raises(NotRecorded, match="line 1 has more than 1000 bytes"):
        read_run(tmp_path)
