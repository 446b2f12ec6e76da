"""The registry of faulty and unusual servers: each a name, a sentence, and how to build it."""

import difflib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from conformance.faults.device import reference_device
from conformance.sdo.node import Node
from conformance.sdo.objects import ObjectDictionary
from conformance.sdo.server import Server


class Build(Protocol):
    """Builds a node from a node-ID and an object dictionary."""

    def __call__(self, node_id: int, objects: ObjectDictionary) -> Node:
        """Return the node."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A named way in which a server can be wrong.

    ``defect_class`` is the letter of the family of defects; ``caught_by`` the beginning of the id
    of a case that says what is wrong. A ``soft`` fault breaks a SHOULD only.
    """

    name: str
    defect_class: str
    caught_by: str
    sentence: str
    build: Build
    soft: bool = False


@dataclass(frozen=True, slots=True)
class Variant:
    """A named way in which a server can be unusual and right. ``soft``: it misses a SHOULD."""

    name: str
    sentence: str
    build: Build
    soft: bool = False


class UnknownServer(LookupError):
    """No fault or variant has that name."""


FAULTS: dict[str, Fault] = {}
VARIANTS: dict[str, Variant] = {}


def fault(
    name: str, defect_class: str, caught_by: str, *, soft: bool = False
) -> Callable[[type[Server] | type[Node]], type[Server] | type[Node]]:
    """Register a faulty server or node; its docstring says what is wrong with it."""

    def register(kind: type[Server] | type[Node]) -> type[Server] | type[Node]:
        _check_new(name)
        sentence = (kind.__doc__ or "").strip()
        FAULTS[name] = Fault(name, defect_class, caught_by, sentence, _builder(kind), soft)
        return kind

    return register


def variant(
    name: str, *, soft: bool = False
) -> Callable[[type[Server] | type[Node]], type[Server] | type[Node]]:
    """Register an unusual server or node; its docstring says what is unusual about it."""

    def register(kind: type[Server] | type[Node]) -> type[Server] | type[Node]:
        _check_new(name)
        VARIANTS[name] = Variant(name, (kind.__doc__ or "").strip(), _builder(kind), soft)
        return kind

    return register


def build_node(name: str | None, node_id: int) -> Node:
    """Return the reference node, or the fault or variant of that name, on the built-in device.

    Raises UnknownServer with the nearest name.
    """
    if name is None:
        return Node(node_id, Server(reference_device(node_id)))
    found = FAULTS.get(name) or VARIANTS.get(name)
    if found is None:
        near = difflib.get_close_matches(name, [*FAULTS, *VARIANTS], n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        raise UnknownServer(
            f"There is no fault or variant called {name!r}.{hint} "
            "'python -m conformance faults' lists them."
        )
    return found.build(node_id, reference_device(node_id))


def _check_new(name: str) -> None:
    if name in FAULTS or name in VARIANTS:
        raise ValueError(f"{name} is registered twice")


def _builder(kind: type[Server] | type[Node]) -> Build:
    def build(node_id: int, objects: ObjectDictionary) -> Node:
        if issubclass(kind, Server):
            return Node(node_id, kind(objects))
        return kind(node_id, Server(objects))

    return build
