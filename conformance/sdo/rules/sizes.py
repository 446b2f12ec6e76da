"""How many bytes a value has, and how its size is said."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

DOWNLOAD = "7.2.4.3.3"
UPLOAD = "7.2.4.3.6"
ABORT = "7.2.4.3.17"
BOOLEAN = "7.1.4.3"
STRINGS = "7.1.6"
TYPES = "7.1.4"

VARIABLE_LENGTH = Rule(
    "data.variable-length",
    STRINGS,
    MUST,
    "A string or domain takes data that is shorter than its room.",
    reaction="served; abort for what the room does not take",
    codes=(*accepted.NO_ROOM, AbortCode.LENGTH_TOO_LOW),
    open="whether a string ends with 00h; whether an OCTET_STRING has a length of its own",
)
AS_WRITTEN = Rule(
    "data.as-written",
    STRINGS,
    SHOULD,
    "A string or domain keeps the bytes that were written, or refuses them.",
    reaction="served; abort for what the room does not take",
    codes=accepted.NO_ROOM,
    open="whether a string ends with 00h",
)
TYPE_LENGTH = Rule(
    "data.type-length",
    TYPES,
    MUST,
    "A value of a numeric type has the length of its type.",
    reaction="as many bytes as the type has",
)
UNICODE = Rule(
    "data.unicode",
    STRINGS,
    MAY,
    "A UNICODE_STRING has 2 bytes for each character; an odd number is left to the device.",
    reaction="served, or abort",
    codes=accepted.WRONG_LENGTH,
    open="the effect of an odd number of bytes",
    untestable="Any effect of an odd number of bytes is right.",
)

SIZE_RULES = (
    Rule(
        "data.expedited-size",
        UPLOAD,
        MUST,
        "Expedited data with its size has 4 - n bytes.",
        reaction="2Fh, 2Bh, 27h, 23h and 4Fh, 4Bh, 47h, 43h for 1 to 4 bytes",
    ),
    Rule(
        "data.short-in-segments",
        DOWNLOAD,
        MUST,
        "Data of 4 bytes or fewer may come in segments.",
        reaction="served",
        open="a server may answer the upload of a short value either way",
    ),
    Rule(
        "data.long-in-segments",
        UPLOAD,
        MUST,
        "Data of more than 4 bytes cannot be expedited.",
        reaction="40h or 41h",
    ),
    Rule(
        "data.empty",
        DOWNLOAD,
        MAY,
        "A value of no bytes is stored and read as such, as one byte 00h, or refused.",
        reaction="served, or abort",
        codes=(AbortCode.NO_DATA, *accepted.NOT_EMPTY),
        open="whether a value may be empty",
    ),
    Rule(
        "download.size-error-moment",
        ABORT,
        MAY,
        "A wrong size is refused at the initiate, with a segment, or at the end; never confirmed.",
        reaction="abort",
        codes=accepted.WRONG_LENGTH,
        open="the moment",
    ),
    Rule(
        "abort.length-code",
        ABORT,
        MAY,
        "A wrong length is refused by the code for it in general, or by the one for its side.",
        reaction="abort",
        codes=accepted.WRONG_LENGTH,
        open="the general code, or the one for too many or too few bytes",
    ),
    TYPE_LENGTH,
    Rule(
        "data.boolean",
        BOOLEAN,
        MAY,
        "A BOOLEAN is 00h or 01h; what another value does is left to the device.",
        reaction="served, or abort",
        codes=accepted.ANY,
        open="the effect of values above 1",
        untestable="Any effect is right, and a value above 1 might set off one in the device.",
    ),
    VARIABLE_LENGTH,
    AS_WRITTEN,
    UNICODE,
)
