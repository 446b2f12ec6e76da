"""What cases write does no harm where a server takes it for requests."""

import random

import pytest
from support.run_bench import HASTY, NODE_ID, TEXT, Scripted, discovered, recording, undiscovered

from conformance.device.not_testable import NotTestable
from conformance.device.safety import written_by
from conformance.dialogue.payload import MOST_PLAIN, PRINTABLE, PRINTABLE_OBJECTS, text
from conformance.reference.built_in_device import reference_entries
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import Abort, BlockSegment
from conformance.sdo.layout import Multiplexer

# The segments of the largest sub-block.
NUMBERS = range(1, 128)


@pytest.mark.parametrize("size", [1, MOST_PLAIN, MOST_PLAIN + 1, 490, 491, 492, 889, 4096, 9001])
def test_no_segment_begins_to_write_elsewhere(size: int) -> None:
    """Whatever number it has: sub-blocks may begin anywhere, and again anywhere."""
    with discovered(recording()) as bench:
        data, device = bench.dialogue().payload(size), bench.device
    assert len(data) == size
    assert set(data) <= set(PRINTABLE)
    for position in range(0, size, 7):
        for number in NUMBERS:
            if number > position // 7 + 1:
                break
            for last in {False, position + 7 >= size}:
                segment = BlockSegment.with_data(number, data[position : position + 7], last=last)
                target = written_by(decode_request(segment.encode()))
                assert target is None or device.lacks(target), segment.encode().hex()


def test_short_values_are_as_random_as_can_be() -> None:
    assert text(random.Random(1), 20, ()) == bytes(random.Random(1).choices(PRINTABLE, k=20))


def test_long_values_need_an_object_that_is_missing() -> None:
    with undiscovered(recording()) as bench:
        sdo = bench.dialogue()
        assert len(sdo.payload(MOST_PLAIN)) == MOST_PLAIN
        with pytest.raises(NotTestable, match="needs an object that the device lacks"):
            sdo.payload(MOST_PLAIN + 1)


def test_what_is_served_is_not_missing() -> None:
    there = PRINTABLE_OBJECTS[0]
    entries = reference_entries(NODE_ID)
    entries[there] = entries[TEXT.mux]
    with discovered(recording(entries=entries)) as bench:
        assert bench.device.learned.nowhere == PRINTABLE_OBJECTS[1:]
        assert not bench.device.lacks(there)
        assert bench.device.lacks(PRINTABLE_OBJECTS[1])
        assert bench.device.lacks(Multiplexer(PRINTABLE_OBJECTS[1].index))
        assert not bench.device.lacks(Multiplexer(PRINTABLE_OBJECTS[1].index, 1))


def test_what_cannot_be_read_now_is_not_missing() -> None:
    def answers(data: bytes) -> list[bytes]:
        mux = Multiplexer(int.from_bytes(data[1:3], "little"), data[3])
        return [] if data[0] == 0x80 else [Abort(mux, AbortCode.DEVICE_STATE).encode()]

    with discovered(Scripted(answers), timeout=HASTY) as bench:
        assert bench.device.learned.nowhere == ()
