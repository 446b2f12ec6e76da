"""Requests to a server in the middle of a block upload, up to the confirmation of its end."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, Rule

INITIATE = "7.2.4.3.13"
SUB_BLOCK = "7.2.4.3.14"
END = "7.2.4.3.15"
CRC = "7.2.4.3.16"
ABORT = "7.2.4.3.17"

FIRST_SUB_BLOCK = Rule(
    "block-upload.first-sub-block",
    SUB_BLOCK,
    MUST,
    "The start brings the first sub-block: as many segments as asked for, or all there are.",
    reaction="segments from 1 on, the very last one of the data marked",
)
NOT_STARTED = Rule(
    "block-upload.not-started",
    INITIATE,
    MUST,
    "An acknowledgement or an end confirmation where the start is due ends the upload.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
FOREIGN_BEFORE_START = Rule(
    "block-upload.foreign-before-start",
    INITIATE,
    MUST,
    "A segment, or command specifier 7, where the start is due ends the upload.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
NEXT_SUB_BLOCK = Rule(
    "block-upload.next-sub-block",
    SUB_BLOCK,
    MUST,
    "When all is acknowledged the next sub-block follows, with the block size just given.",
    reaction="segments from 1 on",
)
ENDS = Rule(
    "block-upload.end",
    END,
    MUST,
    "When the last segment is acknowledged the end follows, with n and the CRC.",
    reaction="C1h to DDh",
)
ACKNOWLEDGED = Rule(
    "block-upload.acknowledged",
    SUB_BLOCK,
    MUST,
    "What was not acknowledged is sent again, in a new sub-block of the block size just given.",
    reaction="segments from 1 on, beginning behind the acknowledged one",
)
ACKNOWLEDGES_TOO_MANY = Rule(
    "block-upload.acknowledges-too-many",
    SUB_BLOCK,
    MUST,
    "An acknowledgement of more segments than were sent ends the upload.",
    reaction="abort, idle",
    codes=(AbortCode.INVALID_SEQUENCE_NUMBER, AbortCode.COMMAND_NOT_VALID),
    open="the code",
)
ACKNOWLEDGES_BLOCK_SIZE = Rule(
    "block-upload.acknowledges-block-size",
    SUB_BLOCK,
    MUST,
    "An acknowledgement with a block size of 0, or beyond 127, ends the upload.",
    reaction="abort, idle",
    codes=(AbortCode.INVALID_BLOCK_SIZE,),
    tolerated=accepted.IMPRECISE,
)
FOREIGN = Rule(
    "block-upload.foreign",
    SUB_BLOCK,
    MUST,
    "Anything but an acknowledgement where it is due ends the upload.",
    reaction="abort, idle",
    codes=accepted.NOT_VALID,
)
CLIENT_ABORT = Rule(
    "block-upload.client-abort",
    ABORT,
    MUST,
    "An abort of the client ends the upload wherever it is, and no segment follows.",
    reaction="silence, idle",
)
EMPTY = Rule(
    "block-upload.empty",
    INITIATE,
    MAY,
    "An object without data is uploaded as nothing, or refused.",
    reaction="served with size 0, or abort",
    codes=(AbortCode.NO_DATA,),
    open="served or refused",
)
OVER = Rule(
    "block-upload.over",
    END,
    MUST,
    "The confirmation of the end is not answered, and the server is idle.",
    reaction="silence, idle; abort of a request that belongs elsewhere",
    codes=accepted.NOT_VALID,
)
ACKNOWLEDGED_AGAIN = Rule(
    "block-upload.acknowledged-again",
    END,
    MAY,
    "An acknowledgement or a start, where the end is to be confirmed, does no harm.",
    reaction="silence, or abort; for an acknowledgement the end again, too",
    codes=accepted.OUT_OF_PLACE,
    open="whether the end is repeated or the upload aborted, and the code",
)
CLIENT_ABORT_AT_END = Rule(
    "block-upload.client-abort-at-end",
    ABORT,
    MUST,
    "An abort instead of the confirmation of the end, as for a wrong CRC, ends the upload.",
    reaction="silence, idle",
)

ACKNOWLEDGEMENT_RESERVED_BITS = Rule(
    "block-upload.acknowledgement-reserved-bits",
    SUB_BLOCK,
    MAY,
    "Reserved bits of an acknowledgement may be ignored or refused.",
    reaction="segments or the end, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)

EARLY_ACKNOWLEDGEMENT = Rule(
    "block-upload.early-acknowledgement",
    SUB_BLOCK,
    MAY,
    "An acknowledgement that comes while segments are being sent may have any effect.",
    reaction="any, and the server serves the next transfer",
    open="the effect: no client that keeps the rules does it",
)

BLOCK_UPLOAD_RULES = (
    FIRST_SUB_BLOCK,
    NOT_STARTED,
    Rule(
        "block-upload.new-initiate-before-start",
        INITIATE,
        MAY,
        "An initiate where the start is due ends the upload; it is served or refused.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="whether the new transfer is served or refused, and the code",
    ),
    FOREIGN_BEFORE_START,
    NEXT_SUB_BLOCK,
    ENDS,
    ACKNOWLEDGED,
    Rule(
        "block-upload.nothing-acknowledged",
        SUB_BLOCK,
        MUST,
        "ackseq 0 has the whole sub-block sent again.",
        reaction="segments from 1 on, with the data of the sub-block before",
    ),
    ACKNOWLEDGES_TOO_MANY,
    ACKNOWLEDGES_BLOCK_SIZE,
    FOREIGN,
    ACKNOWLEDGEMENT_RESERVED_BITS,
    Rule(
        "block-upload.new-initiate",
        SUB_BLOCK,
        MAY,
        "An initiate where an acknowledgement is due ends the upload; it is served or refused.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="whether the new transfer is served or refused, and the code",
    ),
    CLIENT_ABORT,
    Rule(
        "block-upload.client-silent",
        ABORT,
        MAY,
        "A server may give up a block upload that does not go on, or wait.",
        reaction="silence, or abort",
        codes=accepted.TIMED_OUT,
        tolerated=(),
        open="whether there is a time-out, and its length",
    ),
    EARLY_ACKNOWLEDGEMENT,
    EMPTY,
    OVER,
    ACKNOWLEDGED_AGAIN,
    Rule(
        "block-upload.new-initiate-at-end",
        END,
        MAY,
        "An initiate where the end is to be confirmed is served or refused.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="whether the new transfer is served or refused, and the code",
    ),
    CLIENT_ABORT_AT_END,
    Rule(
        "block-upload.silent-at-end",
        ABORT,
        MAY,
        "When the confirmation of the end does not come a server may give up, or wait.",
        reaction="silence, or abort",
        codes=accepted.TIMED_OUT,
        tolerated=(),
        open="whether there is a time-out, and its length",
    ),
)
