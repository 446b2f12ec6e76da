"""Very long values are read in blocks where these bring what segments begin with."""

import pytest
from support.run_bench import DOMAIN, NODE_ID, Recording, discovered

from conformance.device.effort import SEGMENTS_COMPARED
from conformance.device.known_objects import KnownObject
from conformance.dialogue.held_values import expect_read
from conformance.dialogue.value_access import ValueAccess
from conformance.faults.block_servers import KnowsBlockUploads
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_device import reference_entries
from conformance.run.leaving import leave
from conformance.sdo.kinds import OTHER_DATA
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry
from conformance.sdo.rules import Cause, Violation

LONG = bytes(n % 251 for n in range(30_000))
COMPARED_BYTES = 7 * SEGMENTS_COMPARED


class _InBlocks(Recording, KnowsBlockUploads):
    """Reads other data in blocks than in segments, where they are long."""

    def value_to_read(self, entry: Entry) -> bytes:
        value = super().value_to_read(entry)
        return self.in_blocks_read(value) if self.in_blocks and len(value) > 1000 else value

    def in_blocks_read(self, value: bytes) -> bytes:
        return value


class _Cut(_InBlocks):
    def in_blocks_read(self, value: bytes) -> bytes:
        return value[:-1]


class _Altered(_InBlocks):
    def in_blocks_read(self, value: bytes) -> bytes:
        return value[: COMPARED_BYTES - 1] + b"?" + value[COMPARED_BYTES:]


@pytest.mark.parametrize(
    ("kind", "value", "found"),
    [
        (Recording, LONG, LONG),
        (Recording, LONG[:1000], None),
        (Recording, b"1234", None),
        (Recording, b"", None),
        (_Cut, LONG, None),
        (_Altered, LONG, None),
    ],
)
def test_what_is_read_in_blocks(kind: type[Recording], value: bytes, found: bytes | None) -> None:
    entries = reference_entries(NODE_ID)
    server = kind(entries)
    with discovered(server) as bench:
        entries[DOMAIN.mux].value = value
        del bench.device.values[DOMAIN.mux]  # nothing was read of it before
        server.requests.clear()
        sdo = bench.dialogue()
        assert ValueAccess(sdo).announced_in_blocks(DOMAIN.mux) == found
        assert sdo.fence() == [], "the server is idle"
        assert len(server.requests) < 120, "it was not read in segments"


def test_a_device_without_block_uploads_is_not_asked_for_all_of_it() -> None:
    with discovered(build_node("no-block-transfer", NODE_ID)) as bench:
        known = KnownObject(Multiplexer(0x2011), DataType.DOMAIN)
        sdo = bench.dialogue()
        sdo.download(known, LONG[:2000], segmented=True)
        assert ValueAccess(sdo).announced_in_blocks(known.mux) is None
        assert sdo.upload(known) == LONG[:2000]


def held(value: bytes) -> Recording:
    entries = reference_entries(NODE_ID)
    entries[DOMAIN.mux].value = value
    return Recording(entries)


@pytest.mark.parametrize(
    ("value", "segments"),
    [
        (LONG, -(-len(LONG) // 7)),
        (LONG[:7000] + b"?" + LONG[7001:], 1001),
        (b"?" + LONG[1:], 1),
        (LONG + b"?", -(-len(LONG) // 7)),
        (LONG[:-1], -(-len(LONG) // 7)),
    ],
    ids=["right", "wrong-in-the-middle", "wrong-at-once", "longer", "shorter"],
)
def test_another_value_is_read_no_further_than_it_shows(value: bytes, segments: int) -> None:
    """A value that begins as it should is read to its end, and compared as others are."""
    server = held(value)
    with discovered(server) as bench:
        sdo = bench.dialogue()
        server.requests.clear()
        if value == LONG:
            expect_read(sdo, DOMAIN, LONG)
        else:
            with pytest.raises(Violation, match="reads") as differing:
                expect_read(sdo, DOMAIN, LONG)
            cause = sdo.record.cause_of(differing.value, sdo.wire.last_sent)
            assert cause == Cause(sdo.record.rule.id, *OTHER_DATA)
        assert sum(request[0] & 0xEF == 0x60 for request in server.requests) == segments
        assert leave(sdo, failed=value != LONG).violation is None
