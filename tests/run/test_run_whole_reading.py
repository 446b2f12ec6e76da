"""What is too long to be read in a sensible time is begun, and neither read nor written whole."""

from dataclasses import replace

import pytest
from run_bench import (
    DOMAIN,
    NODE_ID,
    NUMBER,
    TEXT,
    Recording,
    discovered,
    recording,
    undiscovered,
)

from conformance.device.lacking import NotTestable
from conformance.device.permits import Permits
from conformance.device.roles import Roles
from conformance.dialogue.object_expectations import value_of
from conformance.reference.built_in_device import reference_entries
from conformance.run.case_run import begin_case
from conformance.run.discovery import discover
from conformance.run.verdict import Verdict
from conformance.run.whole_reading import MOST_IN_SEGMENTS, MOST_READ
from conformance.sdo.frames import BlockUploadInitiate, Response, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.rules import Level, Rule

RULE = Rule("test.long", "7.2.4", Level.MUST, "A value is long.")
SIZE = MOST_READ + 1


class _Announcing(Recording):
    """Announces SIZE bytes, however many there are."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        is_announced = mux == DOMAIN.mux and not response.expedited
        return UploadInitiateResponse.with_size(mux, SIZE) if is_announced else response


class _WithoutBlocks(Recording):
    """Has no block uploads."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        return self.on_unexpected(request)


class _Unsized(Recording):
    """Announces no sizes."""

    def start_upload(self, mux: Multiplexer, data: bytes) -> UploadInitiateResponse:
        response = super().start_upload(mux, data)
        return response if response.expedited else UploadInitiateResponse.with_size(mux, None)


class _UnsizedWithoutBlocks(_Unsized, _WithoutBlocks):
    """Has no block uploads either."""


def long_domain(size: int, kind: type[Recording] = Recording) -> Recording:
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = bytes(size)
    return recording(kind, entries)


def test_what_is_too_long_is_begun_and_never_written() -> None:
    server = long_domain(SIZE)
    with discovered(server) as bench:
        device = bench.device
        assert DOMAIN.mux not in device.values
        assert device.beliefs.too_long == {DOMAIN.mux}
        assert DOMAIN.mux not in device.beliefs.misread
        assert len(server.requests) < MOST_IN_SEGMENTS // SEGMENT_LENGTH + 100
        assert bench.dialogue().fence() == [], "the upload was ended"
        session = bench.session()
        session.survey()
        assert list(session.causes) == [], "it is no fault"
        assert Roles(device).variable(257) == TEXT
        with pytest.raises(NotTestable, match="too long for that: it has 100001 bytes"):
            value_of(device, DOMAIN)
        assert (
            begin_case(session, "a.case", "a service", RULE).conclude(None).verdict is Verdict.PASS
        )
    assert {mux for mux, _ in server.writes} <= {NUMBER.mux, Multiplexer(0x2001), TEXT.mux}


def test_what_is_as_long_as_anything_that_is_read() -> None:
    with discovered(long_domain(MOST_READ)) as bench:
        assert bench.device.values[DOMAIN.mux] == bytes(MOST_READ)


@pytest.mark.parametrize("size", [20, MOST_IN_SEGMENTS - 20])
def test_a_size_that_is_announced_wrongly_is_no_long_value(size: int) -> None:
    with discovered(long_domain(size, _Announcing)) as bench:
        assert DOMAIN.mux in bench.device.beliefs.misread
        assert not bench.device.beliefs.too_long
        assert bench.device.beliefs.unreadable[DOMAIN.mux].startswith("upload.size: ")


@pytest.mark.parametrize(("size", "is_read"), [(MOST_IN_SEGMENTS, True), (6000, False)])
def test_without_block_uploads_less_is_read(size: int, is_read: bool) -> None:
    """A run would read and write it several times, in thousands of requests."""
    server = long_domain(size, _WithoutBlocks)
    with discovered(server) as bench:
        device = bench.device
        assert (DOMAIN.mux in device.values) is is_read
        assert (DOMAIN.mux in device.beliefs.too_long) is not is_read
        assert len(server.requests) < MOST_IN_SEGMENTS // SEGMENT_LENGTH + 100
        assert bench.dialogue().fence() == []
        if not is_read:
            with pytest.raises(NotTestable, match=r"5000 are read in segments \(more with --sdo"):
                value_of(device, DOMAIN)


@pytest.mark.parametrize("permits", [Permits(at_length=True), Permits(large=DOMAIN)])
def test_who_has_the_time_has_it_read(permits: Permits) -> None:
    with undiscovered(long_domain(6000, _WithoutBlocks)) as bench:
        device = replace(bench.device, permits=permits)
        discover(bench.channel, device)
        assert device.values[DOMAIN.mux] == bytes(6000)


def test_what_is_read_in_segments_is_counted_together() -> None:
    """Each of them would be read and written several times."""
    entries = reference_entries(NODE_ID)
    for mux in (TEXT.mux, DOMAIN.mux):
        entries[mux].value = bytes(range(1, 251)) * 12
    with discovered(recording(_WithoutBlocks, entries)) as bench:
        assert set(bench.device.values) >= {TEXT.mux}
        assert bench.device.beliefs.too_long == {DOMAIN.mux}


def test_what_is_too_much_to_be_read_in_segments_comes_in_blocks() -> None:
    """The first of two is read as a whole run will read it, the other in blocks."""
    entries = reference_entries(NODE_ID)
    for mux in (TEXT.mux, DOMAIN.mux):
        entries[mux].value = bytes(range(1, 251)) * 240
    server = recording(Recording, entries)
    with discovered(server) as bench:
        assert bench.device.values[TEXT.mux] == entries[TEXT.mux].value
        assert bench.device.values[DOMAIN.mux] == entries[DOMAIN.mux].value
        assert not bench.device.beliefs.too_long
    assert len(server.requests) < 1.3 * 60_000 / SEGMENT_LENGTH


@pytest.mark.parametrize(("kind", "is_read"), [(Recording, True), (_WithoutBlocks, False)])
def test_a_quick_run_has_no_time_for_many_segments(kind: type[Recording], is_read: bool) -> None:
    server = long_domain(4000, kind)
    with undiscovered(server) as bench:
        device = replace(bench.device, permits=Permits(in_haste=True))
        discover(bench.channel, device)
        assert device.values.get(DOMAIN.mux) == (bytes(4000) if is_read else None)
    assert len(server.requests) < 400


@pytest.mark.parametrize(("kind", "is_read"), [(_Unsized, True), (_UnsizedWithoutBlocks, False)])
def test_how_much_it_is_may_show_at_the_end_only(kind: type[Recording], is_read: bool) -> None:
    with discovered(long_domain(6000, kind)) as bench:
        assert bench.device.values.get(DOMAIN.mux) == (bytes(6000) if is_read else None)
        assert (DOMAIN.mux in bench.device.beliefs.too_long) is not is_read
