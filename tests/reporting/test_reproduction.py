"""reproduce/: scripts and logs that send again what led to a failure."""

import gzip
import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reporting_results import ABOUT, DEVICE, END, UNHURRIED, result

from conformance.logs.reading import RecordedLog
from conformance.reporting import reproduction
from conformance.reporting.bus_log import Place
from conformance.reporting.recorded import RecordedRun
from conformance.reporting.reproduction import FOLDER, write_reproductions
from conformance.run.trace import ASIDE, TraceLine
from conformance.run.verdict import CaseResult, Verdict

# A read of before, another device, and the case: its second request is answered wrongly.
LOG = """\
(100.000000) can0 605#4000100000000000 T
(100.001000) can0 585#4300100091010F00 R
(101.000000) can0 605#2B01200034120000 T
(101.000500) can0 609#4000100000000000 T
(101.002000) can0 585#6001200000000000 R
(101.032000) can0 605#4001200000000000 T
(101.034000) can0 585#8001200002000106 R
(101.040000) can0 605#8000100000000008 T
"""


def line(time: float, frame: str, *, sent: bool = False, own: bool = True) -> TraceLine:
    return TraceLine("words", frame, sent, time, own=own)


TRACE = [
    line(101.0, "605#2B01200034120000", sent=True),
    line(101.002, "585#6001200000000000"),
    line(101.032, "605#4001200000000000", sent=True),
    line(101.034, "585#8001200002000106"),
    TraceLine(ASIDE),
    line(101.04, "605#8000100000000008", sent=True, own=False),
]
CAUSE = "response.specifier: abort to upload initiate"
FAILED = result(
    Verdict.FAIL,
    case_id="matrix.idle[40h]",
    broken_rule="response.specifier",
    cause=CAUSE,
    expected="43h",
    actual="an abort",
    trace=TRACE,
    decisive=3,
)
PLACE = Place("bus.log", 1, 8)
NAME = "01-response.specifier"


def reproduced(
    folder: Path, results: Sequence[CaseResult] = (FAILED,), log: str = LOG, **about: Any
) -> dict[str, str]:
    """Return the files of a run by their names."""
    (folder / "bus.log").write_text(log, encoding="utf-8")
    places: list[Place | None] = [PLACE for _ in results]
    devices = [DEVICE, DEVICE | {"node_id": 9, "sdo_channel": "609:589"}]
    run = RecordedRun(ABOUT | about, devices, list(results), places, len(results), END)
    target = write_reproductions(folder, run)
    files = sorted((folder / FOLDER).glob("*"))
    assert target == (folder / FOLDER if files else None)
    return {path.name: path.read_text(encoding="utf-8") for path in files}


def sent_by(folder: Path) -> list[str]:
    """Run the script of the first cause with a cansend that only writes down what it is told."""
    (folder / "cansend").write_text('#!/bin/sh\necho "$@" >> "$SENT"\n')
    (folder / "cansend").chmod(0o755)
    environment = {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}", "SENT": str(folder / "s")}
    script = folder / FOLDER / f"{NAME}.sh"
    subprocess.run([str(script)], env=environment, check=True)  # noqa: S603 - it is our own
    return (folder / "s").read_text().splitlines()


def test_a_script_sends_what_the_case_sent_up_to_the_decisive_frame(tmp_path: Path) -> None:
    files = reproduced(tmp_path)
    assert sorted(files) == [f"{NAME}.log", f"{NAME}.sh"]
    assert sent_by(tmp_path) == ["can0 605#2B01200034120000", "can0 605#4001200000000000"]


def test_a_script_says_what_it_is_about(tmp_path: Path) -> None:
    script = reproduced(tmp_path)[f"{NAME}.sh"]
    assert script.splitlines()[0] == "#!/bin/sh"
    assert "# response.specifier: abort to upload initiate (1 case failed)" in script
    assert "# rule: response.specifier (MUST, CiA 301 clause " in script
    assert "# case: matrix.idle[40h], node 5" in script
    assert "# expected: 43h\n# actual: an abort\n" in script
    assert "# Watch beside it: candump can0,605:7FF,585:7FF" in script
    assert script.endswith(
        "cansend can0 605#2B01200034120000  # download initiate 2001h:00, expedited, 2 bytes: "
        "34 12\n"
        "sleep 0.04\n"
        "cansend can0 605#4001200000000000  # upload initiate 2001h:00\n"
        "# Now candump shows the answer; in the run: 585#8001200002000106 abort 2001h:00, "
        "06010002h (write of a read-only object)\n"
    )


