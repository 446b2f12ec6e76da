"""Devices in this process, and the case that talks to one of them over python-can's virtual bus."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import can

from conformance.beginning.discovery import discover
from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.device import Device
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.permits import Permits
from conformance.device.protected_objects import OTHER_NODES, READ_ONLY_PROBES
from conformance.device.safety import WritePolicy
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.reference.built_in_device import REFERENCE_OBJECTS, reference_entries
from conformance.reference.host import HostedNode, NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.run.bench import private_channel
from conformance.run.case_run import CaseRun, begin_case
from conformance.run.session import DeviceSession
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, ObjectDictionary
from conformance.sdo.rules import Level, Rule, Violation

NODE_ID = 5
# What comes, comes at once; what does not come is waited for.
PATIENT, HASTY = 10.0, 0.05
RULE = Rule("test.rule", "7.2.4", Level.MUST, "What the case is about.")
PROBES = frozenset({READ_ONLY_PROBES, OTHER_NODES})
READ = bytes.fromhex("4000100000000000")
BASELINE = bytes.fromhex("4300100091010F00")
VENDOR_ID = bytes.fromhex("00000C5D")  # as 1018h:01 of the built-in device reads
NUMBER = KnownObject(Multiplexer(0x2004), REFERENCE_OBJECTS[3].data_type)
TEXT = REFERENCE_OBJECTS[5]
DOMAIN = REFERENCE_OBJECTS[6]


class Recording(Server):
    """Keeps the requests that reach it and the values that are stored, by object."""

    def __init__(self, entries: dict[Multiplexer, Entry]) -> None:
        super().__init__(ObjectDictionary(entries))
        self.entries = entries
        self.requests: list[bytes] = []
        self.writes: list[tuple[Multiplexer, bytes]] = []

    def receive(self, frame: bytes) -> list[bytes]:
        self.requests.append(frame)
        return super().receive(frame)

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        self.writes += [(mux, own.value) for mux, own in self.entries.items() if own is entry]

    def values(self) -> dict[Multiplexer, bytes]:
        return {mux: entry.value for mux, entry in self.entries.items()}


class Scripted(HostedNode):
    """A node that is all its own: ``answers`` says what it sends for the data of a request."""

    def __init__(self, answers: Callable[[bytes], Iterable[bytes | CanFrame]]) -> None:
        self.answers = answers
        self.requests: list[bytes] = []

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if frame.can_id != 0x600 + NODE_ID:
            return []
        self.requests.append(frame.data)
        return [
            answer if isinstance(answer, CanFrame) else CanFrame(0x580 + NODE_ID, answer)
            for answer in self.answers(frame.data)
        ]


@dataclass
class Workbench:
    """A device, the channel to it, and what is known of it."""

    channel: Channel
    device: Device
    bus_name: str

    def dialogue(self, rule: Rule = RULE) -> Dialogue:
        return Dialogue(self.channel, self.device, CaseRecord(rule), seed=1)

    def session(self) -> DeviceSession:
        return DeviceSession(self.channel, self.device, seed=1, cansend_channel="can0")

    def send_from_elsewhere(self, *frames: CanFrame) -> None:
        """Let another node of the bus send frames."""
        with can.Bus(interface="virtual", channel=self.bus_name) as bus:
            for frame in frames:
                bus.send(
                    can.Message(
                        arbitration_id=frame.can_id,
                        data=frame.data,
                        is_extended_id=frame.extended,
                    )
                )


def recording(
    kind: type[Recording] = Recording, entries: dict[Multiplexer, Entry] | None = None
) -> Recording:
    """Return a server on the objects of the built-in device."""
    return kind(reference_entries(NODE_ID) if entries is None else entries)


@contextmanager
def undiscovered(
    node: HostedNode | Server,
    *,
    timeout: float = PATIENT,
    objects: Iterable[KnownObject] = REFERENCE_OBJECTS,
) -> Iterator[Workbench]:
    """Host a node; nothing is known of it but that 1000h reads as on the built-in device."""
    name = private_channel()
    hosted = Node(NODE_ID, node) if isinstance(node, Server) else node
    known = list(objects)
    writable = [entry.mux for entry in known if entry.access.writable]
    device = Device(
        NODE_ID,
        by_multiplexer(known),
        baseline=[(READ, BASELINE)],
        policy=WritePolicy(writable, PROBES),
        permits=Permits(permissions=PROBES),
    )
    link = Link(open_bus(BusSettings("virtual", name)), name)
    try:
        with NodeHost(open_bus(BusSettings("virtual", name)), hosted) as host:
            try:
                yield Workbench(Channel(link, NODE_ID, timeout), device, name)
            finally:
                host.stop()
                link.send(CanFrame(0x7FF))  # it need not poll once more to see that
    finally:
        link.close()


@contextmanager
def discovered(
    node: HostedNode | Server,
    *,
    timeout: float = PATIENT,
    objects: Iterable[KnownObject] = REFERENCE_OBJECTS,
) -> Iterator[Workbench]:
    """Host a node and get to know it, as a run does before its first case."""
    with undiscovered(node, timeout=timeout, objects=objects) as bench:
        discover(bench.channel, bench.device)
        yield bench


def begin(session: DeviceSession, case_id: str = "a.case") -> CaseRun:
    """Begin a case that is about ``RULE``."""
    return begin_case(session, case_id, "a service", RULE)


def violation(rule: Rule = RULE, actual: str = "something") -> Violation:
    """Build a breach of a rule."""
    return Violation(rule, expected="another thing", actual=actual)
