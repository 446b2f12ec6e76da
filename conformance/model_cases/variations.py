"""What cases vary: requests and sizes of values, by the labels that stand in their ids."""

from conformance.sdo.frames import (
    BlockAck,
    BlockEnd,
    BlockEndResponse,
    BlockUploadStart,
    DownloadSegment,
    UploadSegment,
)
from conformance.sdo.layout import Message

# Command specifiers without a meaning, with the multiplexer of 1000h behind them.
UNKNOWN_SPECIFIERS = {
    f"{command:02X}h": bytes([command, 0x00, 0x10, 0x00, 0, 0, 0, 0])
    for command in (0xE0, 0xE1, 0xF0, 0xFF)
}

# What only has a meaning within a block transfer.
BLOCK_FRAMES: dict[str, Message] = {
    "block-end-response-A1h": BlockEndResponse(),
    "block-ack-A2h": BlockAck(1, 127),
    "block-start-A3h": BlockUploadStart(),
    "block-end-C1h": BlockEnd(0),
    "block-end-DDh": BlockEnd(7),
}

# Requests of other services in the middle of a segmented transfer.
FOREIGN_IN_UPLOAD: dict[str, bytes] = {
    "download-segment-00h": DownloadSegment.with_data(b"ABCDEFG", toggle=0).encode(),
    "download-segment-11h": DownloadSegment.with_data(b"ABCDEFG", toggle=1, last=True).encode(),
    "unknown-E0h": UNKNOWN_SPECIFIERS["E0h"],
    "unknown-FFh": UNKNOWN_SPECIFIERS["FFh"],
    **{label: message.encode() for label, message in BLOCK_FRAMES.items()},
}
FOREIGN_IN_DOWNLOAD: dict[str, bytes] = {
    "upload-segment-60h": UploadSegment(0).encode(),
    "upload-segment-70h": UploadSegment(1).encode(),
    "unknown-E0h": UNKNOWN_SPECIFIERS["E0h"],
    "unknown-FFh": UNKNOWN_SPECIFIERS["FFh"],
    **{label: message.encode() for label, message in BLOCK_FRAMES.items()},
}

# Lengths at which counters of servers wrap or segments fill up exactly, in bytes. Long ones are
# few: they are most of what a run costs.
SHORT_SIZES = tuple(range(1, 23))
LONG_SIZES = (257, 890, 4097)
# Sizes of block transfers: segment 64 of a sub-block begins with 40h, the last of 490 bytes with
# C6h, the last of 672 with E0h, which are other requests elsewhere; 127 segments hold 889 bytes.
BLOCK_SIZES = (*SHORT_SIZES, 448, 490, 672, 889, 1777)
# Of block uploads the client sends no segments: those are as good within 1777 bytes.
BLOCK_UPLOAD_SIZES = (*SHORT_SIZES, 889, 1777)
EDGE_SIZES = (1, 4, 5, 7, 8, 13, 14, 15, 20, 21, 22)
# Where a counter of 16 bits has wrapped, with two segments behind that; one size, because it takes
# long. Its last segment holds 3 bytes: a server that counts segments and not bytes would show.
BEYOND_16_BITS = 65_544
