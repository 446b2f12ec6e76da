"""The runs of a lab as a table: text and page."""

import re
from pathlib import Path
from typing import Any

import pytest
from reporting_results import ABOUT, DEVICE, END, result

from conformance.__main__ import main
from conformance.commands.status import DONE, WRONG_USE
from conformance.reporting.overview.page import write_overview
from conformance.reporting.overview.runs import Outcome, read_overview
from conformance.reporting.overview.text import overview_lines
from conformance.reporting.page.writing import PAGE
from conformance.reporting.results import ResultsFile
from conformance.run.verdict import Verdict

FAILED = result(Verdict.FAIL, case_id="abort.own", cause="abort.frame: 8 bytes")
LACKING = result(Verdict.NOT_TESTABLE, case_id="download.own")


def recorded(
    reports: Path,
    name: str,
    *results: Any,
    begun: str = "2026-05-06T09:08:09.000+02:00",
    status: int | None = 0,
    nodes: tuple[int, ...] = (5,),
    device: dict[str, Any] | None = None,
) -> Path:
    """Write the record of a run into a folder."""
    folder = reports / name
    folder.mkdir(parents=True)
    file = ResultsFile(folder)
    file.run(ABOUT | {"node_ids": list(nodes), "begun": begun, "self_test": False, "server": None})
    for node_id in nodes:
        file.device((device or DEVICE) | {"node_id": node_id})
    for each in results:
        file.case(each)
    if status is not None:
        file.end(END | {"exit_status": status})
    assert not file.close()
    return folder


def outcomes(reports: Path) -> dict[str, list[Outcome]]:
    overview = read_overview(reports)
    return {each.about: [once.outcome for once in each.runs] for each in overview.devices}


def test_devices_and_their_runs_the_latest_first(tmp_path: Path) -> None:
    recorded(tmp_path, "a", result(), FAILED, LACKING, status=1)
    recorded(tmp_path, "b", result(), begun="2026-05-07T10:00:00.000+02:00")
    other = DEVICE | {"identity": {"vendor-id": "0x0000007F"}, "texts": {}}
    recorded(tmp_path, "c", result(), device=other)
    (tmp_path / "failing").mkdir()
    (tmp_path / "index.html").touch()
    assert list(overview_lines(read_overview(tmp_path))) == [
        "Drive (node 5, vendor-id 0x0000012E)",
        "  2026-05-07 10:00  pass         1 tested                b",
        "  2026-05-06 09:08  fail         1 of 2 failed, 1 cause  a",
        "node 5 (node 5, vendor-id 0x0000007F)",
        "  2026-05-06 09:08  pass         1 tested  c",
        "3 runs, 2 devices",
    ]


@pytest.mark.parametrize(
    ("results", "status", "outcome"),
    [
        ([result()], 0, Outcome.PASSED),
        ([result(), FAILED], 1, Outcome.FAILED),
        ([result(), FAILED], 11, Outcome.FAILED),
        ([result()], None, Outcome.UNFINISHED),
        ([result()], 11, Outcome.OTHER),
        ([result(), result(Verdict.BENCH_ERROR)], 11, Outcome.OTHER),
        ([result()], 1, Outcome.FAILED),  # for an answer behind the last case
        ([LACKING], 0, Outcome.NOT_TESTED),
        ([], 10, Outcome.NOT_TESTED),
    ],
)
def test_how_a_run_ended(
    results: list[Any], status: int | None, outcome: Outcome, tmp_path: Path
) -> None:
    recorded(tmp_path, "run", *results, status=status)
    ((found,),) = outcomes(tmp_path).values()
    assert found is outcome


def test_a_device_passes_beside_one_that_fails(tmp_path: Path) -> None:
    right = result(node_id=9)
    recorded(tmp_path, "run", FAILED, right, status=1, nodes=(5, 9))
    assert outcomes(tmp_path) == {
        "node 5, vendor-id 0x0000012E": [Outcome.FAILED],
        "node 9, vendor-id 0x0000012E": [Outcome.PASSED],
    }


def test_the_page_leads_to_each_report(tmp_path: Path) -> None:
    reports = tmp_path / "all reports"
    for name in ("first run", "second"):
        recorded(reports, name, FAILED, status=1)
    (reports / "first run" / PAGE).touch()
    write_overview(tmp_path / "index.html", read_overview(reports))
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'href="([^#"]+)"', text) == ["all%20reports/first%20run/report.html"]
    assert text.count("1 of 1 failed, 1 cause") == 2
    assert '<th scope="col">2026-05-06</th>' in text


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hostile = DEVICE | {"texts": {"1008h:00": "<script>\x1b[31m"}}
    recorded(tmp_path, "run", result(), device=hostile)
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "results.jsonl").write_text("nonsense\n")
    page = tmp_path / "index.html"
    assert main(["overview", str(tmp_path), "--page", str(page)]) == DONE
    told = capsys.readouterr()
    assert "<script>\\x1b[31m (node 5" in told.out
    assert told.out.endswith(f"1 run, 1 device\nwritten: {page}\n")
    assert "broken" in told.err
    text = page.read_text(encoding="utf-8")
    assert "<script>" not in text
    assert "\x1b" not in text


def test_a_folder_without_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["overview", str(tmp_path)]) == WRONG_USE
    assert "has no folders of runs" in capsys.readouterr().err


def test_a_night_in_which_the_device_was_silent_is_one_of_that_device(tmp_path: Path) -> None:
    recorded(tmp_path, "a", result())
    silent = DEVICE | {"identity": {}, "texts": {}}
    for name, day in (("b", 7), ("c", 8)):
        begun = f"2026-05-0{day}T10:00:00.000+02:00"
        recorded(tmp_path, name, LACKING, status=10, device=silent, begun=begun)
    recorded(tmp_path, "d", result(), begun="2026-05-09T10:00:00.000+02:00")
    assert outcomes(tmp_path) == {
        "node 5, vendor-id 0x0000012E": [
            *(Outcome.PASSED, Outcome.NOT_TESTED, Outcome.NOT_TESTED, Outcome.PASSED),
        ]
    }


def test_a_silent_night_belongs_to_the_device_that_was_there_last(tmp_path: Path) -> None:
    recorded(tmp_path, "a", result())
    other = DEVICE | {"identity": {"vendor-id": "0x0000007F"}}
    recorded(tmp_path, "b", result(), begun="2026-05-07T10:00:00.000+02:00", device=other)
    silent = DEVICE | {"identity": {}, "texts": {}}
    begun = "2026-05-08T10:00:00.000+02:00"
    recorded(tmp_path, "c", LACKING, status=10, device=silent, begun=begun)
    assert outcomes(tmp_path) == {
        "node 5, vendor-id 0x0000012E": [Outcome.PASSED],
        "node 5, vendor-id 0x0000007F": [Outcome.NOT_TESTED, Outcome.PASSED],
    }
