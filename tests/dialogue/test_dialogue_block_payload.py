"""What a server writes that ends a block download, and takes what is on its way for requests."""

import pytest
from support.run_bench import DOMAIN, NODE_ID, TEXT, Recording, begin, discovered

from conformance.device.not_testable import NotTestable
from conformance.device.safety import written_by
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.payload import MOST_PLAIN, PRINTABLE_OBJECTS, check_for_blocks
from conformance.dialogue.value_access import ValueAccess
from conformance.reference.built_in_device import reference_entries
from conformance.reference.server import BlockDownload
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import BlockDownloadInitiate, BlockSegment, DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, Refusal

SERIAL = bytes.fromhex("181004")
TEXT_ITSELF = bytes.fromhex("102000")


class EndsInside(Recording):
    """Ends each block download inside its sub-block, and says so late: it is idle from then on.

    It has the objects that segments name, though it refuses to read them.
    """

    held_back: list[bytes]
    still = 0

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        if request.sequence == 30:
            self.still = 40
            raise Refusal(AbortCode.LOCAL_CONTROL)
        super().take_block_segment(transfer, request)

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        if request.mux in PRINTABLE_OBJECTS:
            return Entry(bytes(4), DataType.UNSIGNED32)
        return super().entry_to_write(request)

    def receive(self, frame: bytes) -> list[bytes]:
        answers = [*getattr(self, "held_back", []), *super().receive(frame)]
        self.still -= 1
        self.held_back = answers if self.still > 0 else []
        return [] if self.still > 0 else answers


def test_what_it_takes_for_a_write_is_told() -> None:
    """It is right to write; nobody knows what was there."""
    server = EndsInside(reference_entries(NODE_ID))
    with discovered(server) as bench:
        session = bench.session()
        run = begin(session)
        abort = run.sdo.abort_of(run.sdo.client.block_download(DOMAIN.mux, run.sdo.payload(500)))
        assert abort is not None
        result = run.conclude(None)
        taken = bench.device.contents.taken
    written = {
        target
        for frame in server.requests
        if (target := written_by(decode_request(frame))) in PRINTABLE_OBJECTS
    }
    assert taken
    assert taken <= written
    assert any(f"for a write to {mux}" in note for mux in taken for note in result.notes)
    assert not result.cause, "it may end a transfer, and serve what comes then"


def value(named: bytes) -> bytes:
    """Return a value of which the 40th segment names an object."""
    return b"-" * (39 * 7) + named + b"-" * 40


@pytest.mark.parametrize("named", [SERIAL, b"\x00\x10\x00"], ids=["1018h:04", "1000h"])
def test_a_value_that_names_another_object_goes_in_segments(named: bytes) -> None:
    server = Recording(reference_entries(NODE_ID))
    with discovered(server) as bench:
        sdo = bench.dialogue()
        bench.device.learned.stores_in_blocks = True
        assert not ValueAccess(sdo).write_in_blocks(DOMAIN.mux, value(named))
        with pytest.raises(NotTestable, match="if the server ended"):
            check_for_blocks(bench.device, value(named))
        with pytest.raises(NotTestable, match="a segment would be a write to 10"):
            Blocks(sdo).download(DOMAIN, value(named))
    assert not any(frame[1:4] == named and 0x20 <= frame[0] < 0x40 for frame in server.requests)


def test_other_values_go_in_blocks() -> None:
    """One that names what may be written, and one that names it where no initiate can be."""
    server = Recording(reference_entries(NODE_ID))
    with discovered(server) as bench:
        sdo = bench.dialogue()
        bench.device.learned.stores_in_blocks = True
        assert ValueAccess(sdo).write_in_blocks(DOMAIN.mux, value(TEXT_ITSELF))
        assert ValueAccess(sdo).write_in_blocks(DOMAIN.mux, SERIAL.ljust(7, b"-") * 31)
        assert ValueAccess(sdo).write_in_blocks(DOMAIN.mux, b"-" * MOST_PLAIN + b"\x06\x30\x05")
        sdo.fence()
    begun = [decode_request(frame) for frame in server.requests if frame[0] & 0xE1 == 0xC0]
    assert sum(isinstance(one, BlockDownloadInitiate) for one in begun) == 3
    assert Multiplexer(0x1018, 4) in server.entries
    assert TEXT.mux in bench.device.known
