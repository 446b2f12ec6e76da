"""A device that loses what comes right behind an abort: it gets its time, and is no silent node."""

from support.run_bench import BASELINE, NODE_ID, READ

from conformance.beginning.discovery import discover
from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.device.device import Device
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.reference.simulated_bus import SimulatedBus
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.objects import ObjectDictionary


class LosesOne(Node):
    """Does not see the first request."""

    lost = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if frame.data == READ and not self.lost:
            self.lost = True
            return []
        return super().receive(frame)


def rest_of(node: Node) -> float:
    link = Link(SimulatedBus([node]), "simulated")
    channel, device = Channel(link, NODE_ID, 0.5), Device(NODE_ID)
    discover(channel, device)
    assert device.baseline == [(READ, BASELINE)]
    link.close()
    return channel.rest_behind_abort


def test_a_device_that_needs_some_time_behind_an_abort() -> None:
    assert 0.003 < rest_of(build_node("request-behind-abort-lost", NODE_ID)) < 0.1


def test_one_frame_that_is_lost_says_nothing_of_aborts() -> None:
    node = LosesOne(NODE_ID, Server(ObjectDictionary(reference_entries(NODE_ID))))
    assert rest_of(node) == 0.0
