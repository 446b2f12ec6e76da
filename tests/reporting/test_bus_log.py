"""bus.log can be read back, frame by frame, by the reader of candump logs."""

from pathlib import Path

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reporting_results import UNHURRIED

from conformance.bus.link import Captured, Direction
from conformance.reporting.bus_log import ANSWERS, FLOOD, BusLog, Place, merge_logs
from conformance.sdo.can_frame import CanFrame

DATA = st.binary(max_size=8)
STANDARD, EXTENDED = st.integers(0, 0x7FF), st.integers(0, 0x1FFFFFFF)
FRAMES = st.one_of(
    st.tuples(STANDARD, DATA).map(lambda found: CanFrame(*found)),
    st.tuples(EXTENDED, DATA).map(lambda found: CanFrame(*found, extended=True)),
    st.tuples(STANDARD, st.integers(0, 8)).map(
        lambda found: CanFrame(found[0], remote=True, length=found[1])
    ),
)
CAPTURED = st.builds(
    Captured,
    timestamp=st.integers(0, 2**32).map(lambda ticks: 1_700_000_000 + ticks / 8),
    direction=st.sampled_from(Direction),
    frame=FRAMES,
)


def log(path: Path, captured: list[Captured], channel: str = "can0") -> list[can.Message]:
    """Write frames and read them back."""
    bus_log = BusLog(path, channel)
    for one in captured:
        bus_log.write(one)
    bus_log.close()
    return list(can.CanutilsLogReader(path))


def seen(message: can.Message) -> CanFrame:
    return CanFrame(
        message.arbitration_id,
        bytes(message.data),
        message.is_extended_id,
        message.is_remote_frame,
        message.dlc if message.is_remote_frame else None,
    )


@UNHURRIED
@given(st.lists(CAPTURED, max_size=20))
def test_frames_are_read_back(
    tmp_path_factory: pytest.TempPathFactory, captured: list[Captured]
) -> None:
    captured.sort(key=lambda one: one.timestamp)
    messages = log(tmp_path_factory.getbasetemp() / "bus.log", captured)
    assert [seen(message) for message in messages] == [one.frame for one in captured]
    assert [message.is_rx for message in messages] == [
        one.direction is Direction.RECEIVED for one in captured
    ]
    assert [message.timestamp for message in messages] == [one.timestamp for one in captured]


def test_lines_are_those_of_candump(tmp_path: Path) -> None:
    path = tmp_path / "bus.log"
    frames = [
        Captured(1.5, Direction.SENT, CanFrame(0x605, bytes.fromhex("4000100000000000"))),
        Captured(1.625, Direction.RECEIVED, CanFrame(0x585, bytes.fromhex("4300100091010F00"))),
        Captured(2.0, Direction.RECEIVED, CanFrame(0x18FF0005, b"\x01", extended=True)),
        Captured(2.0, Direction.SENT, CanFrame(0x605, remote=True, length=8)),
        Captured(2.0, Direction.SENT, CanFrame(0x605)),
    ]
    log(path, frames, "vcan0")
    assert path.read_text(encoding="ascii").splitlines() == [
        "(1.500000) vcan0 605#4000100000000000 T",
        "(1.625000) vcan0 585#4300100091010F00 R",
        "(2.000000) vcan0 18FF0005#01 R",
        "(2.000000) vcan0 605#R8 T",
        "(2.000000) vcan0 605# T",
    ]


@pytest.mark.parametrize(
    ("channel", "name"),
    [("can1", "can1"), ("PCAN_USBBUS1", "PCAN_USBBUS1"), ("0", "can0"), ("0, 1", "0,_1")],
)
def test_channel_stands_in_each_line(tmp_path: Path, channel: str, name: str) -> None:
    frames = [Captured(1.0, Direction.SENT, CanFrame(0x605))]
    assert [message.channel for message in log(tmp_path / "bus.log", frames, channel)] == [name]


def test_nothing_on_the_bus_is_an_empty_file(tmp_path: Path) -> None:
    assert log(tmp_path / "bus.log", []) == []
    assert (tmp_path / "bus.log").read_bytes() == b""


