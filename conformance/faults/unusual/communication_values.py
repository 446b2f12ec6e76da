"""Nodes that are right in values of the communication in their own way."""

from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About
from conformance.reference.communication import EMERGENCY, RECEIVED, SENT, SYNC, TIME
from conformance.reference.communication_values import CONSUMED, COUNTER_OVERFLOW
from conformance.reference.dictionary import ERROR_CODE
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import Check, CheckedEntry
from conformance.sdo.cob_id import CobId
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, Refusal

unusual = partial(registry.unusual, about=About.OBJECTS)
COMMUNICATION_ERROR = b"\x10\x81"
COB_IDS = (SYNC, TIME, EMERGENCY, Multiplexer(RECEIVED, 1), Multiplexer(SENT, 1))


class _Refuses(AlteredNode):
    """Refuses the values of some entries with other codes."""

    entries: tuple[Multiplexer, ...] = ()

    def alter(self) -> None:
        for mux in self.entries:
            entry = self.objects.get(mux)
            if isinstance(entry, CheckedEntry):
                entry.check = partial(self.check, entry.check)

    def check(self, right: Check, old: bytes, new: bytes) -> None:
        """Refuse what a ``right`` server refuses."""
        try:
            right(old, new)
        except Refusal as refusal:
            raise Refusal(self.code(refusal.code, new)) from None

    def code(self, code: AbortCode, new: bytes) -> AbortCode:
        """Return the code for a value that is refused."""
        return code


@unusual("restricted-identifiers-out-of-range")
class RestrictedOutOfRange(_Refuses):
    """Says "too low" or "too high" for CAN-IDs that are kept for other services."""

    entries = COB_IDS

    def code(self, code: AbortCode, new: bytes) -> AbortCode:
        wanted = CobId.from_bytes(new)
        if not wanted.is_restricted:
            return code
        return AbortCode.VALUE_TOO_LOW if wanted.can_id < 0x80 else AbortCode.VALUE_TOO_HIGH


@unusual("sync-counter-general-error")
class CounterGeneralError(_Refuses):
    """Says "general error" for another SYNC counter (1019h) while there is a period (1006h)."""

    entries = (COUNTER_OVERFLOW,)

    def code(self, code: AbortCode, new: bytes) -> AbortCode:
        return AbortCode.GENERAL_ERROR if code is AbortCode.DEVICE_STATE else code


@unusual("consumed-nodes-constant")
class ConsumedConstant(AlteredNode):
    """Awaits the heartbeats of nodes that cannot be configured (1016h)."""

    def alter(self) -> None:
        for mux, entry in self.objects.items():
            if mux.index == CONSUMED:
                entry.access = Access.CONST


@unusual("error-from-the-start")
class ErrorFromTheStart(AlteredNode):
    """Has an error when it has booted, and tells of it."""

    def alter(self) -> None:
        self.objects.find(ERROR_CODE).value = COMMUNICATION_ERROR
        self.defaults = self.power_on = self.present()
