"""Initiates of uploads of all three protocols: reserved fields, block size, protocol switch."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, Rule

PROTOCOL_SWITCH = "7.2.4.3.5"
THRESHOLD = "7.2.4.3.5 and 7.2.4.3.13"
UPLOAD = "7.2.4.3.6"
BLOCK_UPLOAD = "7.2.4.3.13"

INVALID_BLOCK_SIZE = Rule(
    "block-upload.invalid-block-size",
    BLOCK_UPLOAD,
    MUST,
    "A block upload in sub-blocks of no segment, or of more than 127, is refused.",
    reaction="abort",
    codes=(AbortCode.INVALID_BLOCK_SIZE,),
    tolerated=accepted.IMPRECISE,
)
SWITCH = Rule(
    "block-upload.switch",
    PROTOCOL_SWITCH,
    MAY,
    "A block upload of at most pst bytes may be answered as an ordinary upload.",
    reaction="a block upload, or an upload from its initiate response on",
    open="whether the server switches",
)
NO_SWITCH = Rule(
    "block-upload.no-switch",
    THRESHOLD,
    MUST,
    "pst = 0 forbids the switch to an ordinary upload.",
    reaction="a block upload",
)
ABOVE_THRESHOLD = Rule(
    "block-upload.above-threshold",
    PROTOCOL_SWITCH,
    MUST,
    "An object of more than pst bytes is uploaded in blocks, as asked.",
    reaction="a block upload",
)

UPLOAD_RESERVED_BITS = Rule(
    "upload.request-reserved-bits",
    UPLOAD,
    MAY,
    "Reserved bits of an upload initiate may be ignored or refused.",
    reaction="served, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)
BLOCK_UPLOAD_RESERVED_BITS = Rule(
    "block-upload.request-reserved-bits",
    BLOCK_UPLOAD,
    MAY,
    "Bits 4 and 3 of a block upload initiate may be ignored or refused.",
    reaction="served, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)
THRESHOLD_WITHOUT_BLOCK_SIZE = Rule(
    "block-upload.threshold-without-block-size",
    PROTOCOL_SWITCH,
    MAY,
    "With blksize 0 a server may still switch when pst lets it, or refuse.",
    reaction="an upload, or abort",
    codes=(AbortCode.INVALID_BLOCK_SIZE,),
    open="which of the two is looked at first",
)

UPLOAD_INITIATE_RULES = (
    UPLOAD_RESERVED_BITS,
    BLOCK_UPLOAD_RESERVED_BITS,
    Rule(
        "upload.request-reserved-bytes",
        UPLOAD,
        MAY,
        "Bytes 4 to 7 of an upload initiate say nothing and are ignored.",
        reaction="served",
    ),
    INVALID_BLOCK_SIZE,
    SWITCH,
    NO_SWITCH,
    ABOVE_THRESHOLD,
    THRESHOLD_WITHOUT_BLOCK_SIZE,
)
