"""Exchanges written a line a frame, and what the oracle finds in them.

``>`` is the client, ``<`` the server.
"""

from dataclasses import replace

from support.sdo_vectors import mux

from conformance.sdo.objects import Access, DataType
from conformance.sdo.oracle import Facts, Knowledge, Oracle, Presence
from conformance.sdo.rules import Violation


def facts(data_type: DataType, value: bytes, access: Access = Access.RW) -> Facts:
    return Facts(
        Presence.PRESENT, access, data_type, value, steady=True, any_value=True, capacity=64
    )


KNOWN = Knowledge.complete(
    {
        mux("1000"): facts(DataType.UNSIGNED32, b"\x91\x01\x0f\0", Access.CONST),
        mux("1008"): facts(DataType.VISIBLE_STRING, b"Tiny Node", Access.CONST),
        mux("2000"): facts(DataType.UNSIGNED32, b"\1\2\3\4"),
        mux("2001"): replace(facts(DataType.UNSIGNED8, b"\1"), low=1, high=9),
        mux("2002"): facts(DataType.UNSIGNED32, b"\1\2\3\4", Access.WO),
        mux("2010"): facts(DataType.VISIBLE_STRING, b"old value"),
    }
)
READ = "> 40 00 10 00 00 00 00 00"
UPLOAD = "> 40 08 10 00 00 00 00 00 \n < 41 08 10 00 09 00 00 00"
DOWNLOAD = "> 21 10 20 00 09 00 00 00 \n < 60 10 20 00 00 00 00 00"
BLOCK_DOWNLOAD = "> C6 10 20 00 0E 00 00 00 \n < A4 10 20 00 04 00 00 00"
BLOCK_SENT = (
    BLOCK_DOWNLOAD
    + "\n > 01 30 31 32 33 34 35 36 \n > 82 37 38 39 3A 3B 3C 3D \n < A2 02 04 00 00 00 00 00"
)
BLOCK_UPLOAD = "> A4 08 10 00 02 00 00 00 \n < C6 08 10 00 09 00 00 00"
BLOCK_RECEIVED = (
    BLOCK_UPLOAD
    + "\n > A3 00 00 00 00 00 00 00 \n < 01 54 69 6E 79 20 4E 6F \n < 82 64 65 00 00 00 00 00"
)
NO_SUCH = "02 00 06"


def judged(exchange: str, oracle: Oracle | None = None) -> list[Violation]:
    oracle = oracle or Oracle(KNOWN)
    found: list[Violation] = []
    before = ""
    for line in filter(None, map(str.strip, exchange.splitlines())):
        direction, frame = line[0], bytes.fromhex(line[1:])
        if direction == "<":
            found += oracle.response(frame)
        else:
            found += oracle.settled() if before == "<" else []
            oracle.request(frame)
        before = direction
    return found + oracle.settled()
