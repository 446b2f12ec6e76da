"""Requests to a server in the middle of a block download, up to the end request."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

SERVICE = "7.2.4.2.10"
INITIATE = "7.2.4.3.9"
SUB_BLOCK = "7.2.4.3.10"
END = "7.2.4.3.11"
CRC = "7.2.4.3.16"
ABORT = "7.2.4.3.17"

BLOCK_PROGRESS = Rule(
    "block.progress",
    SERVICE,
    MUST,
    "What is sent again is taken: a block transfer comes to an end.",
    reaction="the segments behind the acknowledged one, numbered from 1, are stored",
)

FULL_SUB_BLOCK = Rule(
    "block-download.full-sub-block",
    SUB_BLOCK,
    MUST,
    "Segments in order have no answer before the sub-block is full; then all are acknowledged.",
    reaction="silence; A2h with ackseq = blksize",
)
LAST_SEGMENT = Rule(
    "block-download.last-segment",
    SUB_BLOCK,
    MUST,
    "The last segment ends its sub-block early and is acknowledged with its number.",
    reaction="A2h",
)
WHOLE_SUB_BLOCK = Rule(
    "block-download.whole-sub-block",
    SUB_BLOCK,
    SHOULD,
    "A server takes as many segments without a pause as it has asked for.",
    reaction="A2h that acknowledges all that were sent",
    open="an acknowledgement may name fewer: what is behind that is sent again",
)
SEGMENTS_ONLY = Rule(
    "block-download.segments-only",
    SUB_BLOCK,
    MUST,
    "In a sub-block every frame but 80h is a segment, whatever else it looks like.",
    reaction="as a segment with the number in bits 6 to 0",
)
ABORT_IN_SUB_BLOCK = Rule(
    "block-download.abort-in-sub-block",
    ABORT,
    MUST,
    "80h in a sub-block ends the download; nothing is written.",
    reaction="silence, idle",
)
SEQUENCE_ZERO = Rule(
    "block-download.sequence-zero",
    SUB_BLOCK,
    MAY,
    "A segment with number 0 is never stored.",
    reaction="silence, or abort",
    codes=accepted.IMPOSSIBLE_NUMBER,
    open="abort, or the segment is dropped",
)
GAP = Rule(
    "block-download.gap",
    SUB_BLOCK,
    MUST,
    "Behind a gap nothing is taken; the acknowledgement names the last segment before it.",
    reaction="A2h with the last segment in sequence",
    open="when the acknowledgement comes",
)
REPEATED_SEGMENT = Rule(
    "block-download.repeated-segment",
    SUB_BLOCK,
    MAY,
    "A segment that comes twice is not stored twice.",
    reaction="silence, or A2h with the last segment in sequence",
    open="whether it is ignored or taken for a gap",
)
TOO_MANY = Rule(
    "block-download.too-many",
    END,
    MUST,
    "More bytes than announced are refused, at the end at the latest.",
    reaction="abort, the object keeps its value",
    codes=(*accepted.TOO_LONG, AbortCode.CRC_ERROR),
    tolerated=accepted.IMPRECISE,
    open="the moment: with the segment, or at the latest at the end",
)
SILENT_IN_SUB_BLOCK = Rule(
    "block-download.silent-in-sub-block",
    ABORT,
    MAY,
    "When a sub-block breaks off a server may acknowledge what came, give up, or wait.",
    reaction="silence, A2h, or abort",
    codes=accepted.TIMED_OUT,
    tolerated=(),
    open="whether there is a time-out, and what it leads to",
)
EMPTY = Rule(
    "block-download.empty",
    INITIATE,
    MAY,
    "A block download of no bytes stores an empty value or is refused.",
    reaction="served, or abort",
    codes=accepted.NOT_EMPTY,
    open="served or refused",
)
STORED = Rule(
    "block-download.stored",
    END,
    MUST,
    "The right end request is confirmed, and the data is stored.",
    reaction="A1h, idle",
)
WRONG_CRC = Rule(
    "block-download.crc",
    CRC,
    MUST,
    "A CRC that does not fit the data is refused as such.",
    reaction="abort, the object keeps its value",
    codes=(AbortCode.CRC_ERROR,),
    tolerated=accepted.IMPRECISE,
)
UNUSED_TOO_MANY = Rule(
    "block-download.unused-too-many",
    END,
    MUST,
    "An end request whose n does not fit the announced size is refused.",
    reaction="abort, the object keeps its value",
    codes=(*accepted.WRONG_LENGTH, AbortCode.CRC_ERROR),
    tolerated=accepted.IMPRECISE,
)
TOO_FEW = Rule(
    "block-download.too-few",
    END,
    MUST,
    "Fewer bytes than announced are refused at the end.",
    reaction="abort, the object keeps its value",
    codes=(*accepted.TOO_SHORT, AbortCode.CRC_ERROR),
    tolerated=accepted.IMPRECISE,
)
FOREIGN_AT_END = Rule(
    "block-download.foreign-at-end",
    END,
    MUST,
    "Any other request where the end is due ends the download.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
    open="a new initiate may be served",
)
LAST_AGAIN = Rule(
    "block-download.last-again",
    END,
    MAY,
    "The last segment once more does no harm, as after a lost acknowledgement.",
    reaction="A2h again, silence, or abort",
    codes=accepted.NOT_VALID,
    open="whether it is acknowledged again, ignored or refused",
)
ABORT_BEFORE_END = Rule(
    "block-download.abort-before-end",
    ABORT,
    MUST,
    "An abort of the client instead of the end request: nothing is written.",
    reaction="silence, idle",
)

TWO_ERRORS = Rule(
    "block-download.two-errors",
    END,
    MAY,
    "When both CRC and size are wrong the download is refused for one of them.",
    reaction="abort, the object keeps its value",
    codes=(*accepted.WRONG_LENGTH, AbortCode.CRC_ERROR),
    tolerated=accepted.IMPRECISE,
    open="which of the two is looked at first",
)
END_RESERVED_BIT = Rule(
    "block-download.end-reserved-bit",
    END,
    MAY,
    "The reserved bit of an end request may be ignored or refused.",
    reaction="A1h, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)

BLOCK_DOWNLOAD_RULES = (
    FULL_SUB_BLOCK,
    LAST_SEGMENT,
    WHOLE_SUB_BLOCK,
    SEGMENTS_ONLY,
    ABORT_IN_SUB_BLOCK,
    SEQUENCE_ZERO,
    GAP,
    Rule(
        "block-download.first-lost",
        SUB_BLOCK,
        MUST,
        "A sub-block without its first segment is acknowledged with ackseq 0.",
        reaction="A2h with ackseq 0",
        open="when the acknowledgement comes",
    ),
    BLOCK_PROGRESS,
    Rule(
        "block-download.old-numbering",
        SUB_BLOCK,
        MAY,
        "What is sent again under its old numbers is not taken for the right segments.",
        reaction="A2h with ackseq 0, abort, or silence",
        open="a minority reads the numbers as going on",
    ),
    REPEATED_SEGMENT,
    Rule(
        "block-download.beyond-block-size",
        SUB_BLOCK,
        MAY,
        "A segment with a number beyond the block size is not stored.",
        reaction="silence, A2h, or abort",
        codes=accepted.IMPOSSIBLE_NUMBER,
        open="abort, or the segment is dropped",
    ),
    TOO_MANY,
    SILENT_IN_SUB_BLOCK,
    Rule(
        "block-download.silent-before-sub-block",
        ABORT,
        MAY,
        "When no segment comes at all a server may give up, or wait.",
        reaction="silence, or abort",
        codes=accepted.TIMED_OUT,
        tolerated=(),
        open="whether there is a time-out, and its length",
    ),
    Rule(
        "block-download.not-now",
        ABORT,
        MUST,
        "An object that cannot be written at present refuses a block download.",
        reaction="abort, the object keeps its value",
        codes=(
            AbortCode.DEVICE_STATE,
            AbortCode.LOCAL_CONTROL,
            AbortCode.UNSUPPORTED_ACCESS,
            AbortCode.NOT_TRANSFERABLE,
        ),
        open="the moment: the initiate, or instead of an A2h or of the A1h",
        untestable="Which object cannot be written when, no description can say.",
    ),
    EMPTY,
    Rule(
        "block-download.size-not-indicated",
        INITIATE,
        MUST,
        "A block download that does not say its size (C4h) is served.",
        reaction="A0h or A4h",
    ),
    Rule(
        "block-download.without-crc",
        CRC,
        MUST,
        "For a client without a CRC none is checked.",
        reaction="A0h or A4h",
    ),
    STORED,
    WRONG_CRC,
    Rule(
        "block-download.crc-unused",
        CRC,
        MAY,
        "The CRC field has no meaning when one side computes none: nothing is refused for it.",
        reaction="A1h",
        open="the field has to be 0 then; whether a server looks at it",
    ),
    UNUSED_TOO_MANY,
    TOO_FEW,
    TWO_ERRORS,
    FOREIGN_AT_END,
    LAST_AGAIN,
    END_RESERVED_BIT,
    ABORT_BEFORE_END,
    Rule(
        "block-download.silent-before-end",
        ABORT,
        MAY,
        "When the end request does not come a server may give up, or wait.",
        reaction="silence, or abort",
        codes=accepted.TIMED_OUT,
        tolerated=(),
        open="whether there is a time-out, and its length",
    ),
)