def test_a_packed_log_will_do_and_without_any_the_files_stay(tmp_path: Path) -> None:
    files = reproduced(tmp_path)
    log = tmp_path / "bus.log"
    (tmp_path / "bus.log.gz").write_bytes(gzip.compress(log.read_bytes()))
    log.unlink()
    run = RecordedRun(ABOUT, [DEVICE], [FAILED], [PLACE], 1, END)

    def written() -> dict[str, str]:
        assert write_reproductions(tmp_path, run) == tmp_path / FOLDER
        return {path.name: path.read_text("utf-8") for path in (tmp_path / FOLDER).iterdir()}

    (tmp_path / FOLDER / f"{NAME}.sh").unlink()
    assert written() == files
    (tmp_path / "bus.log.gz").unlink()
    assert written() == files


def test_a_silence_is_looked_for_behind_the_last_request(tmp_path: Path) -> None:
    failed = result(Verdict.FAIL, cause=CAUSE, actual="no answer", trace=TRACE, decisive=2)
    script = reproduced(tmp_path, [failed])[f"{NAME}.sh"]
    assert script.endswith("# Now look for 585h with candump; in the run: no answer\n")


def test_a_log_has_the_answers_of_then(tmp_path: Path) -> None:
    """The frames of another device, which was tested at the same time, are none of it."""
    reproduced(tmp_path)
    log = RecordedLog(str(tmp_path / FOLDER / f"{NAME}.log"))
    assert [(str(seen.frame), round(seen.time * 1000)) for seen in log] == [
        ("605#2B01200034120000", 0),
        ("585#6001200000000000", 2),
        ("605#4001200000000000", 32),
        ("585#8001200002000106", 34),
    ]


def test_only_socketcan_has_cansend(tmp_path: Path) -> None:
    files = reproduced(tmp_path, interface="pcan", channel="PCAN_USBBUS1")
    assert list(files) == [f"{NAME}.log"]
    assert files[f"{NAME}.log"].startswith("(101.000000) PCAN_USBBUS1 605#2B01200034120000 T\n")


def test_a_channel_is_one_word_to_the_shell(tmp_path: Path) -> None:
    script = reproduced(tmp_path, channel="can0; touch x")[f"{NAME}.sh"]
    assert "cansend 'can0; touch x' 605#2B01200034120000" in script


@pytest.mark.parametrize("log", [LOG[: LOG.index("(101.034")], LOG.replace("585#60", "585#61"), ""])
def test_without_its_frames_a_cause_has_no_files(tmp_path: Path, log: str) -> None:
    assert reproduced(tmp_path, log=log) == {}


def test_without_a_log_there_are_no_files(tmp_path: Path) -> None:
    run = RecordedRun(ABOUT, [DEVICE], [FAILED], [PLACE], 1, END)
    assert write_reproductions(tmp_path, run) is None


def test_what_an_earlier_report_has_left_is_removed(tmp_path: Path) -> None:
    reproduced(tmp_path)
    (tmp_path / FOLDER / "mine.sh").touch()
    assert write_reproductions(tmp_path, RecordedRun(ABOUT)) is None
    assert [path.name for path in (tmp_path / FOLDER).iterdir()] == ["mine.sh"]


def test_the_middle_of_a_long_case_comes_from_the_log(tmp_path: Path) -> None:
    """A trace shows the first 40 frames and the last 60."""
    frames = [f"605#40{number:04X}0000000000" for number in range(150)]
    log = "".join(f"(100.{number:06}) can0 {frame} T\n" for number, frame in enumerate(frames))
    trace = [line(100 + number / 1e6, frame, sent=True) for number, frame in enumerate(frames)]
    trace[40:90] = [TraceLine("… 50 frames left out; bus.log has them all")]
    failed = result(Verdict.FAIL, cause=CAUSE, trace=trace)
    folder = Place("bus.log", 1, 150)
    (tmp_path / "bus.log").write_text(log)
    run = RecordedRun(ABOUT, [DEVICE], [failed], [folder], 1, END)
    assert write_reproductions(tmp_path, run) is not None
    assert sent_by(tmp_path) == [f"can0 {frame}" for frame in frames]


