"""A device that never stops talking holds up nothing: each wait has an end that does not move."""

from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

import pytest
from support.run_bench import BASELINE, NODE_ID, READ, RULE

from conformance.beginning.discovery import discover
from conformance.beginning.first_request import ask_first
from conformance.beginning.revival import Revival
from conformance.beginning.two_devices import examine
from conformance.bus.channel import Channel
from conformance.bus.errors import BenchError
from conformance.bus.link import Link
from conformance.bus.opening import BusSettings
from conformance.device.device import Device
from conformance.device.known_objects import by_multiplexer
from conformance.device.permits import Permits
from conformance.device.process import DeviceProcess, ProcessSettings
from conformance.device.protected_objects import PERMISSIONS
from conformance.device.safety import WritePolicy
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.faults.catalogue import build_node
from conformance.logs.reading import RecordedLog
from conformance.logs.replay_plan import read_plan
from conformance.logs.replaying import Replay
from conformance.model_cases.lockstep import Lockstep
from conformance.reference.built_in_device import REFERENCE_OBJECTS
from conformance.reference.host import HostedNode
from conformance.reference.simulated_bus import SimulatedBus, SimulatedClock
from conformance.run.bench import Bench, RunSettings
from conformance.run.session import DeviceSession
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.oracle import Knowledge, Oracle
from conformance.sdo.rules import Violation

# Longer than this, in seconds, nothing waits here that asks a few times.
TOO_LONG = 120.0
OTHER = bytes.fromhex("4301200001020304")
SEGMENT = bytes.fromhex("0141424344454647")
LAST = bytes.fromhex("8141424344454647")
ACKNOWLEDGED = bytes.fromhex("A2007F0000000000")
ABORT = bytes.fromhex("8000100000000008")


class Bounded(SimulatedClock):
    """A clock of which nobody waits for the end."""

    def wait_until(self, due: float) -> None:
        super().wait_until(due)
        if self.now() > TOO_LONG:
            pytest.fail(f"something waits for more than {TOO_LONG:g} s")


class Talking(HostedNode):
    """Sends a frame of its own again and again, beside what a ``node`` answers."""

    def __init__(self, frame: CanFrame, gap: float, node: HostedNode | None) -> None:
        self.frame = frame
        self.gap = gap
        self.node = node
        self.next = 0.0

    def start(self) -> list[CanFrame]:
        return [] if self.node is None else self.node.start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        return [] if self.node is None else self.node.receive(frame)

    def advance(self, now: float) -> list[CanFrame]:
        frames = [] if self.node is None else self.node.advance(now)
        if now >= self.next:
            self.next = now + self.gap
            frames = [*frames, self.frame]
        return frames

    @property
    def wake_at(self) -> float:
        return self.next


def response(data: bytes) -> CanFrame:
    return CanFrame(0x580 + NODE_ID, data)


TALK = {
    "another answer": response(OTHER),
    "the same answer": response(BASELINE),
    "segments": response(SEGMENT),
    "last segments": response(LAST),
    "acknowledgements": response(ACKNOWLEDGED),
    "aborts": response(ABORT),
    "heartbeats": CanFrame(0x700 + NODE_ID, b"\5"),
    "boot-ups": CanFrame(0x700 + NODE_ID, b"\0"),
}
Wait = Callable[[Dialogue], object]


def _discover(sdo: Dialogue) -> None:
    discover(sdo.channel, sdo.device)


def _begin(sdo: Dialogue) -> None:
    session = DeviceSession(sdo.channel, sdo.device, seed=1, cansend_channel="")
    session.survey()
    session.begin("a.case", RULE)


def _reset(sdo: Dialogue) -> None:
    Network(sdo).reset(NmtCommand.RESET_NODE)


def _heartbeats(sdo: Dialogue) -> None:
    network = Network(sdo)
    network.produce_heartbeats()
    network.send(NmtCommand.START)
    network.settle()
    network.linger()
    network.end_heartbeats()
    network.end()


def _fence(sdo: Dialogue) -> None:
    sdo.send(READ)
    sdo.fence()


def _transfers(sdo: Dialogue) -> None:
    text = REFERENCE_OBJECTS[5]
    for transfer in (
        lambda: sdo.upload(text),
        lambda: sdo.download(text, bytes(30)),
        lambda: sdo.run(sdo.client.block_upload(text.mux)),
        lambda: sdo.run(sdo.client.block_download(text.mux, bytes(30))),
    ):
        with suppress(Violation, ServerAborted):
            transfer()
        sdo.silence.recover()


