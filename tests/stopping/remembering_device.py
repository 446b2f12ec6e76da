"""A device that keeps its values in a file: ``remembering_device.py FILE INTERFACE CHANNEL``.

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

NODE_ID = 5


class Remembering(Node):
    """Writes its file whenever a value has changed."""

    def __init__(self, memory: Path) -> None:
        self.entries = reference_entries(NODE_ID)
        self.memory = memory
        self.kept: dict[str, str] = {}
        super().__init__(NODE_ID, Server(ObjectDictionary(self.entries)))
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
    memory, interface, channel = sys.argv[1:]
    NodeHost(open_bus(BusSettings(interface, channel)), Remembering(Path(memory))).run()
