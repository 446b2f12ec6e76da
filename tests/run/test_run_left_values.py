"""Strings and domains stay as cases leave them until somebody needs what they held, or the end."""

import json
from typing import Any

import pytest
from support.run_bench import DOMAIN, NODE_ID, NUMBER, RULE, TEXT, Recording, discovered, recording

from conformance.device.change_journal import BACK, CHANGED
from conformance.device.device import TWO_SEGMENTS
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.value_access import ValueAccess
from conformance.model_cases.lockstep import knowledge_of
from conformance.reference.built_in_device import reference_entries
from conformance.reference.server import BlockDownload
from conformance.run.case_run import CaseRun, begin_case
from conformance.run.session import DeviceSession
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockUploadInitiate,
    UploadSegment,
)
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.rules import Violation

LONG = bytes(range(0x20, 0x7F)) * 3


def begin(session: DeviceSession) -> CaseRun:
    """Begin a case of the suite's own."""
    return begin_case(session, "a.case", "a service", RULE, own=True)


def test_a_string_stays_a_number_does_not() -> None:
    server = recording()
    before = server.values()
    told: list[dict[str, Any]] = []
    with discovered(server) as bench:
        bench.device.contents.tell = told.append
        session = bench.session()
        run = begin(session)
        for known, value in ((TEXT, b"left"), (NUMBER, b"\1\2\3\4")):
            run.sdo.download(known, value)
        run.conclude(None)
        assert server.values() == {**before, TEXT.mux: b"left"}
        assert session.restorer.unrestored.keys() == {TEXT.mux}
        assert knowledge_of(bench.device, {}).of(TEXT.mux).value is None, "it was not read"
        assert [record["object"] for record in told if record["record"] == BACK] == ["2004h:00"]
        session.restore_pending()
    assert server.values() == before
    assert session.restorer.unrestored == {}
    first = {"record": CHANGED, "object": "2010h:00", "value": b"text".hex()}
    assert first.items() <= told[0].items(), json.dumps(told)
    assert told[-1] == {"record": BACK, "object": "2010h:00"}


@pytest.mark.parametrize(
    ("own", "written", "stays"), [(5, 994, True), (5, 1009, False), (2000, 1009, True)]
)
def test_what_is_very_long_stays_only_where_it_was_as_long(
    own: int, written: int, *, stays: bool
) -> None:
    """Another case may read it as it is, in thousands of requests."""
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = before = bytes(own)
    server = Recording(entries)
    with discovered(server) as bench:
        run = begin(bench.session())
        Blocks(run.sdo).download(DOMAIN, left := bytes(n % 250 for n in range(written)))
        run.conclude(None)
        assert server.entries[DOMAIN.mux].value == (left if stays else before)


def test_a_test_of_the_users_finds_what_was_there() -> None:
    server = recording()
    before = server.values()
    with discovered(server) as bench:
        session = bench.session()
        run = begin(session)
        run.sdo.download(TEXT, b"left")
        run.conclude(None)
        begin_case(session, "test_mine", "mine", RULE)
        assert server.values() == before
        assert session.frames_so_far() == 0, "it is no part of the case"


def test_what_a_case_has_read_last_the_next_one_knows() -> None:
    server = recording()
    with discovered(server) as bench:
        session = bench.session()
        run = begin(session)
        run.sdo.download(TEXT, b"left")
        run.sdo.upload(TEXT)
        run.conclude(None)
        run = begin(session)
        assert bench.device.contents.value(TEXT.mux) == b"left"
        run.sdo.download(NUMBER, bytes(4))
        assert bench.device.contents.value(TEXT.mux) is None, "who knows what that changes"
        ValueAccess(run.sdo).write_own(TEXT.mux)
        assert run.sdo.upload(TEXT) == b"text"
        run.conclude(None)
        assert session.restorer.unrestored == {}


class _WrongInBlocks(Recording):
    """Confirms block downloads of long values, and stores nothing but 00h."""

    def store(self, entry: Entry, data: bytes) -> None:
        in_blocks = isinstance(self.transfer, BlockDownload)
        super().store(entry, bytes(len(data)) if in_blocks and len(data) > 100 else data)


@pytest.mark.parametrize("kind", [Recording, _WrongInBlocks])
def test_long_values_are_put_back_in_blocks_where_that_works(kind: type[Recording]) -> None:
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = LONG
    server = kind(entries)
    with discovered(server) as bench:
        session = bench.session()
        asked: list[list[type]] = []
        for _ in range(3):
            run = begin(session)
            Blocks(run.sdo).download(DOMAIN, b"short")
            Blocks(run.sdo).upload(DOMAIN)
            run.conclude(None)
            server.requests.clear()
            session.restore_pending()
            assert server.entries[DOMAIN.mux].value == LONG
            asked.append([type(decode_request(frame)) for frame in server.requests])
    first, *others = asked
    assert {UploadSegment, BlockUploadInitiate} <= set(first), "compared once"
    works = kind is Recording
    for each in others:
        assert (BlockDownloadInitiate in each) == works
        assert UploadSegment not in each
        assert BlockUploadInitiate in each


BROKEN = Violation(RULE, expected="this", actual="that")


class _TakesOneLength(Recording):
    """Refuses a value of another length than what it has."""

    def store(self, entry: Entry, data: bytes) -> None:
        if entry is self.entries[DOMAIN.mux] and len(data) != len(LONG):
            raise Refusal(AbortCode.LENGTH_MISMATCH)
        super().store(entry, data)


