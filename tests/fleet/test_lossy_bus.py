"""canopen's client and our server on a bus that loses frames of block transfers.

What may get lost without ending the transfer is decided by canopen's client:

- It sends again what our server did not acknowledge, but not from the last sub-block: there it
  takes its data for sent, and for whole segments.
- It acknowledges less as soon as a number is missing, and waits for segment 1 then.
- Where the last segment of a sub-block is missing, it has it sent again after its own time-out,
  judges its number twice and drops it; the CRC tells.
- Where its acknowledgement is missing it acknowledges nothing after its time-out, and takes what
  is repeated for what is next; the CRC tells.
- It gives up a download whose acknowledgement is missing.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random

import can
import canopen
import pytest
from canopen.objectdictionary import ObjectDictionary
from canopen.sdo.client import SdoClient
from foreign_objects import DOMAIN, NODE_ID, payload
from lossy_bus import Relay, relayed

from conformance.faults.unusual.block_download import BlocksOf21
from conformance.reference.dictionary import reference_device
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.run.bench import private_channel
from conformance.sdo.frames import BlockAck, BlockSegment, Request, Response
from conformance.sdo.objects import ObjectDictionary as ReferenceObjects

SIZES = (500, 889, 2000, 5000)
PATIENT, HASTY = 20.0, 0.3


@pytest.fixture(scope="module")
def server_channel() -> str:
    """The channel on the far side of the relay."""
    return private_channel()


@pytest.fixture(scope="module")
def served(server_channel: str) -> Iterator[ReferenceObjects]:
    """The object dictionary of our server, which takes sub-blocks of 21 segments."""
    objects = reference_device(NODE_ID)
    bus = can.Bus(interface="virtual", channel=server_channel)
    with NodeHost(bus, Node(NODE_ID, BlocksOf21(objects))):
        yield objects


@pytest.fixture(scope="module")
def joined(
    virtual_channel: str, server_channel: str, served: ReferenceObjects
) -> Iterator[tuple[Relay, SdoClient]]:
    """The relay, and canopen's client on the near side of it."""
    with (
        relayed(virtual_channel, server_channel, NODE_ID) as relay,
        canopen.Network(can.Bus(interface="virtual", channel=virtual_channel)) as network,
    ):
        network.NOTIFIER_CYCLE = 0.05
        node = canopen.RemoteNode(NODE_ID, ObjectDictionary())  # type: ignore[no-untyped-call]
        network.add_node(node)
        network.connect()
        yield relay, node.sdo


@pytest.fixture
def relay(joined: tuple[Relay, SdoClient]) -> Iterator[Relay]:
    """The relay; it loses nothing until told what."""
    relay, _ = joined
    relay.lost.clear()
    yield relay
    relay.loses = lambda message: False


@pytest.fixture
def sdo(joined: tuple[Relay, SdoClient]) -> SdoClient:
    """canopen's client, which waits as long as a loaded machine may need."""
    _, sdo = joined
    sdo.RESPONSE_TIMEOUT = PATIENT
    return sdo


def write(sdo: SdoClient, data: bytes) -> None:
    """Write the domain in blocks."""
    with sdo.open(  # type: ignore[no-untyped-call]
        DOMAIN.index, 0, "wb", size=len(data), block_transfer=True
    ) as opened:
        opened.write(data)


def read(sdo: SdoClient) -> bytes:
    """Read the domain in blocks."""
    with sdo.open(DOMAIN.index, 0, "rb", block_transfer=True) as opened:  # type: ignore[no-untyped-call]
        return bytes(opened.read())


@dataclass
class LosesSegments:
    """Loses one segment in ``every``, but for the last of a sub-block, or of the last sub-block."""

    total: int
    random: Random
    every: int = 8
    done: int = 0
    block_size: int = 21

    def __call__(self, message: Request | Response) -> bool:
        if isinstance(message, BlockAck):
            self.done += message.sequence
        if not isinstance(message, BlockSegment) or self.done + self.block_size >= self.total:
            return False
        return message.sequence < self.block_size and self.random.randrange(self.every) == 0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", SIZES)
def test_download_with_lost_segments(
    relay: Relay, sdo: SdoClient, served: ReferenceObjects, size: int, seed: int
) -> None:
    relay.loses = LosesSegments(-(-size // 7), Random(seed))
    write(sdo, payload(size))
    assert served.find(DOMAIN).value == payload(size)
    assert len(relay.lost) > size // 200
    # A line knows what this client has written, whatever it had to send again.
    assert relay.line.completed == DOMAIN
    assert relay.line.in_flight[:size] == payload(size)
    assert relay.line.open is None


@dataclass
class LosesOnTheWayBack:
    """Loses one segment in ``every``: none that is the first or the last of a sub-block."""

    random: Random
    every: int = 20
    block_size: int = 127

    def __call__(self, message: Request | Response) -> bool:
        if not isinstance(message, BlockSegment) or message.last:
            return False
        inside = 1 < message.sequence < self.block_size
        return inside and self.random.randrange(self.every) == 0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", SIZES)
def test_upload_with_lost_segments(
    relay: Relay, sdo: SdoClient, served: ReferenceObjects, size: int, seed: int
) -> None:
    served.find(DOMAIN).value = payload(size)
    relay.loses = LosesOnTheWayBack(Random(seed))
    assert read(sdo) == payload(size)
    assert relay.lost


@dataclass
class LosesOnce:
    """Loses the first message that is ``chosen``."""

    chosen: Callable[[Request | Response], bool]
    lost: bool = False

    def __call__(self, message: Request | Response) -> bool:
        loses = not self.lost and self.chosen(message)
        self.lost |= loses
        return loses


def is_ack(message: Request | Response) -> bool:
    return isinstance(message, BlockAck)


def is_last(message: Request | Response) -> bool:
    return isinstance(message, BlockSegment) and message.last


def is_127th(message: Request | Response) -> bool:
    return isinstance(message, BlockSegment) and message.sequence == 127


@pytest.mark.parametrize(
    ("chosen", "error"),
    [
        (is_ack, "CRC is not OK"),
        (is_127th, "CRC is not OK"),
        (is_last, "No SDO response received"),
    ],
)
def test_upload_that_is_given_up(
    relay: Relay,
    sdo: SdoClient,
    served: ReferenceObjects,
    chosen: Callable[[Request | Response], bool],
    error: str,
) -> None:
    served.find(DOMAIN).value = payload(2000)
    relay.loses = LosesOnce(chosen)
    sdo.RESPONSE_TIMEOUT = HASTY
    with pytest.raises(canopen.SdoCommunicationError, match=error):
        read(sdo)
    sdo.RESPONSE_TIMEOUT = PATIENT
    assert read(sdo) == payload(2000)


@pytest.mark.parametrize("chosen", [is_ack, is_last])
def test_download_that_is_given_up(
    relay: Relay,
    sdo: SdoClient,
    served: ReferenceObjects,
    chosen: Callable[[Request | Response], bool],
) -> None:
    served.find(DOMAIN).value = b"as before"
    relay.loses = LosesOnce(chosen)
    sdo.RESPONSE_TIMEOUT = HASTY
    # After its own abort it sends the end all the same, which our server then refuses.
    with pytest.raises(canopen.SdoAbortedError, match="0x05040001"):
        write(sdo, payload(500))
    assert served.find(DOMAIN).value == b"as before"
    sdo.RESPONSE_TIMEOUT = PATIENT
    write(sdo, payload(500))
    assert served.find(DOMAIN).value == payload(500)
