"""Objects by which a device communicates beside SDO: what they tell, and what they refuse."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

IDENTITY = "7.5.2.21"
ERROR_REGISTER = "7.5.2.2"
ERROR_LIST = "7.5.2.4"
COMMANDS = "7.5.2.13 and 7.5.2.14"
STORED_EDS = "7.5.2.24"
COB_IDS = "7.5.2.5, 7.5.2.15, 7.5.2.17, 7.5.2.35 and 7.5.2.37"
RESTRICTED = "7.3.5"
SENT_PDO = "7.5.2.37"
PDOS = "7.5.2.35 and 7.5.2.37"
MAPPINGS = "7.5.2.36 and 7.5.2.38"

ERROR_LIST_COUNT = Rule(
    "communication.error-list-count",
    ERROR_LIST,
    MUST,
    "1003h:00 takes nothing but 0.",
    reaction="abort",
    codes=(*accepted.WRONG_VALUE, AbortCode.VALUE_TOO_HIGH),
)
RESTRICTED_IDENTIFIER = Rule(
    "communication.restricted-identifier",
    RESTRICTED,
    MUST,
    "SYNC, TIME, EMCY and PDOs take none of the CAN-IDs that are kept for other services.",
    reaction="abort",
    codes=accepted.OUT_OF_LIMITS,
    open="the code",
)
IDENTIFIER_BITS = Rule(
    "communication.identifier-bits",
    COB_IDS,
    MUST,
    "Bits 28 to 11 of the COB-IDs of SYNC, TIME, EMCY and PDOs are 0 without bit 29.",
    reaction="abort",
    codes=accepted.WRONG_VALUE,
)
VALID_KEEPS_IDENTIFIER = Rule(
    "communication.valid-keeps-identifier",
    COB_IDS,
    MUST,
    "The COB-ID of SYNC, TIME, EMCY or a PDO does not change while it is in use.",
    reaction="abort",
    codes=accepted.IN_USE,
    open="the code",
)
OPTIONAL_BITS = Rule(
    "communication.optional-bits",
    COB_IDS,
    MAY,
    "A COB-ID takes bits 29 and 30 and reads back so, or refuses those it does not support.",
    reaction="served, or abort",
    codes=accepted.WRONG_VALUE,
    tolerated=(
        AbortCode.GENERAL_ERROR,
        AbortCode.VALUE_TOO_HIGH,
        AbortCode.PARAMETER_INCOMPATIBLE,
        AbortCode.INTERNALLY_INCOMPATIBLE,
        AbortCode.DEVICE_STATE,
    ),
    open="whether there are CAN-IDs of 29 bits, a producer of SYNC, PDOs on request",
)
RESERVED_ENTRY = Rule(
    "communication.reserved-entry",
    SENT_PDO,
    MUST,
    "Sub-index 04h of 1800h to 19FFh is reserved and does not exist.",
    reaction="abort; served where the EDS lists it",
    codes=(AbortCode.SUB_INDEX_MISSING,),
    open="whether there is the compatibility entry of DS-301 4.02",
)
COMPATIBILITY_ENTRY = Rule(
    "communication.compatibility-entry",
    SENT_PDO,
    SHOULD,
    "A device after DS-301 4.02, with a sub-index 04h of 1800h, lists it in its EDS.",
)
TRANSMISSION_TYPE = Rule(
    "communication.transmission-type",
    PDOS,
    MUST,
    "A PDO refuses a transmission type that it does not support, as reserved ones.",
    reaction="abort",
    codes=(*accepted.WRONG_VALUE, AbortCode.VALUE_TOO_HIGH),
)
MAPPED_OBJECT = Rule(
    "communication.mapped-object",
    MAPPINGS,
    MUST,
    "What cannot be mapped is not: an object that does not exist.",
    reaction="abort",
    codes=accepted.NOT_MAPPED,
    tolerated=(AbortCode.GENERAL_ERROR, AbortCode.VALUE_INVALID),
    open="the moment: the entry, or the number of entries",
)

MAPPED_LENGTH = Rule(
    "communication.mapped-length",
    MAPPINGS,
    MUST,
    "A PDO maps 8 bytes at most.",
    reaction="abort",
    codes=accepted.NOT_MAPPED,
    tolerated=(AbortCode.GENERAL_ERROR, AbortCode.VALUE_INVALID),
    open="the moment: the entry, or the number of entries",
)

COMMUNICATION_RULES = (
    Rule(
        "communication.vendor-id",
        IDENTITY,
        MUST,
        "1018h:01 holds the vendor-ID of its manufacturer; 0 is none.",
    ),
    Rule(
        "communication.error-register",
        ERROR_REGISTER,
        MUST,
        "Bit 0 of the error register is set whenever another bit is.",
    ),
    Rule(
        "communication.error-list-cleared",
        ERROR_LIST,
        MUST,
        "A 0 that is written to 1003h:00 clears the list of errors.",
        reaction="served",
        open="whether there is 1003h",
    ),
    ERROR_LIST_COUNT,
    Rule(
        "communication.storage-capability",
        COMMANDS,
        MUST,
        "1010h and 1011h read as what they can do, with the reserved bits 0.",
        open="whether there are 1010h and 1011h",
    ),
    Rule(
        "communication.stored-eds",
        STORED_EDS,
        MUST,
        "1021h is the EDS of the device, read in segments or in blocks.",
        open="whether there is 1021h; a format of the manufacturer (1022h)",
    ),
    RESTRICTED_IDENTIFIER,
    IDENTIFIER_BITS,
    VALID_KEEPS_IDENTIFIER,
    OPTIONAL_BITS,
    RESERVED_ENTRY,
    COMPATIBILITY_ENTRY,
    TRANSMISSION_TYPE,
    MAPPED_OBJECT,
    MAPPED_LENGTH,
)
