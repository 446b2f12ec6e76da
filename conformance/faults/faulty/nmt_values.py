"""Nodes that treat their values wrongly when the communication is reset."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.reference.node import Node

fault = partial(registry.fault, about=About.NMT)


@fault("nmt-reset-communication-keeps-values", Defect.STATE, "nmt.reset-restores")
class ResetKeeps(Node):
    """Restores its power-on values in a reset of the node only."""

    def restore(self, *, communication_only: bool) -> None:
        if not communication_only:
            super().restore(communication_only=False)


@fault("nmt-reset-communication-of-all", Defect.STATE, "nmt.reset-keeps-application")
class ResetOfAll(Node):
    """Restores all power-on values in a reset of the communication."""

    def restore(self, *, communication_only: bool) -> None:
        super().restore(communication_only=False)
