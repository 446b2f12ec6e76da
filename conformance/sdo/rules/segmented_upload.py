"""Requests to a server in the middle of a segmented upload."""

from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, Rule

UPLOAD = "7.2.4.3.5"
SEGMENT = "7.2.4.3.7"
ABORT = "7.2.4.3.17"

SEGMENTS = Rule(
    "segmented-upload.segments",
    SEGMENT,
    MUST,
    "A request with the toggle bit that is due brings the next segment, up to the last.",
    reaction="00h to 1Fh, with the toggle bit of the request",
)
TOGGLE = Rule(
    "segmented-upload.toggle",
    SEGMENT,
    MUST,
    "A toggle bit that did not alternate ends the upload and brings no data.",
    reaction="abort, idle",
    codes=accepted.TOGGLE_ERROR,
    tolerated=(),
)
DOWNLOAD_SEGMENT = Rule(
    "segmented-upload.download-segment",
    SEGMENT,
    MUST,
    "A download segment in the middle of an upload ends it.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
UNKNOWN_SPECIFIER = Rule(
    "segmented-upload.unknown-specifier",
    SEGMENT,
    MUST,
    "Client command specifier 7 in the middle of an upload ends it.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
CLIENT_ABORT = Rule(
    "segmented-upload.client-abort",
    ABORT,
    MUST,
    "An abort of the client ends the upload.",
    reaction="silence, idle",
)
BLOCK_FRAMES = Rule(
    "segmented-upload.block-frames",
    SEGMENT,
    MUST,
    "The inner frames of a block transfer in the middle of a segmented upload end it.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)

SEGMENTED_UPLOAD_RULES = (
    SEGMENTS,
    TOGGLE,
    DOWNLOAD_SEGMENT,
    UNKNOWN_SPECIFIER,
    Rule(
        "segmented-upload.new-initiate",
        UPLOAD,
        MUST,
        "An initiate of any kind ends the upload that is running.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="whether the new transfer is served or refused, and the code",
    ),
    Rule(
        "segmented-upload.restart",
        UPLOAD,
        MUST,
        "The same upload initiate again begins with the first byte and t = 0, or is refused.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="whether it is served or refused, and the code",
    ),
    CLIENT_ABORT,
    Rule(
        "segmented-upload.request-reserved-bits",
        SEGMENT,
        MAY,
        "Reserved bits of a request for a segment may be ignored or refused.",
        reaction="served, or abort",
        codes=accepted.NOT_VALID,
        open="served or refused",
    ),
    Rule(
        "segmented-upload.request-reserved-bytes",
        SEGMENT,
        MAY,
        "Bytes 1 to 7 of a request for a segment say nothing and are ignored.",
        reaction="served",
    ),
    BLOCK_FRAMES,
    Rule(
        "segmented-upload.after-the-last",
        SEGMENT,
        MAY,
        "A request behind the last segment brings no data.",
        reaction="abort, or silence",
        codes=accepted.NOT_VALID,
        tolerated=accepted.ANY,
        open="abort or silence",
    ),
    Rule(
        "segmented-upload.client-silent",
        ABORT,
        MAY,
        "A server may give up an upload that does not go on, or wait for ever.",
        reaction="silence, or abort",
        codes=accepted.TIMED_OUT,
        tolerated=(),
        open="whether there is a time-out, and its length",
    ),
    Rule(
        "segmented-upload.object-changes",
        SEGMENT,
        MAY,
        "What is uploaded when the object changes in the meantime is nowhere fixed.",
        open="the data, or a refusal",
        untestable="Nothing is required, and the bus does not show when an object changes.",
    ),
)
