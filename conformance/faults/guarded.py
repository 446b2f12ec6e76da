"""Guarded faults: a fault of the catalogue that shows only under a condition, as in firmware.

A guarded server has the methods of the faulty one while its guard holds, and those of the reference
server otherwise. What both work on, transfers and objects, is one.
"""

from dataclasses import replace
from functools import wraps
from inspect import getattr_static
from types import FunctionType
from typing import Any

from conformance.faults.guards import Guard
from conformance.faults.registry import Deviation, changes
from conformance.faults.situation import Watch
from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame


class WatchedNode(Node):
    """Decides before each request whether the guard holds, for itself and for its servers."""

    guard: Guard
    holds = False

    def __init__(
        self, node_id: int, *servers: SegmentedServer, server_timeout: float | None = None
    ) -> None:
        """Build the node; its servers are right until a request comes."""
        self.watch = Watch()
        super().__init__(node_id, *servers, server_timeout=server_timeout)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Look at the situation, then react.

        A frame of no channel is looked at as if it were on the default one, and not remembered.
        """
        channel = Node.channel_of(self, frame)
        number = self.channels.index(channel) if channel else 0
        situation = self.watch.situation(self, number, frame.data, counts=channel is not None)
        self.decide(self.guard.holds(situation))
        answers = super().receive(frame)
        if channel is not None:
            self.watch.answered(number, answers)
        self.watch.looked_at(self)
        return answers

    def decide(self, holds: bool) -> None:
        """Switch all that may be switched."""
        for part in (self, *(channel.server for channel in self.channels)):
            part.__dict__["holds"] = holds


def guarded(fault: Deviation, guard: Guard) -> Deviation:
    """Return a fault that shows only while a guard holds."""
    name = f"{fault.name}@{guard.name}"
    node, server = Node, fault.server
    if issubclass(fault.kind, SegmentedServer):
        server = fault.kind
    else:
        node = fault.kind
    right = Server if issubclass(server, Server) else SegmentedServer
    members = {"guard": guard}
    return replace(
        fault,
        name=name,
        kind=type(name, (WatchedNode, _switched(node, Node)), members),
        server=_switched(server, right),
        sentence=f"{fault.sentence} Only {guard.sentence}.",
    )


def _switched(faulty: type[Any], right: type[Any]) -> type[Any]:
    """Return a class that is the faulty one while it ``holds``, and otherwise the right one.

    What the right one has not is only called by what it has.
    """
    if faulty is right:
        return right
    members: dict[str, Any] = {"holds": False}
    for name in changes(faulty).keys() - {"__init__"}:
        wrong, usual = getattr_static(faulty, name), getattr_static(right, name, None)
        if isinstance(wrong, FunctionType) and isinstance(usual, FunctionType):
            members[name] = _either(wrong, usual)
        elif isinstance(wrong, property) and isinstance(usual, property):
            members[name] = property(_either(wrong.fget, usual.fget))
    return type(faulty.__name__, (faulty,), members)


def _either(wrong: Any, usual: Any) -> Any:
    @wraps(usual)
    def choose(self: Any, *arguments: Any, **named: Any) -> Any:
        return (wrong if self.holds else usual)(self, *arguments, **named)

    return choose
