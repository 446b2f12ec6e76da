"""What the interface counts of lost frames."""

from pathlib import Path

from conformance.bus.counters import counted_since, lost_frames, read_counters
from conformance.bus.opening import BusSettings

CAN0 = BusSettings("socketcan", "can0")


def test_counters_of_an_interface(tmp_path: Path) -> None:
    folder = tmp_path / "can0" / "statistics"
    folder.mkdir(parents=True)
    (folder / "rx_dropped").write_text("7\n", encoding="ascii")
    (folder / "tx_errors").write_text("?\n", encoding="ascii")
    (folder / "rx_bytes").write_text("800\n", encoding="ascii")
    assert read_counters(CAN0, tmp_path) == {"rx_dropped": 7}


def test_what_has_none(tmp_path: Path) -> None:
    assert read_counters(CAN0, tmp_path) == {}
    assert read_counters(BusSettings("virtual", "lo")) == {}
    assert read_counters(BusSettings("socketcan", None)) == {}


def test_what_has_grown() -> None:
    before = {"rx_dropped": 7, "tx_errors": 1}
    assert counted_since(before, {"rx_dropped": 9, "tx_errors": 1, "rx_errors": 4}) == {
        "rx_dropped": 2
    }


def test_what_the_controller_has_sent_again_is_not_lost() -> None:
    counted = {"rx_errors": 300, "rx_crc_errors": 4, "tx_errors": 2, "tx_carrier_errors": 1}
    assert lost_frames(counted) == 0
    assert lost_frames(counted | {"rx_over_errors": 1, "rx_dropped": 2}) == 3
