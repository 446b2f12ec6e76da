"""Sets of abort codes that several rules accept, the most precise code first.

08000000h, the general error, stands last where the official conformance test accepts it too.
"""

from conformance.sdo.abort_codes import AbortCode

NOT_VALID = (AbortCode.COMMAND_NOT_VALID,)
NOT_VALID_OR_GENERAL = (AbortCode.COMMAND_NOT_VALID, AbortCode.GENERAL_ERROR)
TOGGLE_ERROR = (AbortCode.TOGGLE_NOT_ALTERNATED,)
TIMED_OUT = (AbortCode.TIMED_OUT,)
TOO_LONG = (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_MISMATCH)
TOO_SHORT = (AbortCode.LENGTH_TOO_LOW, AbortCode.LENGTH_MISMATCH)
WRONG_LENGTH = (
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_TOO_LOW,
    AbortCode.LENGTH_MISMATCH,
)
READ_ONLY = (
    AbortCode.WRITE_OF_READ_ONLY,
    AbortCode.UNSUPPORTED_ACCESS,
    AbortCode.GENERAL_ERROR,
)
WRONG_VALUE = (AbortCode.VALUE_INVALID,)
