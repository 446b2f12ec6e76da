"""What a device was seen to hold, and how much it takes, is not asked twice; nor relied on long."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from support.run_bench import (
    NODE_ID,
    NUMBER,
    RULE,
    TEXT,
    Recording,
    Workbench,
    discovered,
    recording,
)

from conformance.device.effort import MUCH_ROOM
from conformance.device.not_testable import NotTestable
from conformance.device.permits import Permits
from conformance.device.protected_objects import NMT
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.network import Network
from conformance.faults.catalogue import build_node
from conformance.run.case_run import begin_case
from conformance.run.restorer import Restorer
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadSegment,
    Response,
    UploadInitiate,
)
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import Refusal
from conformance.sdo.rules import Violation

OTHER = b"\1\2\3\4"
READ = UploadInitiate(NUMBER.mux).encode()


def restored(bench: Workbench, server: Recording, sdo: Dialogue) -> list[bytes]:
    """Return the requests by which the values are put back."""
    server.requests.clear()
    restorer = Restorer(bench.device)
    restorer.restore(sdo)
    assert restorer.unrestored == {}
    return list(server.requests)


def test_what_was_seen_changed_is_written_at_once() -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.download(NUMBER, OTHER)
        assert sdo.upload(NUMBER) == OTHER
        written = DownloadInitiate.with_data(NUMBER.mux, bench.device.values[NUMBER.mux])
        assert restored(bench, server, sdo) == [written.encode(), READ]


def test_what_was_seen_to_be_back_is_left_alone() -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.download(NUMBER, bench.device.values[NUMBER.mux])
        sdo.upload(NUMBER)
        assert restored(bench, server, sdo) == []


@pytest.mark.parametrize(
    "after",
    [
        lambda sdo: sdo.download(TEXT, b"abc"),
        lambda sdo: sdo.send(DownloadSegment.with_data(b"abc", toggle=0)),
        lambda sdo: sdo.send(Abort(NUMBER.mux, AbortCode.GENERAL_ERROR)),
        lambda sdo: sdo.send(b"\x23\x04\x20"),
    ],
    ids=["download", "segment", "abort", "cut-short"],
)
def test_it_is_forgotten_when_anything_else_is_sent(after: Callable[[Dialogue], None]) -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.download(NUMBER, bench.device.values[NUMBER.mux])
        sdo.upload(NUMBER)
        after(sdo)
        sdo.fence()
        assert READ in restored(bench, server, sdo)


def test_it_is_forgotten_with_a_reset() -> None:
    with discovered(recording()) as bench:
        bench.device = replace(bench.device, permits=Permits(permissions=frozenset({NMT})))
        sdo = bench.dialogue()
        sdo.upload(NUMBER)
        assert sdo.device.contents.current
        Network(sdo).send(NmtCommand.RESET_COMMUNICATION)
        assert not sdo.device.contents.current


def test_it_is_forgotten_when_a_case_fails() -> None:
    """What such a server does to its objects is not known yet."""
    server = recording()
    with discovered(server) as bench:
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        run.sdo.download(NUMBER, bench.device.values[NUMBER.mux])
        run.sdo.upload(NUMBER)
        server.requests.clear()
        run.conclude(Violation(RULE, expected="one thing", actual="another"))
        assert READ in server.requests


# Room


def initiates(server: Recording) -> list[int | None]:
    """Return the sizes of the segmented downloads to the string."""
    begin = DownloadInitiate.with_size(TEXT.mux, 0).encode()[:4]
    return [int.from_bytes(frame[4:], "little") for frame in server.requests if frame[:4] == begin]


def test_room_is_asked_for_little_and_then_for_much() -> None:
    server = recording()
    begin = server.values()
    with discovered(server) as bench:
        for size in (20, 4, 20):
            Room(bench.dialogue()).need(TEXT, size)
        assert initiates(server) == [20]
        for size in (890, 21, MUCH_ROOM):
            Room(bench.dialogue()).need(TEXT, size)
        assert initiates(server) == [20, MUCH_ROOM]
        assert server.values() == begin


class _Small(Recording):
    """Takes 20 bytes of text at most."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if not request.expedited and int.from_bytes(request.payload, "little") > 20:
            raise Refusal(AbortCode.LENGTH_TOO_HIGH)
        return super().on_download_initiate(request)


def test_little_room_is_asked_for_again_when_more_is_needed() -> None:
    server = recording(_Small)
    with discovered(server) as bench:
        for size in (8, 8, 20, 9):
            Room(bench.dialogue()).need(TEXT, size)
        assert initiates(server) == [8, MUCH_ROOM, 20]


def test_too_little_room_is_not_testable() -> None:
    with discovered(build_node("strings-of-20-bytes", NODE_ID)) as bench:
        Room(bench.dialogue()).need(TEXT, 20)
        with pytest.raises(NotTestable, match="20 bytes at most"):
            Room(bench.dialogue()).need(TEXT, 21)
