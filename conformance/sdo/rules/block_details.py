"""The CRC of block transfers, and how their segments are counted, lost and sent again."""

from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

PROTOCOL_SWITCH = "7.2.4.3.5"
SUB_BLOCK_DOWNLOAD = "7.2.4.3.10"
SUB_BLOCK_UPLOAD = "7.2.4.3.14"
CRC = "7.2.4.3.16"

CRC_RULES = (
    Rule(
        "crc.algorithm",
        CRC,
        MUST,
        "The CRC is that of polynomial 1021h, begun with 0, bits in their order, not inverted.",
    ),
    Rule(
        "crc.covers",
        CRC,
        MUST,
        "The CRC counts each data byte once: no numbers, no filler, nothing that was sent again.",
    ),
    Rule(
        "crc.placement",
        CRC,
        MUST,
        "The CRC stands in bytes 1 and 2 of the end request, the low byte first.",
    ),
    Rule(
        "crc.not-asked",
        CRC,
        MUST,
        "A client without a CRC gets 0 in its place at the end of an upload.",
    ),
    Rule(
        "crc.not-offered",
        CRC,
        MUST,
        "A server that computes no CRC sends 0 in its place at the end of an upload.",
    ),
    Rule(
        "crc.offered-unasked",
        CRC,
        MAY,
        "A server may say that it computes a CRC, or not, to a client that does not.",
        reaction="A0h or A4h; C0h, C2h, C4h or C6h",
        open="the bit sc when cc is 0",
    ),
    Rule(
        "crc.empty",
        CRC,
        MUST,
        "The CRC of no data is 0.",
        open="whether there are transfers of no data",
    ),
)

BLOCK_ACK = Rule(
    "block.acknowledgement",
    SUB_BLOCK_DOWNLOAD,
    MUST,
    "An acknowledgement names the last segment in sequence.",
    reaction="0 when not even the first segment has come",
)

NUMBERED_ANEW = Rule(
    "block-upload.retransmission-numbering",
    SUB_BLOCK_UPLOAD,
    SHOULD,
    "What is sent again is numbered from 1, as in any sub-block.",
    reaction="segments from 1 on",
    open="a minority counts on behind the acknowledged number",
)

BLOCK_DETAIL_RULES = (
    BLOCK_ACK,
    Rule(
        "block.full-last-segment",
        SUB_BLOCK_UPLOAD,
        MUST,
        "Data of a multiple of 7 bytes ends with a full segment, and n is 0.",
    ),
    Rule(
        "block.ends-with-sub-block",
        SUB_BLOCK_UPLOAD,
        MUST,
        "Data that ends where a sub-block does is marked there; no empty sub-block follows.",
    ),
    Rule(
        "block-upload.unknown-size-no-switch",
        PROTOCOL_SWITCH,
        MUST,
        "A server that does not know the size of an object does not switch to another protocol.",
        untestable="The bus does not show whether a server knew the size before the upload.",
    ),
    NUMBERED_ANEW,
    Rule(
        "block-download.break-moment",
        SUB_BLOCK_DOWNLOAD,
        MAY,
        "A gap is acknowledged at once, at the end of the sub-block, or by a time-out.",
        reaction="A2h with the last segment in sequence",
        open="the moment",
    ),
)
