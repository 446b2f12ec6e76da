"""What is changed is told before, with the value that was there; what is back, when it is."""

from pathlib import Path
from typing import Any

import pytest

from conformance.device.change_journal import LeftBehind, parse_multiplexer
from conformance.device.contents import Contents
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType

NUMBER, TEXT = Multiplexer(0x2004), Multiplexer(0x2010, 0xFE)


def followed(own: dict[Multiplexer, bytes]) -> tuple[Contents, LeftBehind]:
    left = LeftBehind(Path("journal"), 5, "605:585", {})

    def tell(record: dict[str, Any]) -> None:
        left.take(record)

    known = by_multiplexer([KnownObject(NUMBER), KnownObject(TEXT, DataType.DOMAIN)])
    return Contents(own, known, tell=tell), left


def test_a_value_is_told_once_and_whole() -> None:
    own = {TEXT: bytes(range(256))}
    contents, left = followed(own)
    contents.will_change(TEXT)
    own[TEXT] = b"another"
    contents.will_change(TEXT)
    assert left.values == {TEXT: bytes(range(256))}
    assert left.types == {TEXT: DataType.DOMAIN}
    assert not left.is_all_back


def test_what_is_back() -> None:
    contents, left = followed({NUMBER: b"1234"})
    contents.will_change(NUMBER)
    contents.is_back(NUMBER, b"4321")
    assert left.values == contents.outstanding == {NUMBER: b"1234"}
    contents.is_back(NUMBER, b"1234")
    assert left.is_all_back
    assert not contents.outstanding


def test_what_will_be_lost_is_told_before_it_is() -> None:
    contents, left = followed({})
    contents.will_lose({})
    assert left.is_all_back
    contents.will_lose({NUMBER: b"1234"})
    assert contents.to_store == left.stored == {NUMBER: b"1234"}
    contents.nothing_was_lost()
    assert (contents.to_store, contents.stored) == ({}, {NUMBER: b"1234"})
    assert left.is_all_back


@pytest.mark.parametrize("mux", [NUMBER, TEXT, Multiplexer(0xFFFF, 0x0A)])
def test_names_are_read_back(mux: Multiplexer) -> None:
    assert parse_multiplexer(str(mux)) == mux
