"""The Node of the PyPI package durand as a device.

As a program: python tests/fleet/durand_server.py --node-id 5 --can-channel vcan0
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import can
import durand  # type: ignore[import-untyped]
from durand.node import NodeCapabilities  # type: ignore[import-untyped]
from foreign_objects import IDENTITY, foreign_entries
from foreign_program import serve

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry

UNKNOWN_TYPES = frozenset(DataType) - {DataType(kind) for kind in durand.DatatypeEnum}
# durand brings these itself, with the values that the channel has.
SDO_PARAMETER = 0x1200


@dataclass(frozen=True, slots=True)
class DurandDevice:
    """A node of durand seen from its application."""

    dictionary: Any
    unknown_types: frozenset[DataType] = UNKNOWN_TYPES

    def read(self, mux: Multiplexer) -> bytes:
        """Return what an entry holds."""
        variable = self.dictionary.lookup(mux.index, mux.sub_index)
        return bytes(variable.pack(self.dictionary.read(mux.index, mux.sub_index)))

    def write(self, mux: Multiplexer, data: bytes) -> None:
        """Let an entry hold something else."""
        variable = self.dictionary.lookup(mux.index, mux.sub_index)
        self.dictionary.write(mux.index, mux.sub_index, variable.unpack(data))


def fill(dictionary: Any, node_id: int) -> None:
    """Give a node the objects that durand has types for, over those that it made itself."""
    identity = durand.Record(name="Identity Object")
    for mux, entry in foreign_entries(node_id, "durand Node", version("durand")).items():
        if entry.data_type in UNKNOWN_TYPES or mux.index == SDO_PARAMETER:
            continue
        if mux.index != IDENTITY.index:
            dictionary[mux.index] = _variable(mux, entry)
        elif mux.sub_index:
            identity[mux.sub_index] = _variable(mux, entry)
    dictionary[IDENTITY.index] = identity


def _variable(mux: Multiplexer, entry: Entry) -> Any:
    variable = durand.Variable(
        durand.DatatypeEnum(entry.data_type), entry.access.value, name=str(mux)
    )
    variable.value = variable.unpack(entry.value)
    return variable


@contextmanager
def durand_on_bus(bus: can.BusABC, node_id: int) -> Iterator[DurandDevice]:
    """Run a device on a bus, which is closed in the end."""
    network = durand.CANBusNetwork(bus)
    try:
        # It boots and becomes pre-operational by itself; a reader that is early finds the
        # objects as durand makes them.
        capabilities = NodeCapabilities(sdo_servers=1, rpdos=0, tpdos=0)
        node = durand.Node(network, node_id, capabilities=capabilities)
        fill(node.object_dictionary, node_id)
        yield DurandDevice(node.object_dictionary)
    finally:
        network.stop()
        bus.shutdown()


@contextmanager
def durand_device(channel: str, node_id: int) -> Iterator[DurandDevice]:
    """Run a device on a channel of the virtual bus."""
    with durand_on_bus(can.Bus(interface="virtual", channel=channel), node_id) as device:
        yield device


if __name__ == "__main__":
    serve("Run durand's Node as a CANopen device.", durand_on_bus)
