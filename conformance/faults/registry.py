"""What a faulty or an unusual server is: a class, and what goes with it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from types import FunctionType, ModuleType
from typing import TypeVar

from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.reference.server import Server
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import ObjectDictionary

Kind = type[SegmentedServer] | type[Node]
Base = TypeVar("Base", SegmentedServer, Node)
ATTRIBUTE = "conformance_deviations"
NOTHING: frozenset[Multiplexer] = frozenset()
# The channels that the built-in device has beside the default one: 1201h and 1202h.
FURTHER_CHANNELS = 2


class Defect(StrEnum):
    """The kinds of defects that servers in the field have."""

    UNUSED_COUNT = "count of unused bytes"
    LAST_FLAG = "mark of the last segment"
    LEAK = "left by what was before"
    LOST_SEGMENTS = "lost segments"
    ABORT = "aborts"
    BLOCK_SIZE = "block size"
    FIELD_WIDTH = "width of a field"
    ACCESS_OR_SIZE = "access or size"
    CRC = "CRC"
    TIMING = "time"
    FRAME_SHAPE = "shape of frames"
    BACK_TO_BACK = "frames back to back"
    ZERO_LENGTH = "values without data"
    ROBUSTNESS = "robustness"
    STATE = "state of a transfer"


class About(StrEnum):
    """What there is to see of a deviation, and where."""

    TRANSFERS = "single transfers, on any channel"
    LENGTHS = "how long values are"
    OBJECTS = "the object dictionary, and what is stored of it"
    CHANNELS = "several channels, and their parameters"
    NMT = "NMT states, and what is sent unasked"
    TIME = "how long something takes"
    HISTORY = "many transfers one after another"


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """A named way in which a server differs from the reference server.

    A fault is wrong: ``defect`` says in what, and ``caught_by`` how the ids of cases begin that
    have to fail; the first says what is wrong, further ones are there because no other fault fails
    them. An unusual server is right; it has neither.
    """

    name: str
    kind: Kind
    sentence: str
    defect: Defect | None = None
    caught_by: tuple[str, ...] = ()
    about: About = About.TRANSFERS
    soft: bool = False
    """It misses a SHOULD, and no MUST."""
    timed: bool = False
    """It shows where the server's own time-out is declared, and nowhere else."""
    thorough: bool = False
    """It shows in a thorough run, and else by chance."""
    lacking: frozenset[Multiplexer] = NOTHING
    """Entries of the built-in device that it is without."""
    server: type[SegmentedServer] = Server
    """What serves the channels of a ``kind`` that is a node."""

    @property
    def is_fault(self) -> bool:
        """Whether a device like that has to fail."""
        return self.defect is not None

    def build(
        self, node_id: int, objects: ObjectDictionary, *, server_timeout: float | None = None
    ) -> Node:
        """Return a node that deviates in this way; ``server_timeout`` is in seconds."""
        if issubclass(self.kind, SegmentedServer):
            return assemble(Node, self.kind, node_id, objects, server_timeout)
        return assemble(self.kind, self.server, node_id, objects, server_timeout)


def combine(first: Deviation, second: Deviation) -> Deviation:
    """Return what deviates in both ways.

    Where both change one reaction the first comes first, and may leave it to the second. Two
    unusual servers miss a SHOULD together where either does; a fault beside another misses no more
    than that only where both do.
    """
    pair = (first, second)
    name = "+".join(each.name for each in pair)
    nodes = [each.kind for each in pair if issubclass(each.kind, Node)]
    servers = _servers(pair)
    soft = [each.soft for each in pair]
    return replace(
        first,
        name=name,
        kind=_joined(name, nodes) if nodes else _joined(name, servers),
        sentence=f"{first.sentence} {second.sentence}",
        soft=all(soft) if first.is_fault or second.is_fault else any(soft),
        timed=first.timed or second.timed,
        thorough=first.thorough and second.thorough,
        lacking=first.lacking | second.lacking,
        server=_joined(name, servers) if nodes and servers else Server,
    )


def acts_beside(first: Deviation, second: Deviation) -> bool:
    """Say whether each does all that it is named for where both are one server.

    Not where both have another value of one attribute, where both change one reaction and the first
    does not go on to the second, where the one is a kind of the other, or where the one adds block
    transfers that the other lacks.
    """
    pair = (first, second)
    nodes = [each.kind for each in pair if issubclass(each.kind, Node)]
    servers = _servers(pair)
    lacks_blocks = any(not issubclass(kind, Server) for kind in servers)
    if lacks_blocks and len(servers) > 1:
        return False
    return all(_act_together(*kinds) for kinds in (nodes, servers) if len(kinds) > 1)


def _servers(pair: Iterable[Deviation]) -> list[type[SegmentedServer]]:
    """Return what serves the channels of two deviations, where it is not the reference server."""
    kinds = [each.kind if issubclass(each.kind, SegmentedServer) else each.server for each in pair]
    return [kind for kind in kinds if kind is not Server]


def _act_together(first: type, second: type) -> bool:
    if issubclass(first, second) or issubclass(second, first):
        return False
    ours, others = changes(first), changes(second)
    return all(
        ours[name] is others[name] or _goes_on(ours[name]) for name in ours.keys() & others.keys()
    )


def changes(kind: type) -> dict[str, object]:
    """Return what a class has that the reference server has not, by name."""
    own = [each for each in kind.__mro__ if not _is_reference(each)]
    return {
        name: value
        for each in reversed(own)
        for name, value in vars(each).items()
        if name == "__init__" or not name.startswith(("__", ATTRIBUTE))
    }


def _is_reference(kind: type) -> bool:
    """Say whether a class is of the reference server, or of what all classes share."""
    return kind in (*Server.__mro__, *Node.__mro__)


def _goes_on(change: object) -> bool:
    """Say whether a reaction goes on to that of the class behind it."""
    function = change.fget if isinstance(change, property) else change
    return isinstance(function, FunctionType) and "super" in function.__code__.co_names


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
    name: str,
    defect: Defect,
    *caught_by: str,
    about: About = About.TRANSFERS,
    soft: bool = False,
    timed: bool = False,
    thorough: bool = False,
) -> Callable[[Kind], Kind]:
    """Mark a faulty server or node; its docstring says what is wrong with it."""

    def mark(kind: Kind) -> Kind:
        return _marked(
            Deviation(
                name=name,
                kind=kind,
                sentence=_sentence(kind),
                defect=defect,
                caught_by=caught_by,
                about=about,
                soft=soft,
                timed=timed,
                thorough=thorough,
            )
        )

    return mark


def unusual(
    name: str,
    *,
    about: About = About.TRANSFERS,
    soft: bool = False,
    timed: bool = False,
    lacking: frozenset[Multiplexer] = NOTHING,
    server: type[SegmentedServer] = Server,
) -> Callable[[Kind], Kind]:
    """Mark an unusual server or node; its docstring says what is unusual about it.

    ``server`` is what serves the channels of a node.
    """

    def mark(kind: Kind) -> Kind:
        return _marked(
            Deviation(
                name=name,
                kind=kind,
                sentence=_sentence(kind),
                about=about,
                soft=soft,
                timed=timed,
                lacking=lacking,
                server=server,
            )
        )

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


def _marked(deviation: Deviation) -> Kind:
    setattr(deviation.kind, ATTRIBUTE, deviation)
    return deviation.kind


def _joined(name: str, kinds: Sequence[type[Base]]) -> type[Base]:
    return kinds[0] if len(kinds) == 1 else type(name, tuple(kinds), {})


def _sentence(kind: Kind) -> str:
    return " ".join((kind.__doc__ or "").split())
