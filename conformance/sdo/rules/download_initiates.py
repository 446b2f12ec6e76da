"""Initiates of downloads of all three protocols: reserved bits, sizes, values."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, Rule

DOWNLOAD = "7.2.4.3.3"
BLOCK_DOWNLOAD = "7.2.4.3.9"
ABORT = "7.2.4.3.17"

UNUSED_WITHOUT_SIZE = Rule(
    "download.unused-without-size",
    DOWNLOAD,
    MAY,
    "n without an indicated size of expedited data means nothing; it never shortens the data.",
    reaction="served without a look at n, or abort",
    codes=accepted.NOT_VALID,
    tolerated=(*accepted.GENERAL, *accepted.WRONG_LENGTH),
    open="served or refused",
)
TOO_LONG = Rule(
    "download.too-long",
    ABORT,
    MUST,
    "An expedited download of more bytes than the type has is refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_LONG,
)
TOO_SHORT = Rule(
    "download.too-short",
    ABORT,
    MUST,
    "An expedited download of fewer bytes than the type has is refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_SHORT,
)
SIZE_NOT_INDICATED_SHORT = Rule(
    "download.size-not-indicated-short",
    DOWNLOAD,
    MAY,
    "Expedited data without its size (22h) for a short type: the low bytes count, or none.",
    reaction="served, with the bytes of the type, or abort",
    codes=accepted.TOO_LONG,
    open="served or refused",
)
SIZE_NOT_INDICATED = Rule(
    "download.size-not-indicated",
    DOWNLOAD,
    MUST,
    "Expedited data without its size (22h) is taken for a type of 4 bytes.",
    reaction="served, or abort where the type has no fixed length",
    codes=accepted.WRONG_LENGTH,
)
NUMBER_TOO_LONG = Rule(
    "segmented-download.number-too-long",
    ABORT,
    MUST,
    "A segmented download of more bytes than the type has is refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_LONG,
    open="the moment: the initiate, or at the latest when there are too many bytes",
)
NUMBER_TOO_SHORT = Rule(
    "segmented-download.number-too-short",
    ABORT,
    MUST,
    "A segmented download of fewer bytes than the type has is refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_SHORT,
    open="the moment: the initiate, or at the latest the last segment",
)
NUMBER_EMPTY = Rule(
    "segmented-download.number-empty",
    ABORT,
    MUST,
    "A download of 0 bytes to a type of fixed size is refused.",
    reaction="abort, the object keeps its value",
    codes=accepted.TOO_SHORT,
    open="the moment: the initiate, or at the latest the last segment",
)
HUGE_SIZE = Rule(
    "download.huge-size",
    DOWNLOAD,
    MAY,
    "A size beyond all memory is taken for the time being, or refused.",
    reaction="served, or abort",
    codes=accepted.NO_ROOM,
    open="served or refused, and the code",
)
SEGMENTED_SIZE_NOT_INDICATED = Rule(
    "segmented-download.size-not-indicated",
    DOWNLOAD,
    MUST,
    "A segmented download that does not say its size (20h) is served.",
    reaction="served, without a look at bytes 4 to 7",
    open="a server may answer an upload without a size too",
)
LIMITS = Rule(
    "object.limits",
    ABORT,
    MUST,
    "A value outside the limits of an object is refused, and the object keeps its own.",
    reaction="abort, the object keeps its value",
    codes=accepted.OUT_OF_LIMITS,
    open="the general code for a value, or the one for its side",
)
BLOCK_NUMBER_LENGTH = Rule(
    "block-download.number-length",
    ABORT,
    MUST,
    "A block download of more or fewer bytes than the type has is refused.",
    reaction="abort, the object keeps its value",
    codes=(*accepted.WRONG_LENGTH, AbortCode.CRC_ERROR),
    tolerated=accepted.IMPRECISE,
    open="the moment: the initiate, or at the latest the end",
)

DOWNLOAD_RESERVED_BIT = Rule(
    "download.request-reserved-bit",
    DOWNLOAD,
    MAY,
    "Bit 4 of a download initiate may be ignored or refused.",
    reaction="served, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)
BLOCK_DOWNLOAD_RESERVED_BITS = Rule(
    "block-download.request-reserved-bits",
    BLOCK_DOWNLOAD,
    MAY,
    "Bits 4 and 3 of a block download initiate may be ignored or refused.",
    reaction="served, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)

DOWNLOAD_INITIATE_RULES = (
    DOWNLOAD_RESERVED_BIT,
    UNUSED_WITHOUT_SIZE,
    BLOCK_DOWNLOAD_RESERVED_BITS,
    Rule(
        "download.unused-bytes-ignored",
        DOWNLOAD,
        MUST,
        "The bytes of an expedited download that hold no data are not written.",
        reaction="served, with 4 - n bytes",
    ),
    TOO_LONG,
    TOO_SHORT,
    SIZE_NOT_INDICATED_SHORT,
    SIZE_NOT_INDICATED,
    NUMBER_TOO_LONG,
    NUMBER_TOO_SHORT,
    NUMBER_EMPTY,
    HUGE_SIZE,
    SEGMENTED_SIZE_NOT_INDICATED,
    LIMITS,
    BLOCK_NUMBER_LENGTH,
)
