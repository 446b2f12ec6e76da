"""The LocalNode of the PyPI package canopen as a device.

As a program: python tests/fleet/canopen_server.py --node-id 5 --can-channel vcan0
"""

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, cast

import can
import canopen
from canopen.objectdictionary import ODRecord, ODVariable
from foreign_objects import foreign_entries
from foreign_program import serve

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry

HEARTBEAT_TIME = Multiplexer(0x1017)
# Seconds that the receiving thread may take to see that it shall end.
NOTIFIER_CYCLE = 0.05


@dataclass(frozen=True, slots=True)
class CanopenDevice:
    """A LocalNode seen from its application."""

    node: canopen.LocalNode
    unknown_types: frozenset[DataType] = frozenset()

    def read(self, mux: Multiplexer) -> bytes:
        """Return what an entry holds."""
        return bytes(self.node.get_data(mux.index, mux.sub_index))

    def write(self, mux: Multiplexer, data: bytes) -> None:
        """Let an entry hold something else."""
        self.node.set_data(mux.index, mux.sub_index, data)


def object_dictionary(node_id: int) -> canopen.ObjectDictionary:
    """Build the object dictionary; the values are defaults, as if they came from an EDS."""
    entries = foreign_entries(node_id, "canopen LocalNode", version("canopen"))
    # LocalNode reads its heartbeat time when it becomes pre-operational.
    entries[HEARTBEAT_TIME] = Entry(bytes(2), DataType.UNSIGNED16, Access.RW)
    by_index: dict[int, list[ODVariable]] = defaultdict(list)
    for mux, entry in entries.items():
        by_index[mux.index].append(_variable(mux, entry))
    dictionary = canopen.ObjectDictionary()  # type: ignore[no-untyped-call]
    for index, variables in by_index.items():
        dictionary.add_object(variables[0] if len(variables) == 1 else _record(index, variables))
    return dictionary


def _variable(mux: Multiplexer, entry: Entry) -> ODVariable:
    variable = ODVariable(str(mux), mux.index, mux.sub_index)
    variable.data_type = int(entry.data_type)
    variable.access_type = entry.access.value
    # Declared as a number, but encode_raw() takes bytes too.
    cast(Any, variable).default = entry.value
    return variable


def _record(index: int, variables: list[ODVariable]) -> ODRecord:
    record = ODRecord(f"{index:04X}h", index)
    for variable in variables:
        record.add_member(variable)
    return record


@contextmanager
def canopen_on_bus(bus: can.BusABC, node_id: int) -> Iterator[CanopenDevice]:
    """Run a device on a bus, which is closed in the end."""
    with canopen.Network(bus) as network:
        network.NOTIFIER_CYCLE = NOTIFIER_CYCLE
        node = network.create_node(node_id, object_dictionary(node_id))
        network.connect()
        node.nmt.state = "INITIALISING"
        node.nmt.state = "PRE-OPERATIONAL"
        yield CanopenDevice(node)


@contextmanager
def canopen_device(channel: str, node_id: int) -> Iterator[CanopenDevice]:
    """Run a device on a channel of the virtual bus."""
    with canopen_on_bus(can.Bus(interface="virtual", channel=channel), node_id) as device:
        yield device


if __name__ == "__main__":
    serve("Run canopen's LocalNode as a CANopen device.", canopen_on_bus)