READ = """\
(100.000000) can0 605#2110200008000000 T
(100.001000) can0 585#6010200000000000 R
(100.002000) can0 605#0041424344454647 T
(100.003000) can0 585#2000000000000000 R
(100.004000) can0 605#1D48000000000000 T
(100.005000) can0 585#3000000000000000 R
(200.000000) can0 605#4010200000000000 T
(200.001000) can0 585#4110200008000000 R
(200.002000) can0 605#7000000000000000 T
(200.003000) can0 585#0041424344454647 R
"""
RESTORED = """\
(300.000000) can0 605#2310200074657874 T
(300.001000) can0 585#6010200000000000 R
"""
ABORTED = """\
(150.000000) can0 605#2310200031323334 T
(150.001000) can0 585#8010200000000008 R
"""
OF_READING = [
    line(200.0, "605#4010200000000000", sent=True),
    line(200.001, "585#4110200008000000"),
    line(200.002, "605#7000000000000000", sent=True),
    line(200.003, "585#0041424344454647"),
]


def files_of_reading(folder: Path, log: str) -> dict[str, str]:
    first = log[: log.index("605#4010")].count("\n") + 1
    (folder / "bus.log").write_text(log)
    failed = result(Verdict.FAIL, cause=CAUSE, trace=OF_READING)
    run = RecordedRun(ABOUT, [DEVICE], [failed], [Place("bus.log", first, first + 3)], 1, END)
    assert write_reproductions(folder, run) is not None
    return {path.name: path.read_text() for path in (folder / FOLDER).iterdir()}


def test_a_value_that_another_case_had_written_is_written_first(tmp_path: Path) -> None:
    """A download that was aborted has written nothing."""
    before = READ.index("(200.0")
    files = files_of_reading(tmp_path, READ[:before] + ABORTED + READ[before:] + RESTORED)
    assert sent_by(tmp_path) == [
        "can0 605#2110200008000000",
        "can0 605#0041424344454647",
        "can0 605#1D48000000000000",
        "can0 605#4010200000000000",
        "can0 605#7000000000000000",
    ]
    comments = [line for line in files[f"{NAME}.sh"].splitlines() if line.startswith("#")]
    assert comments[-3:-1] == ["# what objects held that other cases had written:", "# the case:"]
    (tmp_path / "replay.log").write_text(files[f"{NAME}.log"])
    times = [round(seen.time, 3) for seen in RecordedLog(str(tmp_path / "replay.log"))]
    assert times == [0.0, 0.001, 0.002, 0.003, 0.004, 0.005, 0.015, 0.016, 0.017, 0.018]


def test_a_value_that_the_object_still_has_is_not(tmp_path: Path) -> None:
    script = files_of_reading(tmp_path, READ)[f"{NAME}.sh"]
    assert sent_by(tmp_path) == ["can0 605#4010200000000000", "can0 605#7000000000000000"]
    assert "other cases" not in script


def test_very_long_cases_and_very_many_causes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = result(Verdict.FAIL, cause="response.awaited: x", trace=TRACE)
    assert len(reproduced(tmp_path, [FAILED, other])) == 4
    monkeypatch.setattr(reproduction, "MOST_CAUSES", 1)
    assert len(reproduced(tmp_path, [FAILED, other])) == 2
    monkeypatch.setattr(reproduction, "MOST_FRAMES", 3)
    assert reproduced(tmp_path, [FAILED]) == {}


@UNHURRIED
@given(st.text(), st.text(), st.text())
def test_whatever_a_device_sent_is_a_comment(cause: str, expected: str, actual: str) -> None:
    failed = result(
        Verdict.FAIL,
        cause=f"response.specifier: {cause}",
        expected=expected,
        actual=actual,
        trace=TRACE,
        decisive=2,
    )
    with tempfile.TemporaryDirectory() as folder:
        script = reproduced(Path(folder), [failed])[f"{NAME}.sh"]
    lines = [line for line in script.splitlines() if not line.startswith("#")]
    assert [line.partition("  # ")[0] for line in lines] == [
        "set -e",
        "cansend can0 605#2B01200034120000",
        "sleep 0.04",
        "cansend can0 605#4001200000000000",
    ]
    assert script.replace("\n", "").isprintable()
