"""``conformance report --zip``: a report folder as one file, with checksums."""

import hashlib
from pathlib import Path
from zipfile import ZipFile

import pytest
from reporting_results import ABOUT, DEVICE, END, result

from conformance.__main__ import main
from conformance.commands.status import BROKEN_BENCH, DONE, WRONG_USE
from conformance.reporting import archive
from conformance.reporting.archive import SUMS, write_archive
from conformance.reporting.results import ResultsFile


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Make the report folder of a run."""
    folder = tmp_path / "run"
    folder.mkdir()
    file = ResultsFile(folder)
    file.run(ABOUT)
    file.device(DEVICE)
    file.case(result())
    file.end(END)
    file.close()
    (folder / "bus.log").write_text("(1.000000) can0 605#4000100000000000 T\n")
    return folder


def sums_of(packed: ZipFile) -> tuple[dict[str, str], str]:
    """Return the checksums in an archive by file, and its last line."""
    *lines, last = packed.read(f"run/{SUMS}").decode().splitlines()
    return {name: digest for digest, name in (line.split("  ") for line in lines)}, last


def test_everything_is_in_it_with_its_checksum(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", "--zip", str(folder)]) == DONE
    path = folder.with_name("run.zip")
    assert capsys.readouterr().out.splitlines()[-1] == f"written: {path}"
    with ZipFile(path) as packed:
        sums, last = sums_of(packed)
        names = [name for name in packed.namelist() if not name.endswith(SUMS)]
        contents = {name.removeprefix("run/"): packed.read(name) for name in names}
    assert {"bus.log", "junit.xml", "report.html", "results.jsonl"} <= contents.keys()
    assert sums == {name: hashlib.sha256(data).hexdigest() for name, data in contents.items()}
    assert contents["bus.log"] == (folder / "bus.log").read_bytes()
    assert last == f"# complete: {len(contents)} files"


def test_folders_within_are_packed_and_what_leads_elsewhere_is_not(
    folder: Path, tmp_path: Path
) -> None:
    (folder / "reproduce").mkdir()
    (folder / "reproduce" / "01-x.log").write_text("x")
    (tmp_path / "private").write_text("x")
    (folder / "link").symlink_to(tmp_path / "private")
    with ZipFile(write_archive(folder)) as packed:
        sums, _ = sums_of(packed)
    assert sorted(sums) == ["bus.log", "reproduce/01-x.log", "results.jsonl"]


def test_an_archive_that_was_unpacked_is_packed_again(folder: Path, tmp_path: Path) -> None:
    with ZipFile(write_archive(folder)) as packed:
        before = sums_of(packed)
        packed.extractall(tmp_path / "unpacked")
    with ZipFile(write_archive(tmp_path / "unpacked" / "run")) as packed:
        assert sums_of(packed) == before


def test_half_an_archive_does_not_stay(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object) -> str:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(archive, "_pack", fail)
    assert main(["report", "--zip", str(folder)]) == BROKEN_BENCH
    assert "No space left" in capsys.readouterr().err
    assert [path.name for path in folder.parent.iterdir()] == ["run"]


def test_another_folder_is_not_packed(tmp_path: Path) -> None:
    assert main(["report", "--zip", str(tmp_path)]) == WRONG_USE
    assert not tmp_path.with_name(f"{tmp_path.name}.zip").exists()
