"""Sets of abort codes that several rules accept, the most precise code first."""

from conformance.sdo.abort_codes import OF_DOWNLOADS, OF_UPLOADS, AbortCode

ANY = tuple(AbortCode)
NOT_VALID = (AbortCode.COMMAND_NOT_VALID,)
TOGGLE_ERROR = (AbortCode.TOGGLE_NOT_ALTERNATED,)
TIMED_OUT = (AbortCode.TIMED_OUT,)
IMPOSSIBLE_NUMBER = (
    AbortCode.INVALID_SEQUENCE_NUMBER,
    AbortCode.INVALID_BLOCK_SIZE,
    AbortCode.COMMAND_NOT_VALID,
)
# An inner frame of a block transfer where another is due: no valid command there, or out of turn.
OUT_OF_PLACE = (AbortCode.COMMAND_NOT_VALID, AbortCode.INVALID_SEQUENCE_NUMBER)
TOO_LONG = (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_MISMATCH)
TOO_SHORT = (AbortCode.LENGTH_TOO_LOW, AbortCode.LENGTH_MISMATCH)
WRONG_LENGTH = (
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_TOO_LOW,
)
NO_ROOM = (*TOO_LONG, AbortCode.OUT_OF_MEMORY, AbortCode.NOT_TRANSFERABLE)
NOT_EMPTY = (
    *TOO_SHORT,
    AbortCode.NOT_TRANSFERABLE,
    AbortCode.INTERNALLY_INCOMPATIBLE,
    AbortCode.OUT_OF_MEMORY,
)
READ_ONLY = (AbortCode.WRITE_OF_READ_ONLY, AbortCode.UNSUPPORTED_ACCESS)
WRONG_VALUE = (AbortCode.VALUE_INVALID,)
OUT_OF_LIMITS = (AbortCode.VALUE_INVALID, AbortCode.VALUE_TOO_HIGH, AbortCode.VALUE_TOO_LOW)
# What a device may say about a value that the suite knows nothing against.
OF_ITS_OWN = (
    *OUT_OF_LIMITS,
    AbortCode.MAXIMUM_BELOW_MINIMUM,
    AbortCode.PARAMETER_INCOMPATIBLE,
    AbortCode.INTERNALLY_INCOMPATIBLE,
    AbortCode.NOT_MAPPABLE,
    AbortCode.MAPPING_TOO_LONG,
    AbortCode.HARDWARE_ERROR,
    AbortCode.NOT_TRANSFERABLE,
    AbortCode.LOCAL_CONTROL,
    AbortCode.DEVICE_STATE,
)
# What a device may say about an object of which nothing is known.
ABOUT_OBJECTS = (
    AbortCode.OUT_OF_MEMORY,
    *(code for code in AbortCode if code >= AbortCode.UNSUPPORTED_ACCESS),
)
OF_UNKNOWN_READ = tuple(code for code in ABOUT_OBJECTS if code not in OF_DOWNLOADS)
OF_UNKNOWN_WRITTEN = tuple(code for code in ABOUT_OBJECTS if code not in OF_UPLOADS)
IN_USE = (
    AbortCode.VALUE_INVALID,
    AbortCode.PARAMETER_INCOMPATIBLE,
    AbortCode.DEVICE_STATE,
    AbortCode.LOCAL_CONTROL,
)
NOT_MAPPED = (
    AbortCode.NOT_MAPPABLE,
    AbortCode.OBJECT_MISSING,
    AbortCode.SUB_INDEX_MISSING,
    AbortCode.MAPPING_TOO_LONG,
)

# Tolerated in the place of these: the general error nearly everywhere, and where a frame of a
# block transfer is wrong, that it is no valid command.
GENERAL = (AbortCode.GENERAL_ERROR,)
IMPRECISE = (AbortCode.GENERAL_ERROR, AbortCode.COMMAND_NOT_VALID)
# Of a segment whose length is called wrong, or its n no valid one.
ANY_LENGTH_ERROR = (*WRONG_LENGTH, *IMPRECISE)
