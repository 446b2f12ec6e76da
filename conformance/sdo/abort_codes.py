"""The abort codes that CiA 301 (7.2.4.3.17, table 22) knows. A server may send no other."""

from enum import IntEnum


class AbortCode(IntEnum):
    """Why an SDO transfer was aborted; on the wire an unsigned 32-bit number, low byte first."""

    TOGGLE_NOT_ALTERNATED = 0x0503_0000
    TIMED_OUT = 0x0504_0000
    COMMAND_NOT_VALID = 0x0504_0001
    INVALID_BLOCK_SIZE = 0x0504_0002
    INVALID_SEQUENCE_NUMBER = 0x0504_0003
    CRC_ERROR = 0x0504_0004
    OUT_OF_MEMORY = 0x0504_0005
    UNSUPPORTED_ACCESS = 0x0601_0000
    READ_OF_WRITE_ONLY = 0x0601_0001
    WRITE_OF_READ_ONLY = 0x0601_0002
    OBJECT_MISSING = 0x0602_0000
    NOT_MAPPABLE = 0x0604_0041
    MAPPING_TOO_LONG = 0x0604_0042
    PARAMETER_INCOMPATIBLE = 0x0604_0043
    INTERNALLY_INCOMPATIBLE = 0x0604_0047
    HARDWARE_ERROR = 0x0606_0000
    LENGTH_MISMATCH = 0x0607_0010
    LENGTH_TOO_HIGH = 0x0607_0012
    LENGTH_TOO_LOW = 0x0607_0013
    SUB_INDEX_MISSING = 0x0609_0011
    VALUE_INVALID = 0x0609_0030
    VALUE_TOO_HIGH = 0x0609_0031
    VALUE_TOO_LOW = 0x0609_0032
    MAXIMUM_BELOW_MINIMUM = 0x0609_0036
    CONNECTION_NOT_AVAILABLE = 0x060A_0023
    GENERAL_ERROR = 0x0800_0000
    NOT_TRANSFERABLE = 0x0800_0020
    LOCAL_CONTROL = 0x0800_0021
    DEVICE_STATE = 0x0800_0022
    NO_OBJECT_DICTIONARY = 0x0800_0023
    NO_DATA = 0x0800_0024


_TEXTS = {
    AbortCode.TOGGLE_NOT_ALTERNATED: "toggle bit not alternated",
    AbortCode.TIMED_OUT: "SDO protocol timed out",
    AbortCode.COMMAND_NOT_VALID: "command specifier not valid or unknown",
    AbortCode.INVALID_BLOCK_SIZE: "invalid block size",
    AbortCode.INVALID_SEQUENCE_NUMBER: "invalid sequence number",
    AbortCode.CRC_ERROR: "CRC error",
    AbortCode.OUT_OF_MEMORY: "out of memory",
    AbortCode.UNSUPPORTED_ACCESS: "unsupported access to an object",
    AbortCode.READ_OF_WRITE_ONLY: "read of a write-only object",
    AbortCode.WRITE_OF_READ_ONLY: "write of a read-only object",
    AbortCode.OBJECT_MISSING: "object does not exist",
    AbortCode.NOT_MAPPABLE: "object cannot be mapped to a PDO",
    AbortCode.MAPPING_TOO_LONG: "mapped objects exceed the PDO length",
    AbortCode.PARAMETER_INCOMPATIBLE: "general parameter incompatibility",
    AbortCode.INTERNALLY_INCOMPATIBLE: "general internal incompatibility",
    AbortCode.HARDWARE_ERROR: "access failed because of a hardware error",
    AbortCode.LENGTH_MISMATCH: "data type or length does not match",
    AbortCode.LENGTH_TOO_HIGH: "length too high",
    AbortCode.LENGTH_TOO_LOW: "length too low",
    AbortCode.SUB_INDEX_MISSING: "sub-index does not exist",
    AbortCode.VALUE_INVALID: "invalid value for the parameter",
    AbortCode.VALUE_TOO_HIGH: "value too high",
    AbortCode.VALUE_TOO_LOW: "value too low",
    AbortCode.MAXIMUM_BELOW_MINIMUM: "maximum value below minimum value",
    AbortCode.CONNECTION_NOT_AVAILABLE: "SDO connection not available",
    AbortCode.GENERAL_ERROR: "general error",
    AbortCode.NOT_TRANSFERABLE: "data cannot be transferred or stored",
    AbortCode.LOCAL_CONTROL: "data cannot be transferred or stored: local control",
    AbortCode.DEVICE_STATE: "data cannot be transferred or stored: present device state",
    AbortCode.NO_OBJECT_DICTIONARY: "no object dictionary present",
    AbortCode.NO_DATA: "no data available",
}


# Why an application ends what was allowed, whatever it was sent.
APPLICATION_STATE = (AbortCode.NOT_TRANSFERABLE, AbortCode.LOCAL_CONTROL, AbortCode.DEVICE_STATE)
# What calls a request of the client wrong: it has such a request for a reason.
ACCUSATIONS = (
    AbortCode.TOGGLE_NOT_ALTERNATED,
    AbortCode.COMMAND_NOT_VALID,
    AbortCode.INVALID_BLOCK_SIZE,
    AbortCode.INVALID_SEQUENCE_NUMBER,
    AbortCode.CRC_ERROR,
)
# What is about reading alone, or about writing.
OF_UPLOADS = (AbortCode.READ_OF_WRITE_ONLY,)
OF_DOWNLOADS = (
    AbortCode.WRITE_OF_READ_ONLY,
    AbortCode.NOT_MAPPABLE,
    AbortCode.MAPPING_TOO_LONG,
    AbortCode.VALUE_INVALID,
    AbortCode.VALUE_TOO_HIGH,
    AbortCode.VALUE_TOO_LOW,
)


def describe_code(code: int) -> str:
    """Return an abort code as the field writes it, with its meaning.

    >>> describe_code(0x05030000)
    '05030000h (toggle bit not alternated)'
    """
    return f"{code:08X}h ({meaning_of(code)})"


def meaning_of(code: int) -> str:
    """Return what an abort code means."""
    return _TEXTS[AbortCode(code)] if code in _TEXTS else "not an abort code of CiA 301"
