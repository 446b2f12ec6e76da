"""What the devices of a run chose, as its log shows it."""

from pathlib import Path

from reporting_results import ABOUT, DEVICE, result

from conformance.reporting.bus_log import Place
from conformance.reporting.page.observed import observed
from conformance.reporting.page.profile import OF_A_CASE
from conformance.reporting.recorded import RecordedRun

ASKED, ANSWERED = "#4000100000000000 T", "#4300100091010F00 R"


def test_frames_of_another_device_show_no_choice_of_a_case_beside(tmp_path: Path) -> None:
    """Of a long case, which is not judged, the lines are those that a short one happens to have."""
    long = [f"can0 609{ASKED}", f"can0 589{ANSWERED}"] * OF_A_CASE
    long[10:10] = [f"can0 605{ASKED}", *long[10:12], f"can0 585{ANSWERED}"]
    lines = (f"({number}.000000) {line}\n" for number, line in enumerate(long))
    (tmp_path / "bus.log").write_text("".join(lines), encoding="utf-8")
    results = [result(case_id="long", node_id=9), result(case_id="short", node_id=5)]
    places: list[Place | None] = [Place("bus.log", 1, len(long)), Place("bus.log", 11, 14)]
    run = RecordedRun(ABOUT, [DEVICE], results, places)
    assert observed(tmp_path, run).profile == {5: {"expedited upload": ["counted"]}}


def test_a_case_is_short_whatever_others_send_meanwhile(tmp_path: Path) -> None:
    lines = [f"can0 609{ASKED}", f"can0 589{ANSWERED}"] * OF_A_CASE
    lines = [f"can0 605{ASKED}", *lines, f"can0 585{ANSWERED}"]
    log = "".join(f"({number}.000000) {line}\n" for number, line in enumerate(lines))
    (tmp_path / "bus.log").write_text(log, encoding="utf-8")
    place = Place("bus.log", 1, len(lines), between=len(lines) - 2)
    run = RecordedRun(ABOUT, [DEVICE], [result(node_id=5)], [place])
    assert observed(tmp_path, run).profile == {5: {"expedited upload": ["counted"]}}


def test_devices_stand_in_the_order_of_their_nodes(tmp_path: Path) -> None:
    lines = [f"can0 {can_id}{data}" for node in (9, 5) for can_id, data in _read(node)]
    log = "".join(f"({number}.000000) {line}\n" for number, line in enumerate(lines))
    (tmp_path / "bus.log").write_text(log, encoding="utf-8")
    results = [result(node_id=9), result(node_id=5)]
    run = RecordedRun(ABOUT, [DEVICE], results, [Place("bus.log", 1, 2), Place("bus.log", 3, 4)])
    assert list(observed(tmp_path, run).profile) == [5, 9]


def test_each_worker_has_a_log(tmp_path: Path) -> None:
    """As long as they are not merged: devices stand in order, and a line has its number in each."""
    places: list[Place | None] = []
    for node_id, log in ((9, "bus-gw0-9.log"), (10, "bus-gw0-10.log")):
        lines = [f"can0 {can_id}{data}" for can_id, data in [*_read(node_id), ("000", "#8100 T")]]
        text = "".join(f"({number}.000000) {line}\n" for number, line in enumerate(lines))
        (tmp_path / log).write_text(text, encoding="utf-8")
        places.append(Place(log, 1, 3))
    about = ABOUT | {"node_ids": [9, 10]}
    run = RecordedRun(about, [], [result(node_id=9), result(node_id=10)], places)
    seen = observed(tmp_path, run)
    assert list(seen.profile) == [9, 10]
    assert seen.traffic.commands.total() == 2


def _read(node_id: int) -> list[tuple[str, str]]:
    return [(f"{0x600 + node_id:03X}", ASKED), (f"{0x580 + node_id:03X}", ANSWERED)]
