"""A program that is a device, and a fragile one: ``fragile_server.py NODE-ID MEMORY OPTIONS``.

It keeps 2004h in the file MEMORY, as a device does in its flash, and ends when DEADh is written to
2002h. The options lead to the bus, as those of the suite do.
"""

import os
import sys
from pathlib import Path

from socketcand_bus import settings_of

from conformance.bus.opening import open_bus
from conformance.reference.dictionary import reference_device
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer

DEADLY = bytes.fromhex("2B022000ADDE0000")
KEPT = Multiplexer(0x2004)


class Fragile(Node):
    """Ends the process in the middle of a request."""

    def __init__(self, node_id: int, memory: Path) -> None:
        self.objects = reference_device(node_id)
        self.memory = memory
        super().__init__(node_id, Server(self.objects))
        if memory.exists():
            self.objects.find(KEPT).value = memory.read_bytes()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if self.is_addressed(frame) and frame.data == DEADLY:
            print("assertion failed: file server.c, line 42", flush=True)
            os._exit(70)
        answers = super().receive(frame)
        self.memory.write_bytes(self.objects.find(KEPT).value)
        return answers


if __name__ == "__main__":
    own, kept, *bus = sys.argv[1:]
    print(f"process {os.getpid()}", flush=True)
    NodeHost(open_bus(settings_of(tuple(bus))), Fragile(int(own), Path(kept))).run()
