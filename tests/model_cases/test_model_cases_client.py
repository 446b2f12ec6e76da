"""The client of conversations, without a bus: what it sends to a server that stands behind it."""

from collections.abc import Mapping, Sequence

import pytest

from conformance.model_cases.conversations.conversation import Disturbance, Event, Service, Transfer
from conformance.model_cases.conversations.disturbed_client import (
    Action,
    Heard,
    Send,
    Settle,
    Then,
    conversing,
    drive,
)
from conformance.model_cases.matrix.stimuli import Targets
from conformance.reference.built_in_device import reference_entries
from conformance.reference.server import Server
from conformance.sdo.decoding import decode_response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import ObjectDictionary

NODE_ID = 5
TEXT, MISSING = Multiplexer(0x2010), Multiplexer(0x1FFF)


class Objects:
    """One string, into which letters are written."""

    targets = Targets(NODE_ID, TEXT, MISSING, MISSING, bytes(4))
    rooms: Mapping[Multiplexer, int] = {TEXT: 100}
    numbers: Sequence[Multiplexer] = ()
    readable: Sequence[Multiplexer] = (TEXT,)

    def data(self, transfer: Transfer) -> bytes:
        """Return letters."""
        return b"abcdefghijklmnopqrstuvwxyz"[: transfer.size]

    def harmless(self, data: bytes) -> bytes:
        """Return the request as it is: nothing here can be harmed."""
        return data

    def longest(self, mux: Multiplexer) -> int:
        """Return the same for each object."""
        return self.rooms[mux]


class Driver:
    """Hands frames to a server; keeps what was sent, with the objects that were settled."""

    def __init__(self, then: Then = Then.GO_ON) -> None:
        self.server = Server(ObjectDictionary(reference_entries(NODE_ID)))
        self.done: list[str | Multiplexer] = []
        self._then = then

    def do(self, action: Action) -> Heard:
        """Do what is asked for."""
        match action:
            case Send():
                self.done.append(action.frame.data.hex(" ")[:5])
                answers = self.server.receive(action.frame.data)
                return Heard([decode_response(answer) for answer in answers], self._then)
            case Settle():
                self.done.append(action.target)
        return Heard()


def held(*disturbances: Disturbance, then: Then = Then.GO_ON) -> tuple[list[object], bytes]:
    """Hold a conversation about a download of 15 bytes; return what was done and is stored."""
    driver = Driver(then)
    download = Transfer(Service.DOWNLOAD, TEXT, 15, disturbances=disturbances)
    drive(conversing((download,), Objects()), driver.do)
    return [*driver.done], driver.server.objects.find(TEXT).value


READ = ["40 10"]


def test_what_is_written_is_read_back() -> None:
    done, value = held()
    assert done == ["21 10", "00 61", "10 68", "0d 6f", TEXT, *READ, "60 00", "70 00", "60 00"]
    assert value == b"abcdefghijklmno"


@pytest.mark.parametrize(
    ("event", "begin"),
    [
        (Event.LEAVE, ["21 10", "00 61", TEXT]),
        (Event.ABORT, ["21 10", "00 61", "80 10", TEXT]),
        (Event.LOSE, ["21 10", "00 61", TEXT, TEXT]),
    ],
)
def test_a_disturbed_transfer_ends_there(event: Event, begin: list[object]) -> None:
    done, value = held(Disturbance(2, event))
    assert done[: len(begin) + 1] == [*begin, *READ]
    assert value == b"text"


def test_a_refusal_is_settled() -> None:
    done, _ = held(Disturbance(2, Event.ALTER, mask=0x10))
    assert done[:5] == ["21 10", "00 61", "00 68", TEXT, TEXT]


def test_a_flood_is_ended_by_the_driver() -> None:
    done, _ = held(then=Then.ENOUGH)
    assert done[:3] == ["21 10", TEXT, TEXT]
