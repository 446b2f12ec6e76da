"""All faulty and unusual servers by name."""

import difflib

from conformance.faults import (
    aborts,
    block_download_aborts,
    block_download_checks,
    block_downloads,
    block_leaks,
    block_lost_segments,
    block_requests,
    block_upload_frames,
    block_upload_states,
    block_uploads,
    block_variants,
    download_segments,
    downloads,
    frames,
    histories,
    leaks,
    narrow,
    states,
    uploads,
    variants,
)
from conformance.faults.device import reference_device
from conformance.faults.registry import Deviation, deviations_in
from conformance.sdo.node import Node
from conformance.sdo.server import Server

_MODULES = (
    frames,
    uploads,
    downloads,
    download_segments,
    states,
    leaks,
    aborts,
    block_downloads,
    block_lost_segments,
    block_download_checks,
    block_download_aborts,
    block_uploads,
    block_upload_frames,
    block_upload_states,
    block_leaks,
    block_requests,
    narrow,
    histories,
    variants,
    block_variants,
)


class UnknownServer(LookupError):
    """No fault or variant has that name."""


def all_deviations() -> list[Deviation]:
    """Return faults and variants."""
    return deviations_in(_MODULES)


def faults() -> list[Deviation]:
    """Return the servers that have to fail."""
    return [deviation for deviation in all_deviations() if deviation.is_fault]


def unusual() -> list[Deviation]:
    """Return the servers that have to pass."""
    return [deviation for deviation in all_deviations() if not deviation.is_fault]


def find_deviation(name: str | None) -> Deviation | None:
    """Return the fault or variant of that name; None stands for the reference server.

    Raises UnknownServer with the nearest name.
    """
    if name is None:
        return None
    known = {deviation.name: deviation for deviation in all_deviations()}
    if name in known:
        return known[name]
    near = difflib.get_close_matches(name, known, n=1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    raise UnknownServer(
        f"There is no fault or variant called {name!r}.{hint} "
        "'python -m conformance faults' lists them."
    )


def build_node(name: str | None, node_id: int) -> Node:
    """Return the reference node, or the fault or variant of that name, on the built-in device.

    Raises UnknownServer.
    """
    objects = reference_device(node_id)
    deviation = find_deviation(name)
    return deviation.build(node_id, objects) if deviation else Node(node_id, Server(objects))
