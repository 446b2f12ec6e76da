"""What cases wrote is put back, whatever way it was written; what cannot be is told."""

from dataclasses import replace

import pytest
from support.run_bench import (
    DOMAIN,
    NODE_ID,
    NUMBER,
    RULE,
    TEXT,
    Recording,
    discovered,
    recording,
)

from conformance.device.contents import Holds
from conformance.device.known_objects import KnownObject
from conformance.device.safety import WritePolicy
from conformance.dialogue.channels import Channels
from conformance.dialogue.parameters import Parameters
from conformance.faults.unusual.frame_shape import ShortFramesServed
from conformance.model_cases.lockstep import knowledge_of
from conformance.reference.built_in_device import reference_entries
from conformance.reference.communication import communication_entries
from conformance.reference.communication_values import (
    COUNTER_OVERFLOW,
    CYCLE_PERIOD,
    value_entries,
)
from conformance.run.case_run import begin_case
from conformance.run.restorer import Restorer
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, DownloadInitiate, Response, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, Refusal
from conformance.sdo.pdos import Mapped

WRITE_ONLY = Multiplexer(0x2020)
MAPPED = Mapped(NUMBER.mux, bits=32)


@pytest.mark.parametrize(
    ("known", "value"),
    [
        (NUMBER, b"\1\2\3\4"),
        (TEXT, b"another text of 25 bytes."),
        (DOMAIN, bytes(300)),
        (TEXT, b""),
    ],
    ids=["number", "text", "domain", "empty"],
)
def test_what_was_written_is_put_back(known: KnownObject, value: bytes) -> None:
    server = recording()
    begin = server.values()
    with discovered(server) as bench:
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        sdo.download(known, value)
        assert server.values() != begin
        restorer.restore(sdo)
    assert server.values() == begin
    assert server.writes == [(known.mux, value), (known.mux, begin[known.mux])]
    assert restorer.unrestored == {}


class _TakesTooMuch(Recording):
    """Stores however many bytes come, and tells them all."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Take any."""

    def store(self, entry: Entry, data: bytes) -> None:
        entry.value = data


def test_a_number_that_has_become_too_long() -> None:
    """What lies behind its type is not as before, whatever the number is."""
    server = _TakesTooMuch(reference_entries(NODE_ID))
    begin = server.values()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.download(NUMBER, begin[NUMBER.mux] + b"\0")
        Restorer(bench.device).restore(sdo)
        known = bench.device.known[NUMBER.mux]
    assert server.values() == begin
    assert not known.habits.too_long


def test_several_objects() -> None:
    server = recording()
    begin = server.values()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        for known, value in ((NUMBER, b"\1\2\3\4"), (TEXT, b"abc"), (DOMAIN, b"def")):
            sdo.download(known, value)
        Restorer(bench.device).restore(sdo)
    assert server.values() == begin


def test_nothing_is_written_that_reads_as_it_should() -> None:
    """Neither what no case wrote, nor what a device refused, nor what has its value already."""
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        Restorer(bench.device).restore(sdo)
        assert sdo.try_download(NUMBER, b"\1\2") is not None
        sdo.download(TEXT, bench.device.values[TEXT.mux])
        server.writes.clear()
        Restorer(bench.device).restore(sdo)
    assert server.writes == []


def test_the_zero_behind_a_string_does_not_count() -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.download(TEXT, b"text\0")
        server.writes.clear()
        Restorer(bench.device).restore(sdo)
    assert server.writes == []


class _Refusing(Recording):
    """Refuses some uploads and downloads of the number: as many as it is told."""

    uploads = downloads = 0

    def on_upload_initiate(self, request: UploadInitiate) -> list[Response]:
        if self.uploads and request.mux == NUMBER.mux:
            self.uploads -= 1
            raise Refusal(AbortCode.LOCAL_CONTROL)
        return super().on_upload_initiate(request)

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if self.downloads and request.mux == NUMBER.mux:
            self.downloads -= 1
            raise Refusal(AbortCode.LOCAL_CONTROL)
        return super().on_download_initiate(request)


@pytest.mark.parametrize("refused", ["uploads", "downloads"])
def test_what_is_refused_once_is_asked_for_again(refused: str) -> None:
    """A device that is busy for a moment has done nothing wrong."""
    server = _Refusing(reference_entries(NODE_ID))
    begin = server.values()
    with discovered(server) as bench:
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        sdo.download(NUMBER, b"\1\2\3\4")
        setattr(server, refused, 1)
        restorer.restore(sdo)
    assert getattr(server, refused) == 0
    assert (restorer.unrestored, restorer.late) == ({}, [])
    assert server.values() == begin


