"""Requests to a server that is idle: what exists, who may have it, and what has no place there."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules.accepted import NOT_VALID, NOT_VALID_OR_GENERAL, READ_ONLY
from conformance.sdo.rules.model import MAY, MUST, Rule

PROTOCOLS = "7.2.4.3"
DOWNLOAD_SEGMENT = "7.2.4.3.4"
UPLOAD_SEGMENT = "7.2.4.3.7"
ABORT = "7.2.4.3.17"
ERROR_LIST = "7.5.2.4"

NOT_REFUSED = Rule(
    "response.not-refused",
    PROTOCOLS,
    MUST,
    "A request that the protocol and the object allow is served.",
    rows=("I1",),
    reaction="the positive response to the initiate",
    open="expedited or segmented for an upload of 4 bytes or fewer",
)
MISSING_REFUSED = Rule(
    "object.missing-refused",
    ABORT,
    MUST,
    "What does not exist in the device is not served.",
    rows=("I2",),
    reaction="abort",
    codes=(AbortCode.OBJECT_MISSING, AbortCode.GENERAL_ERROR),
)

IDLE_RULES = (
    NOT_REFUSED,
    MISSING_REFUSED,
    Rule(
        "object.sub-index-missing",
        ABORT,
        MUST,
        "A sub-index that an object does not have is refused as such.",
        rows=("I3",),
        reaction="abort",
        codes=(AbortCode.SUB_INDEX_MISSING, AbortCode.GENERAL_ERROR),
    ),
    Rule(
        "object.write-only",
        ABORT,
        MUST,
        "A write-only object cannot be read.",
        rows=("I4",),
        reaction="abort",
        codes=(
            AbortCode.READ_OF_WRITE_ONLY,
            AbortCode.UNSUPPORTED_ACCESS,
            AbortCode.GENERAL_ERROR,
        ),
    ),
    Rule(
        "object.read-only",
        ABORT,
        MUST,
        "A read-only or constant object cannot be written, in whatever protocol.",
        rows=("I5",),
        reaction="abort",
        codes=READ_ONLY,
        open="the moment: the initiate, or later, up to the last request of the transfer",
    ),
    Rule(
        "specifier.unknown",
        PROTOCOLS,
        MUST,
        "Client command specifier 7 has no meaning and is refused.",
        rows=("I6",),
        reaction="abort",
        codes=NOT_VALID_OR_GENERAL,
    ),
    Rule(
        "segmented-download.without-initiate",
        DOWNLOAD_SEGMENT,
        MAY,
        "A download segment without a transfer is never confirmed.",
        rows=("I7",),
        reaction="abort, or silence",
        codes=NOT_VALID,
        open="abort or silence",
    ),
    Rule(
        "segmented-upload.without-initiate",
        UPLOAD_SEGMENT,
        MAY,
        "A request for a segment without a transfer brings no data.",
        rows=("I8",),
        reaction="abort, or silence",
        codes=NOT_VALID,
        open="abort or silence",
    ),
    Rule(
        "specifier.out-of-block",
        PROTOCOLS,
        MAY,
        "The inner frames of a block transfer that was never started have no positive answer.",
        rows=("I9",),
        reaction="abort, or silence",
        codes=NOT_VALID,
        open="abort or silence",
    ),
    Rule(
        "abort.not-answered",
        ABORT,
        MUST,
        "An abort is never answered, also when no transfer is running.",
        rows=("I10",),
        reaction="silence",
    ),
    Rule(
        "abort.reserved-bits",
        ABORT,
        MAY,
        "81h to 9Fh without a transfer has no positive answer.",
        rows=("I11",),
        reaction="silence, or abort",
        open="whether it is an abort",
    ),
    Rule(
        "specifier.sub-command",
        PROTOCOLS,
        MUST,
        "A block initiate whose sub-command bits name none is not served.",
        rows=("I34",),
        reaction="abort, or silence",
        codes=NOT_VALID,
        open="silence: it may pass for an acknowledgement or an end out of place",
    ),
    Rule(
        "block.unsupported",
        PROTOCOLS,
        MAY,
        "A server without block transfers refuses them; it never keeps silent.",
        rows=("I36", "8-capability"),
        reaction="served, or abort",
        codes=NOT_VALID,
        open="whether the server has block transfers",
    ),
    Rule(
        "object.no-data",
        ERROR_LIST,
        MUST,
        "An entry that holds nothing yet is not read as if it did.",
        rows=("I37",),
        reaction="abort",
        codes=(AbortCode.NO_DATA, AbortCode.GENERAL_ERROR),
        open="06090011h is tolerated where a place of 1003h holds no error",
    ),
    Rule(
        "object.busy",
        ABORT,
        MAY,
        "Two clients at one object are both served, or one is refused; no data is mixed up.",
        rows=("I38", "O31"),
        reaction="served, or abort",
        codes=(
            AbortCode.LOCAL_CONTROL,
            AbortCode.DEVICE_STATE,
            AbortCode.CONNECTION_NOT_AVAILABLE,
        ),
        open="served or refused",
    ),
)
