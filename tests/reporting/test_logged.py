"""The frames of bus.log case by case."""

from collections.abc import Iterable
from pathlib import Path

import pytest

from conformance.reporting.bus_log import Place
from conformance.reporting.logged import frames_by_case
from conformance.reporting.page.traffic import Traffic
from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.layout import Multiplexer

NUMBER = Multiplexer(0x2004)
LOG = """\
(1.0) one 605#4000100000000000 T
(1.1) two 605#4018100100000000 T
(1.2) one 585#4300100091010F00 R
(1.3) two 585#4318100100000C5D R
(1.4) one 605#8000100000000008 T
"""


def test_what_went_over_another_bus_belongs_to_no_case_of_this_one(tmp_path: Path) -> None:
    """As in a self-test with workers: each has a bus, and the same node on it."""
    (tmp_path / "bus.log").write_text(LOG, encoding="utf-8")
    places = [Place("bus.log", 1, 5), Place("bus.log", 2, 4)]
    found = {
        number: [logged.number for logged in lines]
        for number, lines in frames_by_case(tmp_path, "bus.log", places, [5, 5])
    }
    assert found == {0: [1, 3, 5], 1: [2, 4]}


def test_a_command_to_all_devices_is_one_command(tmp_path: Path) -> None:
    log = (
        "(1.0) one 605#4000100000000000 T\n(1.1) one 606#4000100000000000 T\n(1.2) one 000#0100 T\n"
    )
    (tmp_path / "bus.log").write_text(log, encoding="utf-8")
    places = [Place("bus.log", 1, 3), Place("bus.log", 2, 3)]
    channels = {node_id: ChannelIds.default(node_id) for node_id in (5, 6)}
    traffic = Traffic()
    for number, lines in frames_by_case(tmp_path, "bus.log", places, [5, 6], channels):
        traffic.take(number, 5 + number, channels[5 + number], lines, in_words=False)
    assert traffic.commands.total() == 1


@pytest.mark.parametrize("extended", [False, True])
def test_an_identifier_of_another_length_is_another(tmp_path: Path, extended: bool) -> None:
    """Also one with the number of the channel, or with that of NMT commands."""
    lines = [
        f"({time}.0) one {can_id}#{data} {direction}\n"
        for time, (can_id, data, direction) in enumerate(
            [
                ("605", "4000100000000000", "T"),
                ("585", "4300100091010F00", "R"),
                ("00000605", "4000100000000000", "T"),
                ("00000585", "4300100091010F00", "R"),
                ("00000000", "8105", "T"),
            ]
        )
    ]
    (tmp_path / "bus.log").write_text("".join(lines), encoding="utf-8")
    ids = ChannelIds(CobId(0x605, extended), CobId(0x585, extended))
    ((_, logged),) = frames_by_case(tmp_path, "bus.log", [Place("bus.log", 1, 5)], [5], {5: ids})
    traffic = Traffic()
    traffic.take(0, 5, ids, logged, in_words=True)
    assert (traffic.requests, traffic.responses) == (1, 1)
    assert not traffic.commands
    with_words = [bool(line.split(" ", 3)[3:]) for line in traffic.shown[0].splitlines()]
    assert with_words == [not extended, not extended, extended, extended, False]


@pytest.mark.parametrize("others", [range(0x604, 0x607), (0x605, 0x60A, 0x60B)], ids=["one", "two"])
@pytest.mark.parametrize("elsewhere", [0x580, 0x680], ids=["alike", "but-one-that-is-no-answer"])
def test_what_devices_say_alike_counts_for_each(
    tmp_path: Path, others: Iterable[int], elsewhere: int
) -> None:
    """Whether their frames are put into words or not, and on whatever channels they are."""
    requests = dict(zip((5, 6, 7), others, strict=True))
    said = [
        (node_id, frame, time)
        for time, node_id in enumerate(requests)
        for frame in (
            f"{requests[node_id]:03X}#2F04200007000000 T",
            f"{(0x580 if node_id < 7 else elsewhere) + node_id:03X}#6004200000000000 R",
            f"{requests[node_id]:03X}#4000100000000000 T",
        )
    ]
    lines = [f"({number}.{time}0) one {frame}\n" for number, (_, frame, time) in enumerate(said)]
    (tmp_path / "bus.log").write_text("".join(lines), encoding="utf-8")
    places = [Place("bus.log", first, first + 2) for first in (1, 4, 7)]
    channels = {
        node_id: ChannelIds(CobId(can_id), CobId(0x580 + node_id))
        for node_id, can_id in requests.items()
    }
    found = []
    for in_words in (True, False):
        traffic = Traffic()
        for number, logged in frames_by_case(tmp_path, "bus.log", places, [5, 6, 7], channels):
            node_id = 5 + number
            traffic.take(number, node_id, channels[node_id], logged, in_words=in_words)
        written = {key: (one.begun, one.values) for key, one in traffic.written.items()}
        times = {kind: (one.all, one.slowest) for kind, one in traffic.times.items()}
        counts = traffic.requests, traffic.responses
        found.append((written, times, counts))
    each, alike = found
    assert alike == each
    assert alike[0] == {(node_id, NUMBER): (1, {"07": 1}) for node_id in (5, 6, 7)}
    assert alike[2] == (6, 3 if elsewhere == 0x580 else 2)


def test_cases_one_after_another_read_as_those_side_by_side(tmp_path: Path) -> None:
    """A case that overlaps all others has them read line by line; they say the same."""
    strange = LOG.replace("(1.3) two 585", "cut off\n(1.3) two 606")
    (tmp_path / "bus.log").write_text(LOG + strange, encoding="utf-8")
    places = [Place("bus.log", 1, 2), Place("bus.log", 3, 5), Place("bus.log", 6, 20)]
    channels = {node_id: ChannelIds.default(node_id) for node_id in (5, 6)}
    found = [
        {
            number: list(lines)
            for number, lines in frames_by_case(tmp_path, "bus.log", given, [5] * 4, channels)
            if number < len(places)
        }
        for given in (places, [*places, Place("bus.log", 1, 20)])
    ]
    assert found[0] == found[1]
    assert [[one.number for one in lines] for lines in found[0].values()] == [
        [1],
        [3, 5],
        [6, 8, 11],
    ]
