"""How fast transfers go, beside canopen's client and beside python-can alone.

Everything runs on python-can's virtual bus in this process, our server in a thread of its own. The
floor is the exchange of as many frames in the same rhythm without any protocol: request and
response, or as many segments in a row as a sub-block has and one answer. All take their turn in
each of many short rounds, and what stands in the table is the median of each: a machine with other
work to do disturbs all alike, and how the two threads happen to meet makes the best of a client
differ by a tenth from one time to the next, its median by a fiftieth.
"""

import sys
import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import can
import canopen
from bench_rows import Cost, Row, cost, typical
from canopen.objectdictionary import ObjectDictionary
from canopen.sdo.client import SdoClient

from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.device.device import Device
from conformance.device.safety import WritePolicy
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.faults.hosting import virtual_host
from conformance.run.bench import private_channel
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Level, Rule

sys.path.insert(0, str(Path(__file__).parents[1] / "fleet"))
from foreign_objects import DOMAIN, NODE_ID, payload
from suite_client import SuiteClient

from conformance.dialogue.blocks import Blocks

NUMBER = Multiplexer(0x2004)
RULE = Rule("bench", "", Level.MAY, "What a transfer costs.")
BLOCK = 127
# A block transfer moves so many times as many bytes in the time of a segmented one.
FASTER = 10
PATIENCE = 10.0
CANOPEN = "canopen"


@dataclass(frozen=True, slots=True)
class Rhythm:
    """Rounds of a number of frames from the client and a number of frames back."""

    rounds: int
    requests: int
    responses: int

    @property
    def frames(self) -> int:
        """All frames, in both directions."""
        return self.rounds * (self.requests + self.responses)


@dataclass(frozen=True, slots=True)
class Transfer:
    """One way to move bytes: how each client does it, and the rhythm of its frames."""

    name: str
    moved: int
    rhythm: Rhythm
    ours: Callable[[SuiteClient], object]
    case: Callable[[Dialogue], object]
    canopen: Callable[[SdoClient], object]


def floor(rhythm: Rhythm) -> Cost:
    """Exchange bare frames."""
    channel = private_channel()

    def message() -> can.Message:
        return can.Message(arbitration_id=0x605, data=bytes(8), is_extended_id=False)

    with (
        can.Bus(interface="virtual", channel=channel) as near,
        can.Bus(interface="virtual", channel=channel) as far,
    ):

        def answer() -> None:
            for _ in range(rhythm.rounds):
                for _ in range(rhythm.requests):
                    far.recv(PATIENCE)
                for _ in range(rhythm.responses):
                    far.send(message())

        def ask() -> None:
            for _ in range(rhythm.rounds):
                for _ in range(rhythm.requests):
                    near.send(message())
                for _ in range(rhythm.responses):
                    near.recv(PATIENCE)

        thread = threading.Thread(target=answer)
        thread.start()
        found = cost(ask)
        thread.join()
    return found


@contextmanager
def clients() -> Iterator[tuple[SuiteClient, Dialogue, SdoClient]]:
    """Our client, the ``sdo`` of a case and canopen's client, each on a bus with our server.

    Each has a server and a channel of its own, so that none gets the frames of another.
    """
    with ExitStack() as stack:
        channels = [private_channel() for _ in range(3)]
        for channel in channels:
            stack.enter_context(virtual_host(channel, NODE_ID, None))
        near = []
        for channel in channels[:2]:
            link = Link(can.Bus(interface="virtual", channel=channel), channel)
            stack.callback(link.close)
            near.append(Channel(link, NODE_ID, PATIENCE))
        device = Device(NODE_ID, policy=WritePolicy([DOMAIN, NUMBER]))
        network = stack.enter_context(
            canopen.Network(can.Bus(interface="virtual", channel=channels[2]))
        )
        node = canopen.RemoteNode(NODE_ID, ObjectDictionary())  # type: ignore[no-untyped-call]
        network.add_node(node)
        network.connect()
        node.sdo.RESPONSE_TIMEOUT = PATIENCE
        yield SuiteClient(near[0]), Dialogue(near[1], device, CaseRecord(RULE), seed=1), node.sdo