class _WrongWhenShort(Recording):
    """Loses the last byte of a short value."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data[:-1] if 4 < len(data) < 64 else data)


@pytest.mark.parametrize("taken", [20, None], ids=["taken-before", "never-tried"])
@pytest.mark.parametrize("ending", [None, BROKEN], ids=["passes", "fails"])
@pytest.mark.parametrize("kind", [Recording, _WrongWhenShort, _TakesOneLength])
def test_a_short_value_stands_in_for_a_long_one(
    kind: type[Recording], ending: Violation | None, taken: int | None
) -> None:
    """Behind a case that fails, or leaves more than another should have to read.

    Also early in a run, when it is not known yet which lengths are taken.
    """
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = LONG
    server = kind(entries)
    with discovered(server) as bench:
        told: list[dict[str, Any]] = []
        bench.device.contents.tell = told.append
        if taken is not None:
            bench.device.learned.lengths[DOMAIN.mux].taken |= {len(LONG), taken}
        session = bench.session()
        run = begin(session)
        size = len(LONG) if kind is _TakesOneLength else 2000
        Blocks(run.sdo).download(DOMAIN, bytes(n % 250 for n in range(size)))
        server.requests.clear()
        run.conclude(ending)
        left = server.entries[DOMAIN.mux].value
        if kind is Recording:
            assert len(left) == (taken or TWO_SEGMENTS)
            assert len(server.requests) < 20
            assert session.restorer.unrestored.keys() == {DOMAIN.mux}
            assert [record["record"] for record in told] == [CHANGED], "for a run that is killed"
            assert told[0]["value"] == LONG.hex()
            assert begin(session).sdo.upload(DOMAIN) == left
        elif kind is _WrongWhenShort or ending is not None:
            assert left == LONG, "it holds what it should, and nothing that is not known"
        session.restore_pending()
    assert server.entries[DOMAIN.mux].value == LONG
    assert session.restorer.unrestored == {}


def test_a_short_value_is_put_back_itself() -> None:
    server = recording()
    before = server.values()
    with discovered(server) as bench:
        bench.device.learned.lengths[TEXT.mux].taken |= {3, 20}
        run = begin(bench.session())
        run.sdo.download(TEXT, b"left")
        run.conclude(BROKEN)
        assert server.values() == before


def test_a_try_that_is_run_again_finds_what_the_first_one_found() -> None:
    """Whatever earlier cases had left there: else each try would have something else to do."""
    server = recording()
    before = server.values()
    with discovered(server) as bench:
        session = bench.session()
        for left in (b"left", b"left again"):
            run = begin(session)
            run.sdo.download(TEXT, left)
            run.conclude(None)
        run = begin(session)
        run.sdo.download(TEXT, b"tried")
        assert run.retreat(1)
        assert server.values() == before
        assert session.restorer.unrestored == {}


@pytest.mark.parametrize("is_read", [True, False])
def test_what_may_be_empty_is_put_back_at_once(is_read: bool) -> None:
    """A device may refuse to read it, and the cases that read all objects would fail."""
    server = recording()
    before = server.values()
    with discovered(server) as bench:
        run = begin(bench.session())
        run.sdo.download(TEXT, b"")
        if is_read:
            run.sdo.upload(TEXT)
        run.conclude(None)
        assert server.writes[0] == (TEXT.mux, b"")
        assert server.values() == before


@pytest.mark.parametrize("left", [b"left", None, LONG[:200]], ids=["short", "unread", "long"])
def test_a_try_that_is_run_again_finds_no_long_value_where_one_was_away(left: bytes | None) -> None:
    """To put that back for each try would take hundreds of requests."""
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = LONG
    server = recording(entries=entries)
    with discovered(server) as bench:
        session = bench.session()
        run = begin(session)
        run.sdo.download(DOMAIN, left or b"not read")
        if left is not None:
            run.sdo.upload(DOMAIN)
        run.conclude(None)
        run = begin(session)
        run.sdo.download(DOMAIN, b"tried and failed")
        server.requests.clear()
        assert run.retreat(1)
        found = server.entries[DOMAIN.mux].value
        assert found == left if left == b"left" else len(found) == TWO_SEGMENTS
        assert begin(session).sdo.device.contents.value(DOMAIN.mux) == found, "it was read back"
        assert len(server.requests) < 20
        session.restore_pending()
    assert server.entries[DOMAIN.mux].value == LONG
    assert session.restorer.unrestored == {}


def test_a_try_that_has_found_the_long_value_itself_leaves_it() -> None:
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = LONG
    server = recording(entries=entries)
    with discovered(server) as bench:
        run = begin(bench.session())
        run.sdo.download(DOMAIN, b"tried")
        assert run.retreat(1)
    assert server.entries[DOMAIN.mux].value == LONG


def test_what_is_tried_before_the_first_case_is_put_back_at_once() -> None:
    """Whether a device takes back what it held shows there, and in no case that needs it."""
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = LONG
    server = recording(entries=entries)
    before = server.values()
    with discovered(server) as bench:
        session = bench.session()
        session.survey()
        assert DOMAIN.mux in dict(server.writes)
        assert server.values() == before
        assert bench.device.contents.left() == set()
