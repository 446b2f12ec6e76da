"""The abort codes: those of CiA 301, table 22, and no other, each with its meaning."""

import pytest

from conformance.sdo.abort_codes import AbortCode, describe_code

TABLE_22 = {
    0x05030000: "05030000h (toggle bit not alternated)",
    0x05040000: "05040000h (SDO protocol timed out)",
    0x05040001: "05040001h (command specifier not valid or unknown)",
    0x05040002: "05040002h (invalid block size)",
    0x05040003: "05040003h (invalid sequence number)",
    0x05040004: "05040004h (CRC error)",
    0x05040005: "05040005h (out of memory)",
    0x06010000: "06010000h (unsupported access to an object)",
    0x06010001: "06010001h (read of a write-only object)",
    0x06010002: "06010002h (write of a read-only object)",
    0x06020000: "06020000h (object does not exist)",
    0x06040041: "06040041h (object cannot be mapped to a PDO)",
    0x06040042: "06040042h (mapped objects exceed the PDO length)",
    0x06040043: "06040043h (general parameter incompatibility)",
    0x06040047: "06040047h (general internal incompatibility)",
    0x06060000: "06060000h (access failed because of a hardware error)",
    0x06070010: "06070010h (data type or length does not match)",
    0x06070012: "06070012h (length too high)",
    0x06070013: "06070013h (length too low)",
    0x06090011: "06090011h (sub-index does not exist)",
    0x06090030: "06090030h (invalid value for the parameter)",
    0x06090031: "06090031h (value too high)",
    0x06090032: "06090032h (value too low)",
    0x06090036: "06090036h (maximum value below minimum value)",
    0x060A0023: "060A0023h (SDO connection not available)",
    0x08000000: "08000000h (general error)",
    0x08000020: "08000020h (data cannot be transferred or stored)",
    0x08000021: "08000021h (data cannot be transferred or stored: local control)",
    0x08000022: "08000022h (data cannot be transferred or stored: present device state)",
    0x08000023: "08000023h (no object dictionary present)",
    0x08000024: "08000024h (no data available)",
}


def test_there_are_31() -> None:
    assert len(TABLE_22) == 31
    assert set(AbortCode) == set(TABLE_22)


@pytest.mark.parametrize(
    ("code", "text"), TABLE_22.items(), ids=[f"{code:08X}h" for code in TABLE_22]
)
def test_text(code: int, text: str) -> None:
    assert describe_code(code) == text


@pytest.mark.parametrize("code", [0, 0x06010003, 0x06060010, 0x06020002, 0xFFFFFFFF])
def test_private_codes_are_named_as_such(code: int) -> None:
    assert describe_code(code) == f"{code:08X}h (not an abort code of CiA 301)"
