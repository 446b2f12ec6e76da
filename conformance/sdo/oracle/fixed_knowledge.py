"""What is known of any device: the objects that CiA 301 defines, and nothing of all others."""

from dataclasses import dataclass
from functools import cache

from conformance.sdo.fixed_objects import FixedEntry, entry_at, is_forbidden
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access
from conformance.sdo.oracle.knowledge import Facts, Knowledge, Presence
from conformance.sdo.rules import CONSTANT, NOT_REFUSED


@dataclass(frozen=True, slots=True)
class FixedKnowledge(Knowledge):
    """A device of which there is no description."""

    def of(self, mux: Multiplexer) -> Facts:
        """Return what CiA 301 says of an object; whether the device has it is open."""
        return _facts(mux)


@cache
def _facts(mux: Multiplexer) -> Facts:
    entry = entry_at(mux)
    if entry is None:
        return Facts(Presence.FORBIDDEN) if is_forbidden(mux) else Facts()
    return Facts(
        access=_access(entry),
        data_type=entry.data_type,
        steady=entry.access is Access.CONST,
        reads_by=CONSTANT,
        read_only=entry.read_only,
        takes=entry.takes,
        takes_by=entry.takes_by or NOT_REFUSED,
    )


def _access(entry: FixedEntry) -> Access | None:
    """Return the access if it is certain: what may be written in a device need not be in others."""
    return None if entry.access is Access.RW else entry.access