def test_several_logs_become_one(tmp_path: Path) -> None:
    parts = [tmp_path / "bus-gw0.log", tmp_path / "bus-gw1.log"]
    parts[0].write_text("(1.000000) can0 605#40 T\n(3.000000) can0 585#43 R\n", encoding="utf-8")
    parts[1].write_text("(2.000000) can0 609#40 T\n(3.000000) can0 589#43 R\n", encoding="utf-8")
    merge_logs(parts, tmp_path / "bus.log")
    assert (tmp_path / "bus.log").read_text(encoding="utf-8").splitlines() == [
        "(1.000000) can0 605#40 T",
        "(2.000000) can0 609#40 T",
        "(3.000000) can0 585#43 R",
        "(3.000000) can0 589#43 R",
    ]
    assert list(tmp_path.iterdir()) == [tmp_path / "bus.log"]


def test_no_logs_become_none(tmp_path: Path) -> None:
    merge_logs([], tmp_path / "bus.log")
    assert list(tmp_path.iterdir()) == []


def test_where_the_lines_of_a_case_are_in_the_log_of_all(tmp_path: Path) -> None:
    parts = [tmp_path / "bus-gw0.log", tmp_path / "bus-gw1.log"]
    parts[0].write_text("(1.0) can0 605#40 T\n(3.0) can0 585#43 R\n", encoding="utf-8")
    parts[1].write_text("(2.0) can0 609#40 T\n(3.0) can0 589#43 R\n", encoding="utf-8")
    wanted = {"bus-gw0.log": [1, 2], "bus-gw1.log": [2]}
    found = merge_logs(parts, tmp_path / "bus.log", wanted)
    assert found == {("bus-gw0.log", 1): 1, ("bus-gw0.log", 2): 3, ("bus-gw1.log", 2): 4}


def test_lines_of_the_same_time_stay_in_their_order(tmp_path: Path) -> None:
    """Also those that each part has."""
    parts = [tmp_path / "bus-gw0.log", tmp_path / "bus-gw1.log"]
    both = ["(1.0) can0 605#40 T\n", "(1.0) can0 585#43 R\n"]
    for part in parts:
        part.write_text("".join(both), encoding="utf-8")
    found = merge_logs(parts, tmp_path / "bus.log", {"bus-gw0.log": [1, 2], "bus-gw1.log": [1]})
    merged = (tmp_path / "bus.log").read_text(encoding="utf-8").splitlines(keepends=True)
    assert sorted(merged) == sorted(both + both)
    assert merged[0] == both[0]
    assert found["bus-gw0.log", 1] < found["bus-gw0.log", 2]
    assert [merged[place - 1] for place in found.values()] == [
        both[number - 1] for _, number in found
    ]


REQUEST = Captured(1.0, Direction.SENT, CanFrame(0x605))
ANSWER = Captured(1.0, Direction.RECEIVED, CanFrame(0x585))


def test_the_place_of_a_case(tmp_path: Path) -> None:
    bus_log = BusLog(tmp_path / "bus.log", "can0")
    bus_log.write(REQUEST)
    bus_log.begin()
    assert bus_log.place() == Place("bus.log", 2, 1)
    bus_log.write(REQUEST)
    bus_log.write(ANSWER)
    assert bus_log.place() == Place("bus.log", 2, 3)


def test_what_was_flushed_is_there(tmp_path: Path) -> None:
    bus_log = BusLog(tmp_path / "bus.log", "can0")
    bus_log.write(REQUEST)
    bus_log.flush()
    assert len((tmp_path / "bus.log").read_bytes().splitlines()) == 1


def test_a_flood_is_shown_and_then_counted(tmp_path: Path) -> None:
    bus_log = BusLog(tmp_path / "bus.log", "can0")
    bus_log.begin()
    for _ in range(FLOOD + 5):
        bus_log.write(ANSWER)
    assert bus_log.place() == Place("bus.log", 1, FLOOD, 5)
    bus_log.write(REQUEST)
    for _ in range(ANSWERS + 1):
        bus_log.write(ANSWER)
    assert bus_log.place() == Place("bus.log", 1, FLOOD + 1 + ANSWERS, 6)
    bus_log.close()
    assert len((tmp_path / "bus.log").read_bytes().splitlines()) == FLOOD + 1 + ANSWERS


def test_long_block_uploads_are_no_flood(tmp_path: Path) -> None:
    bus_log = BusLog(tmp_path / "bus.log", "can0")
    for _ in range(2 * FLOOD // 127):
        bus_log.write(REQUEST)
        for _ in range(127):
            bus_log.write(ANSWER)
    assert bus_log.left_out == 0
