"""The object dictionary that each worked exchange needs in the reference server."""

from support.sdo_vectors import mux

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry

U8, U16, U32 = DataType.UNSIGNED8, DataType.UNSIGNED16, DataType.UNSIGNED32
TEXT, DOMAIN = DataType.VISIBLE_STRING, DataType.DOMAIN
RW, RO = Access.RW, Access.RO
TINY = b"Tiny Node - Mega Domains !"
DEMO = b"CANopenDemoPIC32"
DEVICE_TYPE = bytes.fromhex("91010F00")
ONE_TO_32 = bytes(range(32))
ONE_TO_16 = bytes(range(1, 17))

# The entries of each exchange: name, value before, type, access, lowest and highest value.
Row = tuple[str, bytes, DataType, Access] | tuple[str, bytes, DataType, Access, tuple[int, int]]
OBJECTS: dict[str, list[Row]] = {
    "V01": [("1017", bytes(2), U16, RW)],
    "V02": [("1018:01", b"\x04\0\0\0", U32, RO)],
    "V03": [("1008", TINY, TEXT, RO)],
    "V05": [("2000:01", ONE_TO_32, DOMAIN, RW)],
    "V06": [("2000:01", b"", DOMAIN, RW)],
    "V07": [("6060", bytes(1), DataType.INTEGER8, RW)],
    "V08": [("6040", bytes(2), U16, RW)],
    "V10": [("1000", DEVICE_TYPE, U32, RO)],
    "V11": [("1017", bytes(2), U16, RW)],
    "V12": [("1000", DEVICE_TYPE, U32, RO)],
    "V13": [("1000", DEVICE_TYPE, U32, RO)],
    "V14": [("1000", DEVICE_TYPE, U32, RO)],
    "V15": [("1000", DEVICE_TYPE, U32, RO)],
    "V16": [("1003", bytes(1), U8, RW)],
    "V17": [("1005", b"\x80\0\0\0", U32, RW)],
    "V18": [("1003", bytes(1), U8, RW, (0, 8))],
    "V19": [("1200:01", b"\x04\x06\0\0", U32, RO), ("1200:02", b"\x84\x05\0\0", U32, RO)],
    "V20": [("1017", bytes(2), U16, RW)],
    "V21": [("1008", DEMO, TEXT, RO)],
    "V22": [("1008", DEMO, TEXT, RO)],
    "V30": [("1200:01", b"\x04\x06\0\0", U32, RO)],
    "V31": [("1011:01", b"\x01\0\0\0", U32, RW)],
    "V32": [("1000", DEVICE_TYPE, U32, RO)],
    "V33": [("1005", b"\x80\0\0\0", U32, RW, (0x80, 0x7FF))],
    "V34": [("1008", DEMO, TEXT, Access.CONST)],
    "V40": [("2000:01", b"", DOMAIN, RW)],
    "V41": [("2000:01", ONE_TO_16, DOMAIN, RW)],
    "V42": [("1008", b"750-337", TEXT, RO)],
    "V43": [("1008", b"CAN-8423\0", TEXT, RO)],
    "V44": [("100A", b"FIR-v1748-B538662", TEXT, RO)],
    "V45": [("1400:02", b"\xff", U8, RW)],
    "V46": [("1603:01", bytes(4), U32, RW)],
    "V47": [("2120:0B", b"", DOMAIN, RW)],
    "V50": [("1000", bytes.fromhex("92014200"), U32, RO)],
    "V51": [("100A", b"123", TEXT, RO)],
    "V52": [("6003", bytes(4), U32, RW)],
    "V53": [("1008", b"new slave", TEXT, RO)],
    "V54": [("1009", b"", TEXT, RW)],
    "V55": [("6003:0A", bytes(8), DataType.UNSIGNED64, RW)],
    "V56": [("1008", b"new slave", TEXT, RO)],
    "V57": [("1000:FF", b"\x07\x07\0\0", U32, RO), ("1003:FF", b"\x08\x07\0\0", U32, RO)],
    "V60": [("2000", b"", TEXT, RW)],
    "V62": [("2000", b"old", TEXT, RW)],
    "V64": [("1400:02", b"\xfe", U8, RW)],
    "V65": [("1008", b"Tiny", TEXT, RO)],
    "V94": [("2005", bytes(8), DataType.UNSIGNED64, RW)],
    "V96": [("2000", bytes(4), U32, RW)],
    "V97": [("2005", bytes(8), DataType.UNSIGNED64, RW)],
    "V101": [("1008", TINY, TEXT, RO), ("1018:01", b"\x04\0\0\0", U32, RO)],
}
# What the writing exchanges leave behind; all others leave everything as it was.
WRITTEN = {
    "V01": b"\xa0\x0f",
    "V06": ONE_TO_16,
    "V07": b"\x01",
    "V08": b"\x06\0",
    "V11": bytes(2),
    "V20": bytes(2),
    "V31": b"load",
    "V40": ONE_TO_16,
    "V45": b"\xfd",
    "V46": bytes.fromhex("08021260"),
    "V47": b"fileWrittenByDomain",
    "V52": bytes.fromhex("78563412"),
    "V54": b"new slave name",
    "V55": bytes.fromhex("0011223344556677"),
    "V60": b"A long string",
    "V62": b"",
    "V94": bytes.fromhex("0102030405060708"),
    "V96": bytes.fromhex("01020304"),
}


def entries(vector_id: str) -> dict[Multiplexer, Entry]:
    found = {}
    for name, value, data_type, access, *limits in OBJECTS[vector_id]:
        low, high = limits[0] if limits else (None, None)
        found[mux(name)] = Entry(value, data_type, access, low, high)
    return found
