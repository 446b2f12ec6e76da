"""What a device has, held against its description (EDS, CiA 306-1)."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

EDS = "CiA 306-1"
ACCESS = "7.4.5"
STRUCTURE = "7.4.2"
IDENTITY = "7.5.2.21"
STORE = "7.5.2.13"
RESTORE = "7.5.2.14"
COMMANDS = f"{STORE} and {RESTORE}"

STRUCTURE_ENTRY = Rule(
    "dictionary.structure",
    STRUCTURE,
    MAY,
    "Sub-index FFh is missing, or holds the data type and the object type.",
    reaction="served, or abort",
    codes=(AbortCode.SUB_INDEX_MISSING,),
    open="whether there is a sub-index FFh",
)
UNLISTED = Rule(
    "dictionary.unlisted",
    EDS,
    SHOULD,
    "A device has no objects but those of its description.",
    reaction="abort",
    codes=(AbortCode.OBJECT_MISSING,),
)
STATED_TEXT = Rule(
    "dictionary.stated-text",
    EDS,
    SHOULD,
    "A text has no 00h behind it that its description does not state.",
)
UNLISTED = Rule(
    "dictionary.unlisted",
    EDS,
    SHOULD,
    "A device has no objects but those of its description.",
    reaction="abort",
    codes=(AbortCode.OBJECT_MISSING,),
)
SIGNATURE = Rule(
    "storage.signature",
    COMMANDS,
    MUST,
    "What is no signature is refused: nothing is stored, and no defaults are loaded.",
    reaction="abort",
    codes=(
        AbortCode.NOT_TRANSFERABLE,
        AbortCode.LOCAL_CONTROL,
        AbortCode.DEVICE_STATE,
    ),
    tolerated=(AbortCode.GENERAL_ERROR, AbortCode.VALUE_INVALID),
    open="whether it has 1010h and 1011h; which of the codes",
)

STORES_BY_ITSELF = Rule(
    "storage.by-itself",
    STORE,
    SHOULD,
    "A device that stores its parameters by itself says so in 1010h.",
)

OBJECT_DICTIONARY_RULES = (
    Rule(
        "dictionary.access",
        ACCESS,
        MUST,
        "What is described as readable can be read, what as writable takes the value that it has.",
        reaction="served",
        open="an object may refuse in the present state of the device",
    ),
    Rule(
        "dictionary.default",
        EDS,
        MUST,
        "A constant has the value that the description states.",
    ),
    STATED_TEXT,
    Rule(
        "dictionary.limits",
        EDS,
        MUST,
        "The value of a number lies within the limits that the description states.",
    ),
    Rule(
        "dictionary.limits-included",
        EDS,
        MUST,
        "The limits themselves are values that may be written.",
        reaction="served",
    ),
    Rule(
        "dictionary.configured",
        EDS,
        SHOULD,
        "A device that was configured has the values of its configuration file.",
    ),
    Rule(
        "dictionary.identity",
        IDENTITY,
        MUST,
        "The device is of the vendor, product and revision that the description is for.",
    ),
    UNLISTED,
    Rule(
        "dictionary.highest-sub-index",
        STRUCTURE,
        MUST,
        "Sub-index 0 of an array or record holds the highest sub-index of it.",
        open="where it can be written, and in a mapping of a PDO, it counts what is in use",
    ),
    STRUCTURE_ENTRY,
    Rule(
        "storage.load-defaults",
        RESTORE,
        MUST,
        "A device that loads its defaults on command has them after the next reset of the node.",
        reaction="served",
        open="whether it has 1011h; whether the defaults are in use before the reset",
    ),
    Rule(
        "storage.save",
        STORE,
        MUST,
        "A device that stores its parameters on command has them after the next reset.",
        reaction="served",
        open="whether it has 1010h",
    ),
    SIGNATURE,
    STORES_BY_ITSELF,
)
