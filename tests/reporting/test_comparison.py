"""`conformance compare`: what it says of two runs, and when it calls the new one worse."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from reporting_results import ABOUT, DEVICE, END, cause_of, result
from test_page import Reader

from conformance.__main__ import main
from conformance.commands.status import DONE, NOT_ALLOWED, WRONG_USE
from conformance.reporting.bus_log import Place
from conformance.reporting.comparison import differences
from conformance.reporting.results import RESULTS, ResultsFile
from conformance.run.verdict import CaseResult, Verdict

NO_ANSWER = "response.answered: no answer to upload initiate"
OTHER = "size.indicated: other data"
MET = [*filter(None, [cause_of(NO_ANSWER)])]
ALONE = {"node_ids": [5]}


def case(verdict: Verdict = Verdict.PASS, case_id: str = "upload.a", **more: Any) -> CaseResult:
    return result(verdict, case_id=case_id, **more)


def failed(case_id: str = "upload.a", cause: str = NO_ANSWER, **more: Any) -> CaseResult:
    return case(Verdict.FAIL, case_id, cause=cause, actual="nothing", **more)


def record(
    folder: Path,
    results: Sequence[CaseResult],
    *,
    about: dict[str, Any] = ALONE,
    device: dict[str, Any] | None = None,
    end: dict[str, Any] | None = END,
    log: str = "",
) -> Path:
    """Write a report folder; a log has a frame and its answer for each case."""
    folder.mkdir()
    file = ResultsFile(folder)
    file.run({**ABOUT, **about})
    file.device({**DEVICE, **(device or {})})
    for number, each in enumerate(results):
        file.case(each, Place("bus.log", 2 * number + 1, 2 * number + 2) if log else None)
    if end is not None:
        file.end(end)
    assert not file.close()
    if log:
        (folder / "bus.log").write_text(log, encoding="utf-8")
    return folder


class Compared:
    """Compares two runs: the exit status, and what is printed."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self._folder = folder
        self._capsys = capsys
        self.status = -1

    def __call__(
        self,
        old: Sequence[CaseResult],
        new: Sequence[CaseResult],
        before: dict[str, Any] | None = None,
        after: dict[str, Any] | None = None,
    ) -> list[str]:
        """Return the lines but the first two, which name the runs."""
        record(self._folder / "old", old, **(before or {}))
        record(self._folder / "new", new, **(after or {}))
        self.status = main(["compare", str(self._folder / "old"), str(self._folder / "new")])
        lines = self._capsys.readouterr().out.splitlines()
        assert lines[0].startswith(f"old: {self._folder / 'old'} (node")
        assert lines[1].startswith(f"new: {self._folder / 'new'} (node")
        return lines[2:]


@pytest.fixture
def compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Compared:
    return Compared(tmp_path, capsys)


def test_two_equal_runs(compared: Compared) -> None:
    results = [case(), failed("upload.b"), case(Verdict.NOT_TESTABLE, "upload.c", actual="why")]
    assert compared(results, results) == ["nothing got worse"]
    assert compared.status == DONE


def test_broken(compared: Compared) -> None:
    passed = [case(), case(Verdict.UNIMPLEMENTED, "upload.b"), case(case_id="upload.c")]
    assert compared(passed, [failed(), failed("upload.b"), case(case_id="upload.c")]) == [
        "new causes (1):",
        f"  {NO_ANSWER} (2 cases failed; first upload.a)",
        "broken: passed before, fail now (2 cases):",
        f"  {NO_ANSWER} (2 cases; first upload.a)",
        "worse: 2 cases broken; 1 new cause",
    ]
    assert compared.status == NOT_ALLOWED


def test_fixed(compared: Compared) -> None:
    assert compared([failed(), failed("upload.b", OTHER)], [case(), case(case_id="upload.b")]) == [
        "causes that are gone (2):",
        f"  {NO_ANSWER} (1 case failed; first upload.a)",
        f"  {OTHER} (1 case failed; first upload.b)",
        "fixed: failed before, do not fail now (2 cases):",
        f"  upload.a: {NO_ANSWER}",
        f"  upload.b: {OTHER}",
        "nothing got worse",
    ]
    assert compared.status == DONE


def test_a_new_cause_in_a_case_that_failed_before_is_worse(compared: Compared) -> None:
    lines = compared([failed()], [failed(cause=OTHER)])
    assert "new causes (1):" in lines
    assert lines[-1] == "worse: 1 new cause"
    assert compared.status == NOT_ALLOWED


def test_a_cause_that_another_case_meets_first_is_not_worse(compared: Compared) -> None:
    """It fails the first case that meets it; which one that is depends on the cases of the run."""
    old = [failed(), case(case_id="upload.b", met=MET)]
    new = [case(met=MET), failed("upload.b")]
    lines = compared(old, new)
    assert compared.status == DONE
    assert not any("broken" in line or "gone" in line for line in lines)


def test_a_service_that_is_refused_now_is_worse(compared: Compared) -> None:
    lines = compared([case()], [case(Verdict.UNIMPLEMENTED, actual="abort 05040001h")])
    assert lines == [
        "no longer served: passed before, refused now as unimplemented (1 case):",
        "  upload.a: abort 05040001h",
        "worse: 1 case no longer served",
    ]
    assert compared.status == NOT_ALLOWED


