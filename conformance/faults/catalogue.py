"""All faulty and unusual servers by name."""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from conformance.device.eds_listing import Listing
from conformance.faults import faulty as faulty_servers
from conformance.faults import unusual as unusual_servers
from conformance.faults.guarded import guarded
from conformance.faults.guards import Guard, guards
from conformance.faults.registry import NOTHING, Deviation, assemble, combine, deviations_in
from conformance.reference.described import described_device
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.nearest import meant


class UnknownServer(LookupError):
    """No faulty or unusual server has that name."""


def all_deviations() -> list[Deviation]:
    """Return the faulty servers and the unusual ones."""
    return list(_by_name().values())


def faults() -> list[Deviation]:
    """Return the servers that have to fail."""
    return [deviation for deviation in all_deviations() if deviation.is_fault]


def unusual() -> list[Deviation]:
    """Return the servers that have to pass."""
    return [deviation for deviation in all_deviations() if not deviation.is_fault]


def find_deviation(name: str | None) -> Deviation | None:
    """Return the faulty or unusual server of that name; None stands for the reference server.

    Two names with a + between them are a server that deviates in both ways; NAME@GUARD deviates
    only while the guard holds. Raises UnknownServer with the nearest name.
    """
    if name is None:
        return None
    first, plus, second = name.partition("+")
    return combine(_known(first), _known(second)) if plus else _known(name)


def _modules() -> Iterator[ModuleType]:
    for package in (faulty_servers, unusual_servers):
        for found in iter_modules(package.__path__, f"{package.__name__}."):
            yield import_module(found.name)


@cache
def _by_name() -> Mapping[str, Deviation]:
    return {deviation.name: deviation for deviation in deviations_in(_modules())}


def _known(name: str) -> Deviation:
    known = _by_name()
    name, at, condition = name.partition("@")
    if at and name in known:
        return guarded(known[name], _guard(condition))
    if name in known:
        return known[name]
    raise UnknownServer(
        f"There is no faulty or unusual server called {name!r}.{meant(name, known)} "
        "'conformance faults' lists them."
    )


def _guard(name: str) -> Guard:
    if name in guards():
        return guards()[name]
    raise UnknownServer(
        f"There is no guard called {name!r}.{meant(name, guards())} "
        "'conformance faults --guards' lists them."
    )


def build_node(
    name: str | None,
    node_id: int,
    listing: Listing | None = None,
    *,
    server_timeout: float | None = None,
) -> Node:
    """Return the reference node, or the faulty or unusual one of that name.

    It is the built-in device, or the one that ``listing`` describes. ``server_timeout`` is the
    time in seconds after which it gives up a silent client, None for never. Raises UnknownServer.
    """
    deviation = find_deviation(name)
    lacking = deviation.lacking if deviation else NOTHING
    objects = described_device(listing, node_id) if listing else reference_device(node_id, lacking)
    if deviation is not None:
        return deviation.build(node_id, objects, server_timeout=server_timeout)
    return assemble(Node, Server, node_id, objects, server_timeout)


def described_node(name: str | None, node_id: int) -> Node:
    """Return the node that an EDS of the built-in device describes.

    That is an unusual one as it is, and what a faulty one ought to be. Raises UnknownServer.
    """
    deviation = find_deviation(name)
    return build_node(None if deviation is None or deviation.is_fault else name, node_id)
