"""Nodes that store parameters and load their defaults in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About
from conformance.reference.dictionary import CLIENT
from conformance.reference.node import Node
from conformance.reference.segmented_server import SegmentedServer
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry
from conformance.sdo.storage_commands import APPLICATION_PART, LOAD_ALL, SAVE_ALL

unusual = partial(registry.unusual, about=About.OBJECTS)
STORED = {
    Multiplexer(0x2002): b"\x02\x01",
    Multiplexer(0x2004): b"\4\3\2\1",
    Multiplexer(0x2010): b"stored",
    Multiplexer(0x2100, 1): b"\x21",
    Multiplexer(CLIENT, 3): b"\x07",
}


@unusual("configured-and-not-stored")
class NotStored(Node):
    """Was configured before the run, and keeps that until it is reset."""

    configured = False

    def start(self) -> list[CanFrame]:
        """Be configured when it is switched on: its EDS knows nothing of it."""
        if not self.configured:
            self.configured = True
            for mux, value in STORED.items():
                if (entry := self.objects.get(mux)) is not None:
                    entry.value = value
            self.keep()
        return super().start()

    def keep(self) -> None:
        """Store nothing."""


@unusual("parameters-stored")
class ParametersStored(NotStored):
    """Was configured before the run, and keeps that without power."""

    def keep(self) -> None:
        self.save()


@unusual("defaults-loaded-at-once")
class LoadedAtOnce(ParametersStored):
    """Has its defaults as soon as it has confirmed "load"."""

    def load_defaults(self) -> None:
        super().load_defaults()
        self.restore(communication_only=False)


@unusual("stores-by-itself")
class StoresByItself(Node):
    """Stores at once what is written from 2000h on, and has no commands for that or defaults."""

    by_itself = b"\2\0\0\0"

    def __init__(
        self,
        node_id: int,
        server: SegmentedServer,
        *further: SegmentedServer,
        server_timeout: float | None = None,
    ) -> None:
        super().__init__(node_id, server, *further, server_timeout=server_timeout)
        for command, value in ((SAVE_ALL, self.by_itself), (LOAD_ALL, bytes(4))):
            for sub_index in range(1, APPLICATION_PART + 1):
                mux = Multiplexer(command.index, sub_index)
                self.objects.add({mux: Entry(value, DataType.UNSIGNED32, Access.RO)})

    def restore(self, *, communication_only: bool) -> None:
        super().restore(communication_only=True)


@unusual("stores-all-by-itself")
class StoresAllByItself(StoresByItself):
    """Stores at once what is written to any object, as 1010h says."""

    def restore(self, *, communication_only: bool) -> None:
        """Lead to what was written."""


@unusual("stores-all-unsaid", soft=True)
class StoresAllUnsaid(StoresAllByItself):
    """Stores at once what is written to any object; 1010h says that it stores nothing."""

    by_itself = bytes(4)
