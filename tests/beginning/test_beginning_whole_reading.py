"""What is too long to be read in a sensible time is begun, and neither read nor written whole."""

from dataclasses import replace

import pytest
from support.run_bench import (
    DOMAIN,
    NODE_ID,
    NUMBER,
    TEXT,
    Recording,
    discovered,
    recording,
    undiscovered,
)

from conformance.beginning.discovery import discover
from conformance.device.effort import BELIEVED, LONGEST_READ, Effort
from conformance.device.learned import Reason
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.device.permits import Permits
from conformance.dialogue.object_expectations import value_of
from conformance.reference.built_in_device import reference_entries
from conformance.run.case_run import begin_case
from conformance.run.verdict import Verdict
from conformance.sdo.frames import BlockUploadInitiate, Response, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.rules import Level, Rule

RULE = Rule("test.long", "7.2.4", Level.MUST, "A value is long.")
SIZE = LONGEST_READ + 1


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
        assert device.learned.unread_for(Reason.TOO_LONG) == {DOMAIN.mux}
        assert len(server.requests) < BELIEVED // SEGMENT_LENGTH + 100
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
    with discovered(long_domain(LONGEST_READ)) as bench:
        assert bench.device.values[DOMAIN.mux] == bytes(LONGEST_READ)


@pytest.mark.parametrize("size", [20, BELIEVED - 20])
def test_a_size_that_is_announced_wrongly_is_no_long_value(size: int) -> None:
    with discovered(long_domain(size, _Announcing)) as bench:
        assert bench.device.learned.is_unread(DOMAIN.mux, Reason.BREACH)
        assert bench.device.learned.unreadable[DOMAIN.mux].startswith("upload.size: ")


@pytest.mark.parametrize("kind", [Recording, _WithoutBlocks, _Unsized, _UnsizedWithoutBlocks])
def test_a_long_value_is_read_whole(kind: type[Recording]) -> None:
    with discovered(long_domain(20_000, kind)) as bench:
        assert bench.device.values[DOMAIN.mux] == bytes(20_000)
        assert DOMAIN.mux not in bench.device.learned.unread


@pytest.mark.parametrize(("kind", "is_read"), [(Recording, True), (_WithoutBlocks, False)])
def test_a_quick_run_has_no_time_for_many_segments(kind: type[Recording], is_read: bool) -> None:
    server = long_domain(4000, kind)
    with undiscovered(server) as bench:
        device = replace(bench.device, permits=Permits(effort=Effort.HASTE))
        discover(bench.channel, device)
        assert device.values.get(DOMAIN.mux) == (bytes(4000) if is_read else None)
    assert len(server.requests) < 400
