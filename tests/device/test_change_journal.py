"""What is changed is told before, with the value that was there; what is back, when it is."""

from pathlib import Path
from typing import Any

import pytest

from conformance.device.change_journal import Changes, LeftBehind, parse_multiplexer
from conformance.device.keeping import Keeping
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType

NUMBER, TEXT = Multiplexer(0x2004), Multiplexer(0x2010, 0xFE)


def followed() -> tuple[Changes, LeftBehind]:
    left = LeftBehind(Path("journal"), 5, "605:585", {})

    def tell(record: dict[str, Any]) -> None:
        left.take(record)

    return Changes(tell), left


def test_a_value_is_told_once_and_whole() -> None:
    changes, left = followed()
    changes.changes(TEXT, bytes(range(256)), DataType.DOMAIN)
    changes.changes(TEXT, b"another", DataType.DOMAIN)
    assert left.values == {TEXT: bytes(range(256))}
    assert left.types == {TEXT: DataType.DOMAIN}
    assert not left.is_all_back


def test_what_is_back() -> None:
    changes, left = followed()
    changes.changes(NUMBER, b"1234", None)
    changes.is_back(NUMBER, b"4321")
    assert left.values == {NUMBER: b"1234"}
    changes.is_back(NUMBER, b"1234")
    assert left.is_all_back


def test_what_was_stored() -> None:
    changes, left = followed()
    changes.stores({})
    assert left.is_all_back
    changes.stores({NUMBER: b"1234"})
    assert left.stored == {NUMBER: b"1234"}
    changes.is_stored_again()
    assert left.is_all_back


def test_what_will_be_lost_is_told_before_it_is() -> None:
    changes, left = followed()
    keeping = Keeping(changes=changes)
    keeping.will_lose({NUMBER: b"1234"})
    assert (keeping.to_store, left.stored) == ({NUMBER: b"1234"}, {NUMBER: b"1234"})
    keeping.nothing_was_lost()
    assert (keeping.to_store, keeping.stored) == ({}, {NUMBER: b"1234"})
    assert left.is_all_back


@pytest.mark.parametrize("mux", [NUMBER, TEXT, Multiplexer(0xFFFF, 0x0A)])
def test_names_are_read_back(mux: Multiplexer) -> None:
    assert parse_multiplexer(str(mux)) == mux
