"""All faulty and unusual servers by name."""

import difflib

from conformance.device.listing import Listing
from conformance.faults import (
    aborts,
    block_choice_variants,
    block_download_aborts,
    block_download_checks,
    block_download_choices,
    block_downloads,
    block_leaks,
    block_lost_segments,
    block_requests,
    block_upload_choices,
    block_upload_ends,
    block_upload_frames,
    block_upload_losses,
    block_upload_sizes,
    block_upload_states,
    block_variants,
    capacities,
    channel_parameters,
    channel_traffic,
    channel_variants,
    communication,
    dictionary_reads,
    dictionary_variants,
    dictionary_writes,
    download_segments,
    downloads,
    early_variants,
    frames,
    gap_variants,
    histories,
    leaks,
    length_variants,
    narrow,
    nmt_states,
    part_variants,
    pervasive,
    pervasive_nodes,
    pervasive_states,
    server_timeouts,
    sick,
    states,
    storage,
    upload_access,
    upload_segments,
    uploads,
    variants,
)
from conformance.faults.described import described_device
from conformance.faults.dictionary import reference_device
from conformance.faults.registry import Deviation, assemble, combine, deviations_in
from conformance.sdo.layout import Multiplexer
from conformance.sdo.node import Node
from conformance.sdo.server import Server

_MODULES = (
    frames,
    uploads,
    upload_segments,
    upload_access,
    downloads,
    download_segments,
    states,
    leaks,
    aborts,
    block_downloads,
    block_lost_segments,
    block_download_checks,
    block_download_aborts,
    block_upload_ends,
    block_upload_losses,
    block_upload_sizes,
    block_upload_frames,
    block_upload_states,
    block_leaks,
    block_requests,
    narrow,
    block_download_choices,
    block_upload_choices,
    server_timeouts,
    channel_parameters,
    channel_traffic,
    nmt_states,
    communication,
    dictionary_reads,
    dictionary_writes,
    storage,
    capacities,
    histories,
    pervasive,
    pervasive_states,
    pervasive_nodes,
    sick,
    variants,
    part_variants,
    block_variants,
    block_choice_variants,
    gap_variants,
    early_variants,
    channel_variants,
    dictionary_variants,
    length_variants,
)


NONE: frozenset[Multiplexer] = frozenset()


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

    Two names with a + between them are a server that deviates in both ways. Raises UnknownServer
    with the nearest name.
    """
    if name is None:
        return None
    first, plus, second = name.partition("+")
    return combine(_known(first), _known(second)) if plus else _known(name)


def _known(name: str) -> Deviation:
    known = {deviation.name: deviation for deviation in all_deviations()}
    if name in known:
        return known[name]
    near = difflib.get_close_matches(name, known, n=1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    raise UnknownServer(
        f"There is no fault or variant called {name!r}.{hint} "
        "'python -m conformance faults' lists them."
    )


def build_node(
    name: str | None,
    node_id: int,
    listing: Listing | None = None,
    *,
    server_timeout: float | None = None,
) -> Node:
    """Return the reference node, or the fault or variant of that name.

    It is the built-in device, or the one that ``listing`` describes. ``server_timeout`` is the
    time in seconds after which it gives up a silent client, None for never. Raises UnknownServer.
    """
    deviation = find_deviation(name)
    lacking: frozenset[Multiplexer] = getattr(deviation and deviation.kind, "lacking", NONE)
    objects = described_device(listing) if listing else reference_device(node_id, lacking)
    if deviation is not None:
        return deviation.build(node_id, objects, server_timeout=server_timeout)
    return assemble(Node, Server, node_id, objects, server_timeout)


def described_node(name: str | None, node_id: int) -> Node:
    """Return the node that an EDS of the built-in device describes.

    That is an unusual one as it is, and what a faulty one ought to be. Raises UnknownServer.
    """
    deviation = find_deviation(name)
    return build_node(None if deviation is None or deviation.is_fault else name, node_id)
