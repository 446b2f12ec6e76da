"""What is wrong with every answer of a device is found before the first case."""

import pytest
from run_bench import DOMAIN, TEXT, Recording, discovered, recording

from conformance.device.objects import KnownObject
from conformance.run.verdict import Verdict
from conformance.sdo.objects import DataType, Entry
from conformance.sdo.rules import Level, Rule

STORED = Rule("test.stored", "7.2.4", Level.MUST, "A value is stored.")
LENGTH = 300


class _Filling(Recording):
    """Fills up what is stored to one length, by 00h."""

    def store(self, entry: Entry, data: bytes) -> None:
        varies = entry.data_type.length is None
        super().store(entry, data.ljust(LENGTH, b"\0") if varies else data)


@pytest.mark.parametrize("known", [TEXT, DOMAIN])
def test_values_that_are_filled_up_are_known_from_then_on(known: KnownObject) -> None:
    """A string may be filled up; of a domain it is told once, and expected in every case."""
    with discovered(recording(_Filling)) as bench:
        session = bench.session()
        session.survey()
        found = [str(cause) for cause, _ in session.causes.aside()]
        run = session.begin("a.case", "a service", STORED)
        filled = bench.device.known[known.mux]
        assert (filled.filled, bench.device.lengths[known.mux].fit(14)) == (LENGTH, LENGTH)
        run.sdo.store(filled, b"short")
        run.sdo.expect_value(filled, b"short")
        assert run.conclude(None).verdict is Verdict.PASS
    assert found == [
        "data.variable-length: shorter values are filled up with …, … bytes in all"
    ] * any(one.data_type is DataType.DOMAIN for one in bench.device.known.values())


def test_a_device_that_keeps_lengths_fills_nothing_up() -> None:
    with discovered(recording()) as bench:
        session = bench.session()
        session.survey()
        assert session.causes.aside() == []
        assert not any(known.filled for known in bench.device.known.values())
        assert session.restorer.unrestored == {}