def test_a_mapping_is_put_back_in_the_order_that_it_takes() -> None:
    """Out of use and mapping nothing, then its entries, how many there are, and its COB-ID."""
    entries = reference_entries(NODE_ID)
    entries |= communication_entries(NODE_ID, MAPPED, MAPPED)
    server = recording(entries=entries)
    begin = server.values()
    cob_id, count = Multiplexer(0x1800, 1), Multiplexer(0x1A00)
    first, second = Multiplexer(0x1A00, 1), Multiplexer(0x1A00, 2)
    with discovered(server) as bench:
        policy = WritePolicy([], frozenset({"pdo-parameters"}))
        bench.device = replace(bench.device, policy=policy)
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        entry = sdo.upload(first)
        for mux in (cob_id, count, first, second):
            Parameters(sdo).learn(mux)
        Channels(sdo).disable(cob_id)
        sdo.download(count, b"\0")
        sdo.download(second, entry)
        sdo.download(count, b"\1")
        sdo.download(cob_id, begin[cob_id])
        sdo.record.written = {second}
        server.writes.clear()
        restorer.restore(sdo)
    assert restorer.unrestored == {}
    assert server.values() == begin
    assert [mux for mux, _ in server.writes] == [cob_id, count, second, count, cob_id]


def test_the_inhibit_time_is_put_back_while_the_pdo_is_out_of_use() -> None:
    entries = reference_entries(NODE_ID) | communication_entries(NODE_ID, MAPPED, MAPPED)
    server = recording(entries=entries)
    begin = server.values()
    cob_id, inhibit_time = Multiplexer(0x1800, 1), Multiplexer(0x1800, 3)
    with discovered(server) as bench:
        policy = WritePolicy([], frozenset({"pdo-parameters"}))
        bench.device = replace(bench.device, policy=policy)
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        for mux in (cob_id, inhibit_time):
            Parameters(sdo).learn(mux)
        Channels(sdo).disable(cob_id)
        sdo.download(inhibit_time, b"\1\0")
        sdo.download(cob_id, begin[cob_id])
        sdo.record.written = {inhibit_time}
        server.writes.clear()
        restorer.restore(sdo)
    assert restorer.unrestored == {}
    assert server.values() == begin
    assert [mux for mux, _ in server.writes] == [cob_id, inhibit_time, cob_id]


class _Late(Recording):
    """Sends an abort before its next answer to a request that begins like this."""

    before = b""

    def receive(self, frame: bytes) -> list[bytes]:
        responses = super().receive(frame)
        if self.before and frame.startswith(self.before):
            self.before = b""
            responses.insert(0, Abort(WRITE_ONLY, AbortCode.GENERAL_ERROR).encode())
        return responses


@pytest.mark.parametrize("seen", [True, False], ids=["before-the-write", "before-the-read"])
def test_a_late_answer_in_the_way(seen: bool) -> None:
    """It is told, the value is back, and nothing is left for the next case to stumble over."""
    server = _Late(reference_entries(NODE_ID))
    begin = server.values()
    with discovered(server) as bench:
        session = bench.session()
        run = begin_case(session, "a.case", "a service", RULE)
        run.sdo.download(NUMBER, b"\1\2\3\4")
        if seen:
            run.sdo.upload(NUMBER)
        server.before = (b"\x23" if seen else b"\x40") + b"\x04\x20"
        run.conclude(None)
        assert server.values() == begin
        assert session.restorer.unrestored == {}
        assert [late.case_id for late in session.whole_run.late] == ["a.case"]
        assert bench.channel.receive(0) is None


class _Silent(Recording):
    """Does not answer some downloads of the number: as many as it is told."""

    downloads = 0

    def receive(self, frame: bytes) -> list[bytes]:
        if self.downloads and frame.startswith(b"\x23\x04\x20"):
            self.downloads -= 1
            return []
        return super().receive(frame)


def test_what_a_silence_kept_from_being_put_back_is_written_behind_the_next_case() -> None:
    server = _Silent(reference_entries(NODE_ID))
    begin = server.values()
    with discovered(server, timeout=0.5) as bench:
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        sdo.download(NUMBER, b"\1\2\3\4")
        server.downloads = 2
        restorer.restore(sdo)
        assert bench.device.contents.holds(NUMBER.mux) is Holds.UNKNOWN
        unknown = knowledge_of(bench.device, {}).of(NUMBER.mux)
        restorer.restore(sdo)
        assert bench.device.contents.holds(NUMBER.mux) is Holds.OWN
    assert restorer.unrestored == {}
    assert server.values() == begin
    assert unknown.value is None, "its value is unknown"


