"""What PDOs map, and what of them does not change while they are valid (7.5.2.35 to 7.5.2.38)."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MUST, Rule

SENT_PDO = "7.5.2.37"
MAPPINGS = "7.5.2.36 and 7.5.2.38"
# How a device says that a value is wrong, where the specification names better codes.
_IMPRECISE = (
    AbortCode.GENERAL_ERROR,
    AbortCode.VALUE_INVALID,
    AbortCode.SUB_INDEX_MISSING,
    AbortCode.MAPPING_TOO_LONG,
    AbortCode.PARAMETER_INCOMPATIBLE,
    AbortCode.DEVICE_STATE,
)

MAPPABLE = Rule(
    "pdo.mappable",
    MAPPINGS,
    MUST,
    "A PDO maps no object whose description says that no PDO may map it.",
    reaction="abort",
    codes=(AbortCode.NOT_MAPPABLE, AbortCode.OBJECT_MISSING),
    tolerated=_IMPRECISE,
    open="the moment: the entry, or the number of entries",
)
ACCESS = Rule(
    "pdo.mapped-access",
    MAPPINGS,
    MUST,
    "A received PDO maps no object that is read-only, a sent one none that is write-only.",
    reaction="abort",
    codes=(AbortCode.NOT_MAPPABLE, AbortCode.OBJECT_MISSING),
    tolerated=(*_IMPRECISE, AbortCode.READ_OF_WRITE_ONLY),
    open="the moment: the entry, or the number of entries",
)
IN_USE = Rule(
    "pdo.mapping-in-use",
    MAPPINGS,
    MUST,
    "A PDO maps objects that exist and may be mapped, with the bits that they have.",
    reaction="served",
    open="dummies: a received PDO may map the types 0001h to 0007h",
)
PROCEDURE = Rule(
    "pdo.mapping-procedure",
    MAPPINGS,
    MUST,
    "A mapping does not change while its PDO is valid, nor an entry while some are in use.",
    reaction="abort",
    codes=(
        AbortCode.UNSUPPORTED_ACCESS,
        AbortCode.NOT_MAPPABLE,
        AbortCode.DEVICE_STATE,
        AbortCode.VALUE_INVALID,
        AbortCode.GENERAL_ERROR,
        AbortCode.WRITE_OF_READ_ONLY,
    ),
    tolerated=(
        AbortCode.LOCAL_CONTROL,
        AbortCode.NOT_TRANSFERABLE,
        AbortCode.PARAMETER_INCOMPATIBLE,
        AbortCode.INTERNALLY_INCOMPATIBLE,
        AbortCode.MAPPING_TOO_LONG,
    ),
    open="which of the codes; whether an entry can be changed at all",
)
REMAPPED = Rule(
    "pdo.mapping-taken",
    MAPPINGS,
    MUST,
    "A mapping that can be changed is taken in the order that the specification states.",
    reaction="served; abort where a mapping is fixed, or the state of the device forbids it",
    codes=(*accepted.READ_ONLY, AbortCode.LOCAL_CONTROL, AbortCode.DEVICE_STATE),
    open="whether a mapping can be changed at all",
)
COUNT = Rule(
    "pdo.mapping-count",
    MAPPINGS,
    MUST,
    "A PDO maps 64 objects at most: no mapping has 41h to FDh entries.",
    reaction="abort",
    codes=(
        AbortCode.MAPPING_TOO_LONG,
        AbortCode.VALUE_INVALID,
        AbortCode.VALUE_TOO_HIGH,
        AbortCode.NOT_MAPPABLE,
        AbortCode.OBJECT_MISSING,
        AbortCode.SUB_INDEX_MISSING,
    ),
    tolerated=(AbortCode.GENERAL_ERROR, AbortCode.PARAMETER_INCOMPATIBLE),
    open="which of the codes; FEh and FFh, for multiplexed PDOs",
)
KEPT_WHILE_VALID = Rule(
    "pdo.kept-while-valid",
    SENT_PDO,
    MUST,
    "Neither inhibit time nor SYNC start value changes while the PDO is valid.",
    reaction="abort",
    codes=accepted.IN_USE,
    tolerated=(
        AbortCode.GENERAL_ERROR,
        AbortCode.UNSUPPORTED_ACCESS,
        AbortCode.WRITE_OF_READ_ONLY,
        AbortCode.NOT_TRANSFERABLE,
        AbortCode.INTERNALLY_INCOMPATIBLE,
    ),
    open="the code",
)
PDO_RULES = (
    MAPPABLE,
    ACCESS,
    IN_USE,
    PROCEDURE,
    REMAPPED,
    COUNT,
    KEPT_WHILE_VALID,
)
