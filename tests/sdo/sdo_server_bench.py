"""A reference server with one object of each sort, spoken to in hexadecimal."""

from support.sdo_vectors import mux

from conformance.reference.server import Server
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, ObjectDictionary

READ_1000 = "40 00 10 00 00 00 00 00"
ANSWER_1000 = "43 00 10 00 91 01 0F 00"


def objects() -> dict[Multiplexer, Entry]:
    return {
        mux("1000"): Entry(bytes.fromhex("91010F00"), DataType.UNSIGNED32, Access.RO),
        mux("1008"): Entry(b"Tiny Node - Mega Domains !", DataType.VISIBLE_STRING, Access.CONST),
        mux("1018:00"): Entry(b"\x04", DataType.UNSIGNED8, Access.CONST),
        mux("1018:01"): Entry(b"\x04\x00\x00\x00", DataType.UNSIGNED32, Access.RO),
        mux("2000"): Entry(b"\x11\x22\x33\x44", DataType.UNSIGNED32),
        mux("2001"): Entry(b"before", DataType.DOMAIN, capacity=32),
        mux("2002"): Entry(bytes(4), DataType.UNSIGNED32, Access.WO),
        mux("2003"): Entry(b"\x05\x00", DataType.INTEGER16, low=-10, high=100),
        mux("2004"): Entry(b"", DataType.VISIBLE_STRING),
        mux("2005"): Entry(bytes(8), DataType.UNSIGNED64),
        mux("2006"): Entry(b"\x00", DataType.UNSIGNED8),
    }


class Bench:
    """A server and what its objects hold."""

    def __init__(self) -> None:
        self.entries = objects()
        self.server = Server(ObjectDictionary(self.entries))

    def ask(self, request: str) -> list[str]:
        """Send one frame; return the answers."""
        return [frame.hex(" ").upper() for frame in self.server.receive(bytes.fromhex(request))]

    def replay(self, conversation: str) -> None:
        """Perform an exchange, a line a frame: ``>`` to the server, ``<`` from it."""
        answers: list[str] = []
        for line in filter(None, map(str.strip, conversation.splitlines())):
            arrow, frame = line[0], line[1:].strip()
            if arrow == ">":
                assert answers == [], f"before {line}"
                answers = self.ask(frame)
            else:
                assert answers[:1] == [frame], line
                answers = answers[1:]
        assert answers == []

    def value(self, name: str) -> bytes:
        return self.entries[mux(name)].value

    def is_idle(self) -> bool:
        """Read 1000h; in a transfer as well as idle this has to work, so look inside, too."""
        return self.server.transfer is None and self.ask(READ_1000) == [ANSWER_1000]
