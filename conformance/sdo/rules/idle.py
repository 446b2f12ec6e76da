"""Requests to a server that is idle: what exists, who may have it, and what has no place there."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

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
    reaction="the positive response; abort for what only the device knows of an object",
    codes=accepted.ABOUT_OBJECTS,
    open="expedited or segmented for an upload of 4 bytes or fewer",
)
MISSING_REFUSED = Rule(
    "object.missing-refused",
    ABORT,
    MUST,
    "What does not exist in the device is not served.",
    reaction="abort",
    codes=(AbortCode.OBJECT_MISSING,),
)

SUB_INDEX_MISSING = Rule(
    "object.sub-index-missing",
    ABORT,
    MUST,
    "A sub-index that an object does not have is refused as such.",
    reaction="abort",
    codes=(AbortCode.SUB_INDEX_MISSING,),
)
WRITE_ONLY = Rule(
    "object.write-only",
    ABORT,
    MUST,
    "A write-only object cannot be read.",
    reaction="abort",
    codes=(AbortCode.READ_OF_WRITE_ONLY, AbortCode.UNSUPPORTED_ACCESS),
)
READ_ONLY = Rule(
    "object.read-only",
    ABORT,
    MUST,
    "A read-only or constant object cannot be written, in whatever protocol.",
    reaction="abort",
    codes=accepted.READ_ONLY,
    open="the moment: the initiate, or later, up to the last request of the transfer",
)
UNKNOWN_SPECIFIER = Rule(
    "specifier.unknown",
    PROTOCOLS,
    MUST,
    "Client command specifier 7 has no meaning and is refused.",
    reaction="abort",
    codes=accepted.NOT_VALID,
)
DOWNLOAD_WITHOUT_INITIATE = Rule(
    "segmented-download.without-initiate",
    DOWNLOAD_SEGMENT,
    MAY,
    "A download segment without a transfer is never confirmed.",
    reaction="abort, or silence",
    codes=accepted.NOT_VALID,
    tolerated=accepted.ANY,
    open="abort or silence",
)
UPLOAD_WITHOUT_INITIATE = Rule(
    "segmented-upload.without-initiate",
    UPLOAD_SEGMENT,
    MAY,
    "A request for a segment without a transfer brings no data.",
    reaction="abort, or silence",
    codes=accepted.NOT_VALID,
    tolerated=accepted.ANY,
    open="abort or silence",
)
OUT_OF_BLOCK = Rule(
    "specifier.out-of-block",
    PROTOCOLS,
    MAY,
    "The inner frames of a block transfer that was never started have no positive answer.",
    reaction="abort, or silence",
    codes=accepted.NOT_VALID,
    tolerated=accepted.ANY,
    open="abort or silence",
)
ABORT_NOT_ANSWERED = Rule(
    "abort.not-answered",
    ABORT,
    MUST,
    "An abort is never answered, also when no transfer is running.",
    reaction="silence",
)
ABORT_RESERVED_BITS = Rule(
    "abort.reserved-bits",
    ABORT,
    MAY,
    "81h to 9Fh without a transfer has no positive answer.",
    reaction="silence, or abort",
    codes=accepted.NOT_VALID,
    open="whether it is an abort",
)
SUB_COMMAND = Rule(
    "specifier.sub-command",
    PROTOCOLS,
    MUST,
    "A block initiate whose sub-command bits name none is not served.",
    reaction="abort, or silence",
    codes=accepted.NOT_VALID,
    tolerated=accepted.ANY,
    open="silence: it may pass for an acknowledgement or an end out of place",
)
BLOCK_UNSUPPORTED = Rule(
    "block.unsupported",
    PROTOCOLS,
    MAY,
    "A server without block transfers refuses them; it never keeps silent.",
    reaction="served, or abort",
    codes=accepted.NOT_VALID,
    open="whether the server has block transfers",
)
NO_DATA = Rule(
    "object.no-data",
    ERROR_LIST,
    MUST,
    "An entry that holds nothing yet is not read as if it did.",
    reaction="abort",
    codes=(AbortCode.NO_DATA, AbortCode.GENERAL_ERROR),
    open="06090011h, or 0, is tolerated where a place of 1003h holds no error",
)
EMPTY_PLACE = Rule(
    "object.empty-place",
    ERROR_LIST,
    SHOULD,
    "A place of 1003h that holds no error is refused, and does not read as 0.",
)

BEHIND_ABORT = Rule(
    "abort.request-behind",
    ABORT,
    SHOULD,
    "A request that the client sends right behind its abort is answered.",
    open="a device with room for one frame may lose it: how soon behind an abort it takes the next",
)
BUSY = Rule(
    "object.busy",
    ABORT,
    MAY,
    "Two clients at one object are both served, or one is refused; no data is mixed up.",
    reaction="served, or abort",
    codes=(
        AbortCode.LOCAL_CONTROL,
        AbortCode.DEVICE_STATE,
        AbortCode.CONNECTION_NOT_AVAILABLE,
    ),
    open="served or refused",
)

IDLE_RULES = (
    NOT_REFUSED,
    MISSING_REFUSED,
    SUB_INDEX_MISSING,
    WRITE_ONLY,
    READ_ONLY,
    UNKNOWN_SPECIFIER,
    DOWNLOAD_WITHOUT_INITIATE,
    UPLOAD_WITHOUT_INITIATE,
    OUT_OF_BLOCK,
    ABORT_NOT_ANSWERED,
    BEHIND_ABORT,
    ABORT_RESERVED_BITS,
    SUB_COMMAND,
    BLOCK_UNSUPPORTED,
    NO_DATA,
    EMPTY_PLACE,
    BUSY,
)
