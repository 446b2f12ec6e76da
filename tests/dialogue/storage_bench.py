"""A device that keeps parameters without power, and a watch on what it is sent."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from support.run_bench import NODE_ID, PATIENT, Workbench

from conformance.beginning.discovery import discover
from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.device import Device
from conformance.device.known_objects import by_multiplexer
from conformance.device.permits import Permits, known_objects
from conformance.device.safety import WritePolicy
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_eds import listing_of, permits_for
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.run.bench import private_channel
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand

NUMBER = Multiplexer(0x2004)
IN_USE = b"\x0a\x0b\x0c\x0d"


@dataclass(frozen=True)
class Kept:
    """What a node has: in use, and behind its next reset."""

    values: dict[Multiplexer, bytes]
    power_on: list[bytes]

    @classmethod
    def of(cls, node: Node) -> "Kept":
        return cls(
            {mux: entry.value for mux, entry in node.objects.items()},
            [value for _, _, value in node.power_on],
        )


class Watched:
    """A node, and the NMT commands, the signatures and all other requests that it was sent."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.commands: list[str] = []
        self.reads = 0
        self.requests: list[bytes] = []
        self.silent = False

    def start(self) -> list[CanFrame]:
        return self.node.start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if frame.can_id == 0:
            self.commands.append(NmtCommand(frame.data[0]).name)
        if frame.data[:1] == b"\x23" and frame.data[1:4] in (b"\x10\x10\x01", b"\x11\x10\x01"):
            self.commands.append(frame.data[4:].decode())
        self.reads += frame.data == UploadInitiate(NUMBER).encode()
        if frame.can_id == REQUEST_BASE + NODE_ID:
            self.requests.append(frame.data)
        return [] if self.silent else self.node.receive(frame)

    def advance(self, now: float) -> list[CanFrame]:
        return self.node.advance(now)

    @property
    def wake_at(self) -> float | None:
        return self.node.wake_at


@contextmanager
def configured(
    name: str = "parameters-stored",
    *without: str,
    permits: Permits | None = None,
    node: Node | None = None,
) -> Iterator[tuple[Workbench, Watched]]:
    """Host a device that is in use, all but the permissions ``without`` given."""
    described = build_node(name, NODE_ID)
    described.objects.remove(0x2120)  # has an empty string: an EDS can state no default for it
    listing = listing_of(node or described)
    watched = Watched(node or described)
    permits = permits or permits_for(described)
    permits = replace(permits, permissions=permits.permissions - set(without))
    objects = known_objects(permits.named, listing)
    device = Device(
        NODE_ID,
        by_multiplexer(objects),
        policy=WritePolicy(permits.allowed(objects), permits.permissions),
        listing=listing,
        permits=permits,
    )
    bus = private_channel()
    link = Link(open_bus(BusSettings("virtual", bus)), bus)
    try:
        with NodeHost(open_bus(BusSettings("virtual", bus)), watched):
            channel = Channel(link, NODE_ID, PATIENT)
            channel.receive_error_control()  # it has booted
            watched.node.objects.find(NUMBER).value = IN_USE
            discover(channel, device)
            yield Workbench(channel, device, bus), watched
    finally:
        link.close()
