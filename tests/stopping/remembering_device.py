"""A device that keeps its values: ``remembering_device.py FOLDER NODE-ID INTERFACE CHANNEL``.

It stands for one with a flash: what it held last can be read when it is gone.
"""

import json
import os
import sys
from pathlib import Path

from conformance.bus.opening import BusSettings, open_bus
from conformance.reference.built_in_device import reference_entries
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.objects import ObjectDictionary


def memory_of(folder: Path, node_id: int) -> Path:
    """Return the file in which a device keeps its values."""
    return folder / f"memory-{node_id}.json"


class Remembering(Node):
    """Writes its file whenever a value has changed."""

    def __init__(self, memory: Path, node_id: int) -> None:
        self.entries = reference_entries(node_id)
        self.memory = memory
        self.kept: dict[str, str] = {}
        super().__init__(node_id, Server(ObjectDictionary(self.entries)))
        self.keep()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        self.keep()
        return answers

    def keep(self) -> None:
        """Write the values, whole or not at all."""
        values = {str(mux): entry.value.hex() for mux, entry in self.entries.items()}
        if values != self.kept:
            self.kept = values
            beside = self.memory.with_suffix(".new")
            beside.write_text(json.dumps({"process": os.getpid(), "values": values}))
            beside.replace(self.memory)


if __name__ == "__main__":
    folder, node_id, interface, channel = sys.argv[1:]
    device = Remembering(memory_of(Path(folder), int(node_id)), int(node_id))
    NodeHost(open_bus(BusSettings(interface, channel)), device).run()