NOT_WORSE = {
    "fail now, were not tested before": (
        [case(Verdict.NOT_TESTABLE), failed("upload.b")],
        [failed(), failed("upload.b")],
    ),
    "miss a SHOULD now": ([case()], [case(Verdict.NON_STRICT, actual="05040001h")]),
    "tested before, not tested now": ([case()], [case(Verdict.NOT_RUN, actual="budget")]),
    "only in the new run": ([], [case()]),
    "only in the old run": ([case()], []),
}


@pytest.mark.parametrize("title", NOT_WORSE)
def test_told_but_not_worse(compared: Compared, title: str) -> None:
    lines = compared(*NOT_WORSE[title])
    assert lines[0] == f"{title} (1 case):"
    assert lines[-1] == "nothing got worse"
    assert compared.status == DONE


def test_a_known_deviation_is_no_change_for_the_worse(compared: Compared) -> None:
    known, other = (
        case(Verdict.KNOWN_DEVIATION, case_id, cause=NO_ANSWER, reason="ticket 1")
        for case_id in ("upload.a", "upload.b")
    )
    lines = compared([known, case(case_id="upload.b")], [failed(), other])
    assert lines == ["nothing got worse"]


def test_strict_runs(compared: Compared) -> None:
    strict = {"about": {**ALONE, "strict": True}}
    soft = case(Verdict.NON_STRICT, cause=OTHER)
    assert compared([case()], [soft], strict, strict)[-1] == "worse: 1 case broken; 1 new cause"


def test_a_cause_whose_cases_were_not_tested_again_is_not_gone(compared: Compared) -> None:
    lines = compared([failed()], [case(Verdict.NOT_RUN, actual="budget")])
    assert "causes whose cases were not tested again (1):" in lines
    assert "causes that are gone (1):" not in lines


@pytest.mark.parametrize(
    ("end", "why"),
    [
        (None, "the run was killed: its record has no end. 1 case was finished"),
        ({**END, "exit_status": 12}, "it ended with exit status 12"),
        (
            {**END, "exit_status": 11, "bench_errors": ["no cable"]},
            "it ended with exit status 11; no cable",
        ),
    ],
)
def test_a_new_run_that_is_not_whole_proves_nothing(
    compared: Compared, end: dict[str, Any] | None, why: str
) -> None:
    lines = compared([case()], [case()], {}, {"end": end})
    assert lines == [f"     {why}", f"worse: the new run is not whole: {why}"]
    assert compared.status == NOT_ALLOWED


def test_an_old_run_that_is_not_whole_can_be_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old = record(tmp_path / "old", [case()], end=None)
    new = record(tmp_path / "new", [case()])
    assert main(["compare", str(old), str(new)]) == DONE
    assert "the run was killed" in capsys.readouterr().out


def test_devices_and_options(compared: Compared) -> None:
    about = {**ALONE, "suite": "2", "permissions": ["sync"], "strict": True, "eds": None}
    device = {"identity": {"vendor-id": "0x0000012E"}, "texts": {"100Ah:00": "2.0"}}
    assert compared([case()], [case()], {}, {"about": about, "device": device}) == [
        "devices:",
        "  device name (1008h): Drive -> none",
        "  software version (100Ah): none -> 2.0",
        "suite and options:",
        "  suite version: 1 -> 2",
        "  EDS: drive.eds (SHA-256 000000000000…) -> none",
        "  permissions: nmt -> sync",
        "  strict: no -> yes",
        "nothing got worse",
    ]


def test_a_single_device_may_have_another_node_id(compared: Compared) -> None:
    after = {"about": {"node_ids": [9]}, "device": {"node_id": 9}}
    lines = compared([case()], [failed(node_id=9)], {}, after)
    assert lines[:2] == ["devices:", "  node-ID: 5 -> 9"]
    assert lines[-1] == "worse: 1 case broken; 1 new cause"


def test_several_devices_are_compared_by_node_id(compared: Compared) -> None:
    old = [case(), case(node_id=9)]
    new = [case(), failed(node_id=7), failed(node_id=9)]
    both, other = {"about": {"node_ids": [5, 9]}}, {"about": {"node_ids": [5, 7, 9]}}
    assert compared(old, new, both, other) == [
        "devices:",
        "  device: none -> node 7",
        "new causes (1):",
        f"  node 9: {NO_ANSWER} (1 case failed; first upload.a)",
        "broken: passed before, fail now (1 case):",
        f"  upload.a: {NO_ANSWER}",
        "only in the new run (1 case):",
        "  upload.a: expedited-upload: fail",
        "worse: 1 case broken; 1 new cause",
    ]


def log(milliseconds: float, answer: str) -> str:
    """Return a log of 30 cases that read an object each."""
    return "".join(
        f"({100 + number:.6f}) can0 605#4000100000000000 T\n"
        f"({100 + number + milliseconds / 1000:.6f}) can0 585#{answer} R\n"
        for number in range(30)
    )


