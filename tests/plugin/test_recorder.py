"""The record of a run, as workers hand over its parts."""

from pathlib import Path

from conformance.plugin.recorder import Recorder
from conformance.reporting.bus_log import Place
from conformance.run.verdict import CaseResult


def test_the_places_of_cases_move_with_the_lines_of_their_logs(tmp_path: Path) -> None:
    logs = [tmp_path / "bus-gw0.log", tmp_path / "bus-gw1.log"]
    logs[0].write_text("(1.0) can0 605#40 T\n(4.0) can0 585#43 R\n", encoding="utf-8")
    logs[1].write_text("(2.0) can0 609#40 T\n(3.0) can0 589#43 R\n", encoding="utf-8")
    recorder = Recorder(tmp_path, {}, [], page=False)
    for log in logs:
        case = CaseResult("x", "y", 5, "MUST", "7.2.4", "It answers.")
        recorder.case(case, Place(log.name, 1, 2, left_out=3))
    recorder.merge(logs, tmp_path / "bus.log")
    first, second = recorder.run.places
    assert first == Place("bus.log", 1, 4, left_out=3, between=2)
    assert second == Place("bus.log", 2, 3, left_out=3)
    assert first is not None
    assert second is not None
    assert first.lines == second.lines == 2
