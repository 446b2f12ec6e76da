"""What a faulty or an unusual server is: a class, and the name and sentence that go with it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from types import ModuleType
from typing import TypeVar

from conformance.sdo.node import Node
from conformance.sdo.objects import ObjectDictionary
from conformance.sdo.segmented_server import SegmentedServer
from conformance.sdo.server import Server

Kind = type[SegmentedServer] | type[Node]
Base = TypeVar("Base", SegmentedServer, Node)
ATTRIBUTE = "conformance_deviations"
# The channels that the built-in device has beside the default one: 1201h and 1202h.
FURTHER_CHANNELS = 2


class DefectClass(StrEnum):
    """The families of defects that servers in the field have."""

    UNUSED_COUNT = "A"
    LAST_FLAG = "B"
    LEAK = "C"
    LOST_SEGMENTS = "D"
    ABORT = "E"
    BLOCK_SIZE = "F"
    FIELD_WIDTH = "G"
    ACCESS_OR_SIZE = "H"
    CRC = "I"
    TIMING = "J"
    FRAME_SHAPE = "K"
    BACK_TO_BACK = "L"
    ZERO_LENGTH = "M"
    ROBUSTNESS = "N"
    STATE = "state"


@dataclass(frozen=True, slots=True)
class Deviation:
    """A named way in which a server differs from the reference server.

    A fault is wrong: ``defect_class`` is its family, ``caught_by`` the beginning of the id of a
    case that says what is wrong. A variant is unusual and right; both are empty. What is ``soft``
    misses a SHOULD and no MUST. ``server`` is the server of a ``kind`` that is a node.
    """

    name: str
    kind: Kind
    sentence: str
    defect_class: DefectClass | None = None
    caught_by: str = ""
    soft: bool = False
    server: type[SegmentedServer] = Server

    @property
    def is_fault(self) -> bool:
        """Whether a device like that has to fail."""
        return self.defect_class is not None

    def build(
        self, node_id: int, objects: ObjectDictionary, *, server_timeout: float | None = None
    ) -> Node:
        """Return a node that deviates in this way; ``server_timeout`` is in seconds."""
        if issubclass(self.kind, SegmentedServer):
            return assemble(Node, self.kind, node_id, objects, server_timeout)
        return assemble(self.kind, self.server, node_id, objects, server_timeout)


def combine(first: Deviation, second: Deviation) -> Deviation:
    """Return what deviates in both ways.

    Where both change one reaction the first comes first, and may leave it to the second.
    """
    pair = (first, second)
    name = "+".join(each.name for each in pair)
    nodes = [each.kind for each in pair if issubclass(each.kind, Node)]
    servers = [each.kind for each in pair if issubclass(each.kind, SegmentedServer)]
    return replace(
        first,
        name=name,
        kind=_joined(name, nodes) if nodes else _joined(name, servers),
        sentence=f"{first.sentence} {second.sentence}",
        soft=first.soft and second.soft,
        server=_joined(name, servers) if nodes and servers else Server,
    )


def assemble(
    node: type[Node],
    server: type[SegmentedServer],
    node_id: int,
    objects: ObjectDictionary,
    server_timeout: float | None,
) -> Node:
    """Return a node with a server for each of its channels, all on one object dictionary."""
    servers = [server(objects) for _ in range(1 + FURTHER_CHANNELS)]
    return node(node_id, *servers, server_timeout=server_timeout)


def fault(
    name: str, defect_class: DefectClass, caught_by: str, *, soft: bool = False
) -> Callable[[Kind], Kind]:
    """Mark a faulty server or node; its docstring says what is wrong with it."""

    def mark(kind: Kind) -> Kind:
        deviation = Deviation(name, kind, _sentence(kind), defect_class, caught_by, soft)
        setattr(kind, ATTRIBUTE, deviation)
        return kind

    return mark


def variant(name: str, *, soft: bool = False) -> Callable[[Kind], Kind]:
    """Mark an unusual server or node; its docstring says what is unusual about it."""

    def mark(kind: Kind) -> Kind:
        setattr(kind, ATTRIBUTE, Deviation(name, kind, _sentence(kind), soft=soft))
        return kind

    return mark


def deviations_in(modules: Iterable[ModuleType]) -> list[Deviation]:
    """Return what the modules define, in the order of their source.

    Raises ValueError when two have one name.
    """
    found: dict[str, Deviation] = {}
    for module in modules:
        for kind in vars(module).values():
            deviation = vars(kind).get(ATTRIBUTE) if isinstance(kind, type) else None
            if deviation is None or kind.__module__ != module.__name__:
                continue
            if deviation.name in found:
                raise ValueError(f"two deviations are called {deviation.name}")
            found[deviation.name] = deviation
    return list(found.values())


def _joined(name: str, kinds: Sequence[type[Base]]) -> type[Base]:
    return kinds[0] if len(kinds) == 1 else type(name, tuple(kinds), {})


def _sentence(kind: Kind) -> str:
    return " ".join((kind.__doc__ or "").split())