def test_what_cannot_be_put_back_is_listed_until_it_can() -> None:
    server = _Refusing(reference_entries(NODE_ID))
    begin = server.values()
    with discovered(server) as bench:
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        sdo.download(NUMBER, b"\1\2\3\4")
        sdo.download(TEXT, b"also written")
        server.downloads = 2
        restorer.restore(sdo)
        assert list(restorer.unrestored) == [NUMBER.mux]
        text = restorer.unrestored[NUMBER.mux]
        assert text.startswith("4 bytes: 11 22 33 44")
        assert "08000021h" in text
        assert server.values()[TEXT.mux] == begin[TEXT.mux], "the others are put back all the same"
        asked = len(server.requests)
        restorer.restore(sdo)
        assert list(restorer.unrestored) == [NUMBER.mux]
        assert not any(b"\x04\x20" in frame for frame in server.requests[asked:]), (
            "not after each case"
        )
        restorer.restore_pending(sdo)
    assert restorer.unrestored == {}
    assert server.values() == begin


def test_what_is_put_back_and_cannot_be_read_is_listed() -> None:
    server = recording()
    with discovered(server) as bench:
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        sdo.download(NUMBER, b"\1\2\3\4")
        server.entries[NUMBER.mux].access = Access.CONST
        restorer.restore(sdo)
        assert "06010002h" in restorer.unrestored[NUMBER.mux]
        server.entries[NUMBER.mux].access = Access.WO
        restorer.restore_pending(sdo)
    assert restorer.unrestored == {NUMBER.mux: "4 bytes: 11 22 33 44"}


def test_a_write_only_object_is_left() -> None:
    """What it held cannot be known."""
    server = recording()
    known = KnownObject(WRITE_ONLY, DataType.UNSIGNED32, Access.WO)
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.download(known, b"\1\2\3\4")
        server.requests.clear()
        Restorer(bench.device).restore(sdo)
    assert server.requests == []


@pytest.mark.parametrize("extended", [False, True])
def test_a_frame_of_the_cases_own_counts_as_written(extended: bool) -> None:
    """Also one that the device should not have taken."""
    server = recording()
    begin = server.values()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        data = DownloadInitiate.with_data(NUMBER.mux, b"\1\2\3\4").encode()
        sdo.send_frame(CanFrame(0x605, data, extended))
        sdo.fence()
        server.entries[NUMBER.mux].value = b"\1\2\3\4"
        Restorer(bench.device).restore(sdo)
    assert server.values() == begin


def test_a_short_frame_counts_as_written() -> None:
    """A careless device completes it and writes."""
    server = recording()
    begin = server.values()
    careless = ShortFramesServed(NODE_ID, server)
    with discovered(careless) as bench:
        sdo = bench.dialogue()
        sdo.send(DownloadInitiate.with_data(Multiplexer(0x2002), b"\1\2").encode()[:6])
        assert sdo.reaction() is not None
        assert server.values() != begin
        Restorer(bench.device).restore(sdo)
    assert server.values() == begin


def test_the_sync_counter_is_put_back_while_there_is_no_period() -> None:
    entries = reference_entries(NODE_ID) | value_entries()
    entries[CYCLE_PERIOD].value = b"\x10\x27\0\0"
    server = recording(entries=entries)
    begin = server.values()
    with discovered(server) as bench:
        bench.device = replace(bench.device, policy=WritePolicy([], frozenset({"sync-parameters"})))
        restorer = Restorer(bench.device)
        sdo = bench.dialogue()
        for mux in (CYCLE_PERIOD, COUNTER_OVERFLOW):
            Parameters(sdo).learn(mux)
        sdo.download(CYCLE_PERIOD, bytes(4))
        sdo.download(COUNTER_OVERFLOW, b"\x0a")
        sdo.download(CYCLE_PERIOD, begin[CYCLE_PERIOD])
        sdo.record.written = {COUNTER_OVERFLOW}
        server.writes.clear()
        restorer.restore(sdo)
    assert restorer.unrestored == {}
    assert server.values() == begin
    assert [mux for mux, _ in server.writes] == [CYCLE_PERIOD, COUNTER_OVERFLOW, CYCLE_PERIOD]
