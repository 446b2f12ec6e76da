"""What a device lacks, for cases on how that is refused: found out once, and then known."""

from conformance.device.not_testable import NotTestable
from conformance.device.safety import IDENTITY
from conformance.dialogue.transfers import EXISTS, Transfers
from conformance.sdo.checks import ServerAborted
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import MISSING_REFUSED, Violation
from conformance.sdo.rules.idle import SUB_INDEX_MISSING

# Indices that CiA 301 and the common profiles leave free and that no permission guards, and
# sub-indices that few objects reach.
MISSING_INDICES = (0x0F00, 0x5FF7, 0xBFF7)
MISSING_SUB_INDICES = (0xFE, 0xFD, 0x7F)
# Below it there are data types, and what is reserved (CiA 301, 7.4.1).
FIRST_INDEX = 0x1000


def missing_object(sdo: Transfers) -> Multiplexer:
    """Return the multiplexer of an object that the device refuses to read."""
    mux = _refused(sdo, [Multiplexer(index) for index in MISSING_INDICES])
    if mux is None:
        raise Violation(
            MISSING_REFUSED,
            expected="an abort: few devices have "
            + ", ".join(f"{index:04X}h" for index in MISSING_INDICES),
            actual="each of them is served",
        )
    return mux


def missing_sub_index(sdo: Transfers, index: int) -> Multiplexer:
    """Return a multiplexer of an existing object that the device refuses to read.

    Raises NotTestable for an object of the user's own that seems to have all sub-indices.
    """
    mux = _refused(sdo, [Multiplexer(index, sub) for sub in MISSING_SUB_INDICES])
    if mux is not None:
        return mux
    sdo.device.learned.all_entries.add(index)
    names = ", ".join(f"{sub:02X}h" for sub in MISSING_SUB_INDICES)
    if index in IDENTITY:
        raise Violation(
            SUB_INDEX_MISSING,
            expected=f"an abort: {index:04X}h has no sub-indices {names}",
            actual="each of them is served",
        )
    variable = sdo.device.known.get(Multiplexer(index))
    if variable is not None and sdo.device.is_variable(variable):
        raise Violation(
            SUB_INDEX_MISSING,
            expected=f"an abort: {index:04X}h is a variable, without sub-indices {names}",
            actual="each of them is served",
        )
    raise NotTestable(f"{index:04X}h serves the sub-indices {names}: name a simple object")


def _refused(sdo: Transfers, candidates: list[Multiplexer]) -> Multiplexer | None:
    """Return the first of some entries that is refused as missing; else with any other code.

    That is wrong then, and for the cases to find, but only of what no device can have: of others it
    may be right.
    """
    never: list[Multiplexer] = []
    for mux in candidates:
        if sdo.device.policy.is_missing(mux):
            return mux  # it was asked for before
        try:
            sdo.read(mux)
        except ServerAborted as aborted:
            if aborted.abort.code in EXISTS:
                never += [mux] if mux.index < FIRST_INDEX or mux.index in IDENTITY else []
                continue
            sdo.device.policy.allow_missing(mux)
            return mux
    if never:
        sdo.device.policy.allow_missing(never[0])
        return never[0]
    return None
