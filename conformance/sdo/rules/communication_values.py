"""Values that objects of the communication refuse, and those that they have by default."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MUST, SHOULD, Rule

PREDEFINED = "7.3.3"
ERROR_LIST = "7.5.2.4"
CONFIGURATION = "7.5.2.23"
CONSUMED = "7.5.2.19"
OVERFLOW = "7.5.2.22"
ERROR_BEHAVIOUR_OBJECT = "7.5.2.32"

CONSUMED_TWICE = Rule(
    "communication.consumed-twice",
    CONSUMED,
    MUST,
    "The heartbeat of one node is awaited by one entry of 1016h at most.",
    reaction="abort",
    codes=(AbortCode.PARAMETER_INCOMPATIBLE,),
    tolerated=(AbortCode.GENERAL_ERROR, AbortCode.VALUE_INVALID),
    open="whether it has 1016h; how many entries",
)
SYNC_COUNTER = Rule(
    "communication.sync-counter",
    OVERFLOW,
    MUST,
    "1019h takes 0 and 2 to 240; other values are reserved.",
    reaction="abort",
    codes=accepted.OUT_OF_LIMITS,
    open="whether it has 1019h",
)
SYNC_COUNTER_IN_USE = Rule(
    "communication.sync-counter-in-use",
    OVERFLOW,
    MUST,
    "1019h does not change while 1006h is not 0.",
    reaction="abort",
    codes=(AbortCode.DEVICE_STATE, AbortCode.GENERAL_ERROR),
    tolerated=(AbortCode.LOCAL_CONTROL, AbortCode.VALUE_INVALID, AbortCode.PARAMETER_INCOMPATIBLE),
    open="whether it has 1019h and 1006h",
)
ERROR_BEHAVIOUR = Rule(
    "communication.error-behaviour",
    ERROR_BEHAVIOUR_OBJECT,
    MUST,
    "1029h:01 takes no behaviour that is reserved: 03h to 7Fh.",
    reaction="abort",
    codes=(*accepted.WRONG_VALUE, AbortCode.VALUE_TOO_HIGH),
    open="whether it has 1029h",
)

EMERGENCY_LISTED = Rule(
    "communication.emergency-listed",
    ERROR_LIST,
    MUST,
    "An error of which an emergency has told stands in the list of errors (1003h).",
    open="whether it has 1003h; whether the list survives a reset",
)
LATEST_FIRST = Rule(
    "communication.latest-error-first",
    ERROR_LIST,
    SHOULD,
    "The latest error stands in 1003h:01.",
)

COMMUNICATION_VALUE_RULES = (
    CONSUMED_TWICE,
    SYNC_COUNTER,
    SYNC_COUNTER_IN_USE,
    ERROR_BEHAVIOUR,
    EMERGENCY_LISTED,
    LATEST_FIRST,
    Rule(
        "communication.configuration-date",
        CONFIGURATION,
        MUST,
        "The date and time of the configuration (1020h) are stored as parameters are.",
        open="whether it has 1020h, and 1010h",
    ),
    Rule(
        "communication.default-identifier",
        PREDEFINED,
        MUST,
        "With the defaults, 1005h has the CAN-ID 080h, and 1014h has 080h plus node-ID.",
        open="whether SYNC is produced, and EMCY in use",
    ),
)
