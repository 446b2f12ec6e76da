"""What always has a long value is read and written in blocks, where the way is not the point."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from support.run_bench import DOMAIN, NODE_ID, Workbench, discovered

from conformance.bus.link import Direction
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.value_access import ValueAccess
from conformance.faults.catalogue import build_node
from conformance.sdo.rules import Violation

SIZE = 300
VALUE = bytes(range(1, 101)) * 3


@contextmanager
def long_domain(server: str | None = None, *, alike: bool | None = True) -> Iterator[Workbench]:
    """Have a device with a domain of one length, which a device may be known to serve in blocks."""
    node = build_node(server, NODE_ID)
    node.objects.find(DOMAIN.mux).value = VALUE
    with discovered(node) as bench:
        learned = bench.device.learned
        lengths = learned.lengths[DOMAIN.mux]
        lengths.fixed, lengths.most = True, SIZE
        learned.reads_alike, learned.stores_in_blocks = alike, alike or None
        yield bench


def first_sent(bench: Workbench) -> list[str]:
    """Keep the first bytes of what is sent from now on."""
    sent: list[str] = []
    bench.channel.link.listen(
        lambda found: (
            sent.append(found.frame.data[:1].hex()) if found.direction is Direction.SENT else None
        )
    )
    return sent


@pytest.mark.parametrize(("alike", "begins"), [(True, "a4"), (None, "40")])
def test_what_an_object_holds(alike: bool | None, begins: str) -> None:
    with long_domain(alike=alike) as bench:
        sent, sdo = first_sent(bench), bench.dialogue()
        assert ValueAccess(sdo).read(DOMAIN) == VALUE
        assert sent[0] == begins
        assert sdo.device.contents.current[DOMAIN.mux] == VALUE


def test_what_is_not_always_long_is_read_in_segments() -> None:
    with long_domain() as bench:
        bench.device.learned.lengths[DOMAIN.mux].fixed = False
        sent = first_sent(bench)
        assert ValueAccess(bench.dialogue()).read(DOMAIN) == VALUE
        assert sent[0] == "40"


def test_what_cannot_be_read_in_blocks_is_read_in_segments() -> None:
    with long_domain("no-block-upload") as bench:
        assert ValueAccess(bench.dialogue()).read(DOMAIN) == VALUE


@pytest.mark.parametrize("expect", [Dialogue.expect_value, Dialogue.expect_kept])
def test_what_blocks_bring_otherwise_is_judged_by_what_segments_bring(
    expect: Callable[[Dialogue, KnownObject, bytes], None],
) -> None:
    with long_domain("block-upload-of-old-value") as bench:
        sdo = bench.dialogue()
        assert sdo.abort_of(sdo.client.block_download(DOMAIN.mux, VALUE[::-1])) is None
        sent = first_sent(bench)
        expect(sdo, DOMAIN, VALUE[::-1])
        assert sent[0] == "a4"
        assert "40" in sent
        assert not sdo.record.minor


def test_another_value_is_told() -> None:
    with long_domain() as bench, pytest.raises(Violation):
        bench.dialogue().expect_value(DOMAIN, bytes(SIZE))


@pytest.mark.parametrize(("alike", "begins"), [(True, "c6"), (None, "21")])
def test_what_is_stored(alike: bool | None, begins: str) -> None:
    with long_domain(alike=alike) as bench:
        sent, sdo = first_sent(bench), bench.dialogue()
        Room(sdo).store(DOMAIN, VALUE[::-1], segmented=True)
        assert sent[0] == begins
        assert sdo.upload(DOMAIN) == VALUE[::-1]


def test_the_way_in_which_a_value_is_stored_may_be_the_point() -> None:
    with long_domain() as bench:
        sent = first_sent(bench)
        Room(bench.dialogue()).store(DOMAIN, VALUE, segmented=True, exactly=True)
        assert sent[0] == "21"


def test_what_is_not_taken_in_blocks_is_stored_in_segments() -> None:
    with long_domain("no-block-download") as bench:
        sdo = bench.dialogue()
        Room(sdo).store(DOMAIN, VALUE[::-1])
        assert bench.device.learned.stores_in_blocks is False
        assert sdo.upload(DOMAIN) == VALUE[::-1]


def test_a_refusal_of_the_length_says_nothing_of_blocks() -> None:
    with long_domain("strings-of-100-bytes") as bench:
        sent = first_sent(bench)
        with pytest.raises(NotTestable, match="300 bytes"):
            Room(bench.dialogue()).store(DOMAIN, VALUE[::-1])
        assert sent[0] == "c6"
        assert bench.device.learned.stores_in_blocks