EXPEDITED, UNCOUNTED = "4300100091010F00", "4200100091010F00"


def test_choices_and_times(compared: Compared) -> None:
    cases = [case(case_id=f"upload.{number}") for number in range(30)]
    lines = compared(cases, cases, {"log": log(2, EXPEDITED)}, {"log": log(4, UNCOUNTED)})
    assert lines == [
        "the device chooses otherwise:",
        "  expedited upload: counted -> not counted",
        "answered more slowly:",
        "  upload initiate: half within 4.0 ms (before 2.0), 95 % within 4.0 ms (before 2.0)",
        "nothing got worse",
    ]
    assert compared.status == DONE


@pytest.mark.parametrize(
    ("number", "old", "new"), [(30, 2, 2.9), (30, 20, 29), (30, 0.1, 0.9), (19, 2, 4)]
)
def test_times_that_hardly_differ(compared: Compared, number: int, old: float, new: float) -> None:
    """Neither by half, nor by a millisecond, or in too few answers to tell."""
    cases = [case(case_id=f"upload.{each}") for each in range(number)]
    before, after = {"log": log(old, EXPEDITED)}, {"log": log(new, EXPEDITED)}
    assert compared(cases, cases, before, after) == ["nothing got worse"]


def test_self_tests_have_a_bus_of_their_own(compared: Compared) -> None:
    before, after = ({**ALONE, "self_test": True, "channel": name} for name in ("a", "b"))
    assert compared([], [], {"about": before}, {"about": after}) == ["nothing got worse"]


def test_another_bus(compared: Compared) -> None:
    before, after = ({**ALONE, "channel": name} for name in ("can0", "can1"))
    lines = compared([], [], {"about": before}, {"about": after})
    assert "  channel: can0 -> can1" in lines


def test_long_lists_are_cut(compared: Compared) -> None:
    new = [failed(f"upload.{each}", f"upload.{each}: other data") for each in "abcdefghijklm"]
    lines = compared([], new)
    assert "  and 3 more, which --page shows" in lines


def test_a_folder_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = record(tmp_path / "old", [case()])
    assert main(["compare", str(old), str(tmp_path)]) == WRONG_USE
    assert f"no record of a run: [Errno 2] No such file or directory: '{tmp_path / RESULTS}'" in (
        capsys.readouterr().err
    )


def test_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All of it, and inert: what a device says is text."""
    said = "<script>x()</script>\x1b[31m"
    new = [failed(cause=f"{NO_ANSWER}{said}", decisive=0), *map(failed, "bcdefghijklmno")]
    old = record(tmp_path / "old", [case()])
    folder = record(tmp_path / "new", new, device={"texts": {"1008h:00": said}})
    page = tmp_path / "page.html"
    assert main(["compare", str(old), str(folder), "--page", str(page)]) == NOT_ALLOWED
    assert f"written: {page}" in capsys.readouterr().out
    reader = Reader()
    reader.feed(page.read_text(encoding="utf-8"))
    reader.close()
    assert reader.open == []
    assert "✗ worse: 1 case broken; 2 new causes" in reader.text
    assert "upload.a ✓ pass ✗ fail" in reader.text
    assert "device name (1008h) Drive <script>x()</script>\\x1b[31m" in reader.text
    assert all(f"{each} none ✗ fail" in reader.text for each in "bcdefghijklmno")
    assert [tag for tag, each in reader.tags if tag == "script"] == []
    assert [each["class"] for tag, each in reader.tags if tag == "svg"] == ["diagram"] * 2
    ids = [each["id"] for _, each in reader.tags if "id" in each]
    assert {str(each["href"])[1:] for tag, each in reader.tags if tag == "a"} <= set(ids)


@pytest.mark.parametrize("odd", [0, 1], ids=["old", "new"])
def test_choices_that_other_cases_have_shown(compared: Compared, odd: int) -> None:
    """Only those count that both runs have: the answers in others have nothing to be like."""
    plain, other = log(2, EXPEDITED), log(9 if odd else 0.1, UNCOUNTED)
    mixed = plain.splitlines(keepends=True)[:10] + other.splitlines(keepends=True)[10:]
    logs = [plain, plain]
    logs[odd] = "".join(mixed)
    shared = [case(case_id=f"upload.{number}") for number in range(5)]
    old, new = (
        [*shared, *(case(case_id=f"{name}.{number}") for number in range(25))]
        for name in ("old", "new")
    )
    lines = compared(old, new, *({"log": each} for each in logs))
    assert not any("otherwise" in line or "slowly" in line for line in lines)


def test_of_many_choices_only_the_differing_are_named() -> None:
    matter, shared = "abort by specifier.unknown", [f"0504000{n}h (words)" for n in range(1, 6)]
    old, new = {5: {matter: [*shared, "08000000h"]}}, {5: {matter: [*shared, "06010000h"]}}
    (found,) = differences.profile({5: 5}, old, new)
    assert (found.what, found.old, found.new) == (matter, "08000000h", "06010000h")
    (found,) = differences.profile({5: 5}, {5: {matter: shared}}, new)
    assert (found.old, found.new) == ("none", "06010000h")
