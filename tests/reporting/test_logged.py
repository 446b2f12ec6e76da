"""The frames of bus.log case by case."""

from pathlib import Path

from conformance.reporting.bus_log import Place
from conformance.reporting.logged import frames_by_case
from conformance.reporting.page.traffic import Traffic
from conformance.sdo.cob_id import ChannelIds

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
