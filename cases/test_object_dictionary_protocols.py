"""Every object that is listed of the device, read and written in segments and in blocks.

These cases run behind those of ``test_object_dictionary``: of very many objects a run may leave
them out.
"""

from conformance.device.device import Device
from conformance.device.effort import LONG_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.object_expectations import (
    differing_reads,
    expect_kept,
    expect_written_back,
    may_be_probed,
    may_be_written,
    value_of,
    value_to_write_back,
)
from conformance.dialogue.payload import check_for_blocks
from conformance.run import object_choices as choose
from conformance.run.case import must
from conformance.sdo.describe import shown
from conformance.sdo.frames import BlockUploadInitiate
from conformance.sdo.rules.idle import READ_ONLY, WRITE_ONLY
from conformance.sdo.seen import Data

BLOCK_UPLOAD = "7.2.4.3.13"


@must(
    "od.block-read",
    "block-upload.first-sub-block",
    "block-upload.end",
    "block-upload.switch",
    "block-upload.no-switch",
    clause=BLOCK_UPLOAD,
    entry=choose.readable,
)
def test_block_read(sdo: Dialogue, blocks: Blocks, device: Device, entry: KnownObject) -> None:
    """A block upload delivers what an ordinary upload does.

    So it does without a CRC where the client allows a switch of the protocol (pst), and with one
    where it allows that for shorter values only.
    """
    blocks.require_upload()
    size = len(value_of(device, entry))
    for crc, threshold in ((True, max(0, min(size - 1, 254))), (False, 255)):
        differing = differing_reads(sdo, blocks, entry, crc=crc, threshold=threshold)
        if differing is not None:
            by_segments, by_blocks = differing
            raise sdo.breach(
                f"{shown(by_segments)} with crc={crc:d}, pst={threshold}, as by an ordinary upload",
                Data(by_blocks),
            )


@must("od.block-of-write-only", "object.write-only", entry=choose.write_only)
def test_block_of_write_only(sdo: Dialogue, blocks: Blocks, entry: KnownObject) -> None:
    """A block upload of a write-only entry is aborted as such."""
    blocks.require_upload()
    sdo.send(BlockUploadInitiate(entry.mux, 127))
    sdo.expect_abort(*WRITE_ONLY.codes, of=entry)


@must(
    "od.write-back-in-segments",
    "dictionary.access",
    "data.short-in-segments",
    entry=choose.writable,
)
def test_write_back_in_segments(
    sdo: Dialogue, blocks: Blocks, device: Device, entry: KnownObject
) -> None:
    """A writable entry takes the value that it has in segments, however short it is."""
    may_be_written(device, entry)
    value = value_to_write_back(sdo, entry)
    if len(value) > LONG_VALUE:
        raise NotTestable(f"{len(value)} bytes go in segments in any case: see od.write-back")
    expect_written_back(sdo, entry, sdo.try_download(entry, value, segmented=True), value)


@must(
    "od.write-back-in-blocks", "dictionary.access", "block-download.stored", entry=choose.writable
)
def test_write_back_in_blocks(
    sdo: Dialogue, blocks: Blocks, device: Device, entry: KnownObject
) -> None:
    """A writable entry takes the value that it has in blocks."""
    may_be_written(device, entry)
    blocks.require_download()
    value = value_to_write_back(sdo, entry)
    check_for_blocks(device, value)
    transfer = sdo.client.block_download(entry.mux, value)
    expect_written_back(sdo, entry, sdo.abort_of(transfer), value)


@must("od.read-only-in-segments", "object.read-only", entry=choose.protected)
def test_read_only_in_segments(sdo: Dialogue, device: Device, entry: KnownObject) -> None:
    """A read-only entry refuses the value that it has in segments, at the last at the latest."""
    may_be_probed(device, entry)
    value = sdo.upload(entry)
    sdo.expect_download_refused(entry, value or b"\0", *READ_ONLY.codes, size=len(value) or 1)
    expect_kept(sdo, entry, value)


@must("od.read-only-in-blocks", "object.read-only", entry=choose.protected)
def test_read_only_in_blocks(
    sdo: Dialogue, blocks: Blocks, device: Device, entry: KnownObject
) -> None:
    """A read-only entry refuses the value that it has in blocks, at the end at the latest."""
    may_be_probed(device, entry)
    value = sdo.upload(entry)
    blocks.expect_download_refused(entry, value or b"\0", *READ_ONLY.codes, size=len(value) or 1)
    expect_kept(sdo, entry, value)