def _lockstep(sdo: Dialogue) -> None:
    lockstep = Lockstep(sdo, Oracle(Knowledge({}), node_id=NODE_ID))
    mux = Multiplexer(0x2010)
    with lockstep.following():
        for data in ("C210200000000000", SEGMENT.hex(), "A010200000000000", "A300000000000000"):
            lockstep.send(sdo.channel.ids.request.frame(bytes.fromhex(data)), point=True)
            lockstep.behind_gap()
        lockstep.settle(mux)


def _revive(sdo: Dialogue) -> None:
    settings = ProcessSettings(start_limit=3.0, attempts=2)
    revival = Revival(settings, DeviceProcess(settings, Path("unused")), sdo.channel)
    assert revival.attempt() is not None


WAITS: dict[str, Wait] = {
    "discovery": _discover,
    "two devices": lambda sdo: examine(sdo.channel, sdo.device),
    "first request": lambda sdo: ask_first(sdo.channel),
    "survey": _begin,
    "reset": _reset,
    "heartbeats": _heartbeats,
    "fence": _fence,
    "outlast": lambda sdo: sdo.silence.outlast(),
    "drain": lambda sdo: sdo.drain(),
    "recover": lambda sdo: sdo.silence.recover(),
    "transfers": _transfers,
    "lockstep": _lockstep,
    "revival": _revive,
    "nothing": lambda sdo: sdo.wait(1.0),
}


@pytest.fixture(params=[0.1, 0.0005], ids=["every 100 ms", "without a gap"])
def gap(request: pytest.FixtureRequest) -> float:
    value: float = request.param
    return value


@pytest.fixture(params=[True, False], ids=["serves", "serves not"])
def serves(request: pytest.FixtureRequest) -> bool:
    value: bool = request.param
    return value


def link_to(nodes: Iterable[HostedNode]) -> Link:
    return Link(SimulatedBus(nodes, clock=Bounded()), "simulated")


@pytest.mark.parametrize("wait", WAITS.values(), ids=WAITS)
@pytest.mark.parametrize("frame", TALK.values(), ids=TALK)
def test_each_wait_ends(wait: Wait, frame: CanFrame, gap: float, serves: bool) -> None:
    node = build_node(None, NODE_ID) if serves else None
    link = link_to([Talking(frame, gap, node)])
    known = list(REFERENCE_OBJECTS)
    device = Device(
        NODE_ID,
        by_multiplexer(known),
        baseline=[(READ, BASELINE)],
        policy=WritePolicy([entry.mux for entry in known if entry.access.writable], PERMISSIONS),
        permits=Permits(permissions=frozenset(PERMISSIONS)),
    )
    sdo = Dialogue(Channel(link, NODE_ID, 0.5), device, CaseRecord(RULE), 1)
    with suppress(Violation, ServerAborted, BenchError):
        wait(sdo)
    link.close()


@pytest.mark.parametrize("frame", TALK.values(), ids=TALK)
def test_a_run_begins_and_ends(frame: CanFrame, gap: float, serves: bool, tmp_path: Path) -> None:
    node = build_node(None, NODE_ID) if serves else None
    bus = SimulatedBus([Talking(frame, gap, node)], clock=Bounded())
    settings = RunSettings([NODE_ID], BusSettings("virtual", "none"), response_timeout=0.1)
    bench = Bench(settings, [], lambda captured: None, tmp_path, opener=lambda _: bus)
    bench.open()
    bench.close()
    assert len(bench.sessions) + len(bench.silent) >= 1


@pytest.mark.parametrize("frame", TALK.values(), ids=TALK)
def test_a_replay_ends(frame: CanFrame, gap: float, serves: bool, tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.write_text(
        "(1.000000) can0 605#4000100000000000\n(1.001000) can0 585#4300100091010F00\n"
        "(1.002000) can0 605#4018100100000000\n(1.003000) can0 585#4318100104000000\n",
        encoding="ascii",
    )
    node = build_node(None, NODE_ID) if serves else None
    link = link_to([Talking(frame, gap, node)])
    plan = read_plan(RecordedLog(str(log)), None)
    with Replay(link, "bus", plan, 0.5) as replay:
        assert len(list(replay.exchanges())) == 2


def test_a_clock_that_nobody_waits_for_the_end_of() -> None:
    link = link_to([])
    with pytest.raises(pytest.fail.Exception):
        link.receive(2 * TOO_LONG)