def repeated(count: int, task: Callable[[], object]) -> None:
    """Do a short task ``count`` times."""
    for _ in range(count):
        task()


def canopen_write(sdo: SdoClient, data: bytes) -> None:
    """Write in blocks with canopen's client."""
    with sdo.open(  # type: ignore[no-untyped-call]
        DOMAIN.index, 0, "wb", size=len(data), block_transfer=True
    ) as opened:
        opened.write(data)


def canopen_read(sdo: SdoClient) -> bytes:
    """Read in blocks with canopen's client."""
    with sdo.open(DOMAIN.index, 0, "rb", block_transfer=True) as opened:  # type: ignore[no-untyped-call]
        return bytes(opened.read())


def transfers(size: int, count: int) -> Generator[Transfer, None, None]:
    """Return what is measured; each download leaves what the upload behind it reads."""
    data, long, number = payload(size), payload(FASTER * size), payload(4)
    once, piece = Rhythm(count, 1, 1), Rhythm(-(-len(data) // 7) + 1, 1, 1)
    blocks = -(-len(long) // (7 * BLOCK))
    yield Transfer(
        "expedited download",
        4 * count,
        once,
        lambda sdo: repeated(count, lambda: sdo.download(NUMBER, number)),
        lambda sdo: repeated(count, lambda: sdo.download(NUMBER, number)),
        lambda sdo: repeated(count, lambda: sdo.download(NUMBER.index, 0, number)),
    )
    yield Transfer(
        "expedited upload",
        4 * count,
        once,
        lambda sdo: repeated(count, lambda: sdo.upload(NUMBER)),
        lambda sdo: repeated(count, lambda: sdo.upload(NUMBER)),
        lambda sdo: repeated(count, lambda: sdo.upload(NUMBER.index, 0)),
    )
    yield Transfer(
        "segmented download",
        size,
        piece,
        lambda sdo: sdo.download(DOMAIN, data),
        lambda sdo: sdo.download(DOMAIN, data),
        lambda sdo: sdo.download(DOMAIN.index, 0, data),
    )
    yield Transfer(
        "segmented upload",
        size,
        piece,
        lambda sdo: sdo.upload(DOMAIN),
        lambda sdo: sdo.upload(DOMAIN),
        lambda sdo: sdo.upload(DOMAIN.index, 0),
    )
    yield Transfer(
        "block download",
        len(long),
        Rhythm(blocks, BLOCK, 1),
        lambda sdo: sdo.block_download(DOMAIN, long),
        lambda sdo: Blocks(sdo).download(DOMAIN, long),
        lambda sdo: canopen_write(sdo, long),
    )
    yield Transfer(
        "block upload",
        len(long),
        Rhythm(blocks, 1, BLOCK),
        lambda sdo: sdo.block_upload(DOMAIN),
        lambda sdo: Blocks(sdo).upload(DOMAIN),
        canopen_read,
    )


def transfer_rows(wanted: str, size: int, count: int, rounds: int) -> Iterator[Row]:
    """Yield a row for each transfer and client: no case may compute more than canopen's client."""
    with clients() as (ours, case, foreign):
        for transfer in transfers(size, count):
            if wanted in transfer.name:
                runs: dict[str, Callable[[], Cost]] = {
                    "python-can alone": partial(floor, transfer.rhythm),
                    "ours": partial(cost, partial(transfer.ours, ours)),
                    "ours, in a case": partial(cost, partial(transfer.case, case)),
                    CANOPEN: partial(cost, partial(transfer.canopen, foreign)),
                }
                tries = [[run() for run in runs.values()] for _ in range(rounds)]
                costs = [typical(each) for each in zip(*tries, strict=True)]
                by_client = dict(zip(runs, costs, strict=True))
                for client, found in by_client.items():
                    own = client.startswith("ours")
                    yield Row(
                        f"{transfer.name}, {client}",
                        found,
                        costs[0],
                        f"{by_client[CANOPEN].cpu:.3f} s cpu" if own else "",
                        not own or found.cpu <= by_client[CANOPEN].cpu,
                        f"{transfer.moved / 1024 / found.wall:.0f} KiB/s, "
                        f"{transfer.rhythm.frames / found.wall:.0f} frames/s",
                    )
