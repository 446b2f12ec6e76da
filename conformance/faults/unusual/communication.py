"""Nodes that are right in their objects for SYNC, TIME, EMCY and PDOs in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About
from conformance.reference.communication import RECEIVED, SENT
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry
from conformance.sdo.pdos import MAPPING_OF, MULTIPLEXED

unusual = partial(registry.unusual, about=About.OBJECTS)


@unusual("pdo-compatibility-entry")
class CompatibilityEntry(AlteredNode):
    """Has sub-index 04h of 1800h, as DS-301 4.02 has it, and in its EDS."""

    def alter(self) -> None:
        self.objects.add({Multiplexer(SENT, 4): Entry(b"\0", DataType.UNSIGNED8)})
        count = self.objects.find(Multiplexer(SENT))
        count.value = max(count.value, b"\4")
        self.defaults = self.power_on = self.present()


@unusual("pdo-mapping-fixed")
class FixedMapping(AlteredNode):
    """Maps an object for ever, and lists places for more of them in its EDS."""

    def alter(self) -> None:
        for index in (RECEIVED + MAPPING_OF, SENT + MAPPING_OF):
            for mux, entry in self.objects.items():
                if mux.index == index:
                    entry.access = Access.CONST


class _Multiplexed(FixedMapping):
    """Has multiplexed PDOs of one kind."""

    kind = 0

    def alter(self) -> None:
        super().alter()
        for index in (RECEIVED + MAPPING_OF, SENT + MAPPING_OF):
            self.objects.find(Multiplexer(index)).value = bytes([self.kind])
        self.defaults = self.power_on = self.present()


@unusual("pdo-multiplexed-by-list")
class MultiplexedByList(_Multiplexed):
    """Has multiplexed PDOs (MPDO) of source addressing: FEh in the place of a number of entries."""

    kind = MULTIPLEXED[0]


@unusual("pdo-multiplexed-by-address")
class MultiplexedByAddress(_Multiplexed):
    """Has multiplexed PDOs (MPDO) of destination addressing: FFh in the place of a number."""

    kind = MULTIPLEXED[1]
