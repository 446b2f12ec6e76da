"""As many bytes as an object takes: found out once, and remembered for the run."""

import pytest
from support.run_bench import DOMAIN, NODE_ID, TEXT, discovered

from conformance.device.learned import Lengths
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.block_downloads import lose_segment, send_again
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.value_access import ValueAccess
from conformance.faults.catalogue import build_node
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, DownloadSegment, Response
from conformance.sdo.objects import Refusal
from conformance.sdo.rules import UNSOLICITED, Cause, Violation
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        (None, {3: 3, 9: 9, 20: 20}),
        ("strings-of-8-bytes", {3: 3, 9: 8, 20: 8}),
        ("strings-of-19-bytes", {20: 19, 9: 9}),
        ("values-of-fixed-length", {3: 24, 30: 24, 24: 24}),
        ("values-of-fixed-length-8", {20: 8, 5: 8}),
    ],
)
def test_what_fits(name: str | None, sizes: dict[int, int]) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        for known in (TEXT, DOMAIN):
            for wanted, size in sizes.items():
                assert Room(bench.dialogue()).fit(known, wanted) == size
                data = Room(bench.dialogue()).prepare(known, wanted)
                assert len(data) == size
                assert bench.dialogue().upload(known) == data


def test_what_is_known_is_not_asked_again() -> None:
    with discovered(build_node("values-of-fixed-length", NODE_ID)) as bench:
        Room(bench.dialogue()).fit(TEXT, 20)
        sdo = bench.dialogue()
        assert Room(sdo).fit(TEXT, 5) == 24
        with pytest.raises(NotTestable, match=r"takes values of 24 bytes only .*06070013h"):
            Room(sdo).store(TEXT, b"x" * 5)
        assert not sdo.record.written


def test_too_few_bytes_are_not_testable() -> None:
    with (
        discovered(build_node("strings-of-8-bytes", NODE_ID)) as bench,
        pytest.raises(NotTestable, match=r"8 bytes at most .* name a larger string or domain"),
    ):
        Room(bench.dialogue()).fit(TEXT, 20, least=15)


def test_what_takes_no_value_at_all_is_told_once_and_lacks_then() -> None:
    with discovered(build_node("strings-take-nothing", NODE_ID)) as bench:
        with pytest.raises(Violation, match="05040001h"):
            Room(bench.dialogue()).store(TEXT, b"x" * 20)
        sdo = bench.dialogue()
        with pytest.raises(
            NotTestable, match=r"takes no value, however .*05040001h.* name another"
        ):
            Room(sdo).store(TEXT, b"x" * 5)
        assert not sdo.record.written


def test_what_takes_but_short_values_does_not_lack() -> None:
    """Behind its defect there may be another, and the defect is in the way of the cases."""
    with discovered(Node(NODE_ID, OneSegmentOnly(reference_device(NODE_ID)))) as bench:
        for _ in range(2):
            with pytest.raises(Violation, match="06010000h"):
                Room(bench.dialogue()).store(TEXT, b"x" * 20)
        Room(bench.dialogue()).store(TEXT, b"x")


def test_a_domain_stands_in_for_a_string_that_is_too_short() -> None:
    with discovered(build_node("strings-of-8-bytes-domains-of-4200", NODE_ID)) as bench:
        assert Roles(bench.device).text().mux == TEXT.mux
        Room(bench.dialogue()).fit(TEXT, 20)
        assert Roles(bench.device).text().mux == DOMAIN.mux


@pytest.mark.parametrize("name", [None, "strings-of-8-bytes", "values-of-fixed-length"])
def test_what_was_lost_is_sent_again(name: str | None) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        sdo = bench.dialogue()
        gap = lose_segment(sdo, TEXT, 28, 2)
        assert gap is not None
        send_again(sdo, TEXT, gap)
        assert sdo.upload(TEXT) == gap.data


class OneSegmentOnly(SegmentedServer):
    """Refuses the second segment of whatever is written, and block transfers."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if not request.last:
            self.transfer = None
            raise Refusal(AbortCode.UNSUPPORTED_ACCESS)
        return super().on_download_segment(request)


class AbortsInCrossing(Server):
    """Ends its first download while a segment is on the way, which an idle server refuses."""

    has_aborted = False
    code = AbortCode.TIMED_OUT

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        transfer = self.transfer
        if transfer is None or self.has_aborted:
            return super().on_download_segment(request)
        self.has_aborted, self.transfer = True, None
        crossed = self.refuse(request, AbortCode.COMMAND_NOT_VALID)
        return [Abort(transfer.mux, self.code), *crossed]


def test_a_segment_that_crosses_with_an_abort() -> None:
    """It is refused, which is not the answer to the next try."""
    server = AbortsInCrossing(reference_device(NODE_ID))
    with discovered(Node(NODE_ID, server)) as bench:
        server.has_aborted = False
        sdo = bench.dialogue()
        Room(sdo).store(TEXT, b"x" * 20, segmented=True)
        assert server.has_aborted
        assert sdo.record.minor == []
        assert sdo.upload(TEXT) == b"x" * 20


NOISE = Cause(ABORT_NOT_ANSWERED.id, "an answer")


class AbortsAlwaysInCrossing(AbortsInCrossing):
    """Does so with each download that is not in blocks."""

    is_discovered = False

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        self.has_aborted = not self.is_discovered
        return super().on_download_segment(request)


def test_segments_that_cross_with_aborts_on_several_ways() -> None:
    """What the device is blamed for is that it ends each download, though it has sent too much."""
    server = AbortsAlwaysInCrossing(reference_device(NODE_ID))
    with discovered(Node(NODE_ID, server)) as bench:
        server.is_discovered = True
        sdo = bench.dialogue()
        unasked = Violation(ABORT_NOT_ANSWERED, expected="no answer", actual="an abort")
        sdo.record.causes.add(NOISE, "another.case", unasked, aside=True)
        Room(sdo).store(TEXT, b"x" * 20, segmented=True)
        assert UNSOLICITED not in {found.rule for found in sdo.record.minor}
        assert sdo.upload(TEXT) == b"x" * 20


def test_one_length_proves_nothing_of_shorter_ones() -> None:
    lengths = Lengths({4096})
    assert (lengths.surely, lengths.fit(20), lengths.fit(4096)) == (None, None, 4096)
    lengths.taken.add(4)
    assert (lengths.surely, lengths.fit(20)) == (4096, 20)


def test_a_length_between_others_may_be_refused() -> None:
    """What takes n + 1 bytes need not take n: the nearest one that it takes will do."""
    with discovered(build_node("lengths-in-steps-of-4", NODE_ID)) as bench:
        sdo = bench.dialogue()
        assert Room(sdo).fit(DOMAIN, 20) == 20
        assert Room(sdo).fit(DOMAIN, 24) == 24
        assert Room(sdo).fit(DOMAIN, 22) == 20
        assert Room(sdo).has(DOMAIN, 20)
        assert not Room(sdo).has(DOMAIN, 19)
        with pytest.raises(NotTestable, match="takes no value of 19 bytes"):
            Room(sdo).need(DOMAIN, 19)


def test_what_takes_no_value_is_read_as_it_is() -> None:
    with discovered(build_node("strings-take-nothing", NODE_ID)) as bench:
        with pytest.raises(Violation, match="05040001h"):
            Room(bench.dialogue()).store(TEXT, b"x" * 20)
        bench.device.contents.leave(TEXT.mux)
        sdo = bench.dialogue()
        ValueAccess(sdo).write_own(TEXT.mux)
        assert not sdo.record.written
