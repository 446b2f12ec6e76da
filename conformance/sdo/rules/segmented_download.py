"""Requests to a server in the middle of a segmented download."""

from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

DOWNLOAD = "7.2.4.3.2"
INITIATE = "7.2.4.3.3"
SEGMENT = "7.2.4.3.4"
ABORT = "7.2.4.3.17"

CONFIRMED = Rule(
    "segmented-download.confirmed",
    SEGMENT,
    MUST,
    "A segment with the toggle bit that is due is confirmed with the same toggle bit.",
    reaction="20h, 30h",
)
STORED = Rule(
    "segmented-download.stored",
    SEGMENT,
    MUST,
    "The last segment ends a download of the announced size, and all of it is stored.",
    reaction="20h or 30h, idle",
)
TOGGLE = Rule(
    "segmented-download.toggle",
    SEGMENT,
    MUST,
    "The data of a segment whose toggle bit did not alternate is not stored.",
    reaction="abort, or silence",
    codes=accepted.TOGGLE_ERROR,
    tolerated=(),
    open="whether the transfer is aborted or the segment ignored",
)
TOO_MANY = Rule(
    "segmented-download.too-many",
    ABORT,
    MUST,
    "More bytes than announced are refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_LONG,
)
TOO_FEW = Rule(
    "segmented-download.too-few",
    ABORT,
    MUST,
    "A last segment that leaves bytes of the announced size missing is refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_SHORT,
)
UPLOAD_SEGMENT = Rule(
    "segmented-download.upload-segment",
    SEGMENT,
    MUST,
    "A request for a segment in the middle of a download ends it.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
UNKNOWN_SPECIFIER = Rule(
    "segmented-download.unknown-specifier",
    SEGMENT,
    MUST,
    "Client command specifier 7 in the middle of a download ends it.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
BLOCK_FRAMES = Rule(
    "segmented-download.block-frames",
    SEGMENT,
    MUST,
    "The inner frames of a block transfer in the middle of a segmented download end it.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
CLIENT_ABORT = Rule(
    "segmented-download.client-abort",
    ABORT,
    MUST,
    "An abort of the client ends the download; the object keeps its value.",
    reaction="silence, idle",
)
EMPTY = Rule(
    "segmented-download.empty",
    INITIATE,
    MAY,
    "A download of no bytes stores an empty value or is refused.",
    reaction="served, or abort",
    codes=accepted.NOT_EMPTY,
    open="served or refused",
)

SHORT_SEGMENTS = Rule(
    "segmented-download.short-segments",
    SEGMENT,
    SHOULD,
    "Of a segment before the last that holds fewer than 7 bytes only these are stored.",
    reaction="20h, 30h",
    tolerated=accepted.ANY_LENGTH_ERROR,
    open="whether a server looks at n in any segment but the last",
)
EMPTY_LAST = Rule(
    "segmented-download.empty-last",
    SEGMENT,
    SHOULD,
    "A last segment without data (n = 7) is taken when all bytes have come.",
    reaction="20h or 30h, idle",
    tolerated=accepted.ANY_LENGTH_ERROR,
    open="whether a server takes n = 7",
)

ABORT_RESERVED_BITS = Rule(
    "segmented-download.abort-reserved-bits",
    ABORT,
    MAY,
    "81h to 9Fh in the middle of a download is an abort, no valid request, or nothing.",
    reaction="silence, or abort",
    codes=accepted.NOT_VALID,
    open="whether it is an abort",
)

SEGMENTED_DOWNLOAD_RULES = (
    CONFIRMED,
    STORED,
    TOGGLE,
    TOO_MANY,
    TOO_FEW,
    SHORT_SEGMENTS,
    EMPTY_LAST,
    Rule(
        "segmented-download.unused-not-stated",
        SEGMENT,
        MAY,
        "n = 0 in a last segment that is not full: the bytes due are taken, or it is refused.",
        reaction="20h or 30h, or abort",
        codes=accepted.TOO_LONG,
        open="n = 0 may say that the size of the segment is not stated",
    ),
    Rule(
        "segmented-download.filler-ignored",
        SEGMENT,
        MUST,
        "The bytes of a segment that hold no data are not stored.",
        reaction="20h, 30h",
    ),
    UPLOAD_SEGMENT,
    UNKNOWN_SPECIFIER,
    BLOCK_FRAMES,
    Rule(
        "segmented-download.new-initiate",
        DOWNLOAD,
        MUST,
        "An initiate of any kind ends the download that is running; nothing of it is stored.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="whether the new transfer is served or refused, and the code",
    ),
    CLIENT_ABORT,
    ABORT_RESERVED_BITS,
    Rule(
        "segmented-download.client-silent",
        ABORT,
        MAY,
        "A server may give up a download that does not go on, or wait for ever.",
        reaction="silence, or abort",
        codes=accepted.TIMED_OUT,
        tolerated=(),
        open="whether there is a time-out, and its length",
    ),
    Rule(
        "segmented-download.after-the-last",
        SEGMENT,
        MAY,
        "A segment behind the last one is never confirmed, and changes nothing.",
        reaction="abort, or silence",
        codes=accepted.NOT_VALID,
        tolerated=accepted.ANY,
        open="abort or silence",
    ),
    EMPTY,
)
