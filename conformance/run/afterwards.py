"""What a case leaves behind: is the server idle, and are the values what they were?"""

from dataclasses import dataclass, field

from conformance.device.device import Device
from conformance.device.objects import KnownObject
from conformance.run.dialogue import Dialogue
from conformance.run.steps import same_value, shown
from conformance.run.verdict import Afterwards
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import describe_response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, IDLE_AFTERWARDS, UNSOLICITED, Violation


@dataclass(slots=True)
class Leaving:
    """How the case left the server, and what was found on the way."""

    afterwards: Afterwards
    violation: Violation | None = None


def leave(sdo: Dialogue) -> Leaving:
    """End what the case left open and read 1000h; where that fails, abort and read it again.

    The server owes an answer to the first read, unless the case itself was cut short.
    """
    sdo.end_transfer()
    try:
        stray = sdo.fence()
    except (Violation, ServerAborted) as error:
        return _recover(sdo, error)
    if not stray:
        return Leaving(Afterwards.IDLE)
    unasked = "; ".join(map(describe_response, stray))
    return Leaving(
        Afterwards.IDLE, Violation(UNSOLICITED, expected="no further answer", actual=unasked)
    )


def _recover(sdo: Dialogue, cause: Exception) -> Leaving:
    sdo.drain()
    sdo.channel.abort(Multiplexer(0x1000), AbortCode.GENERAL_ERROR)
    try:
        sdo.fence()
    except (Violation, ServerAborted) as error:
        broken = error if isinstance(error, Violation) and error.rule is ANSWERED else cause
        return Leaving(Afterwards.LOST, _not_idle(broken))
    return Leaving(Afterwards.NEEDED_ABORT, _not_idle(cause))


def _not_idle(cause: Exception) -> Violation:
    actual = cause.actual if isinstance(cause, Violation) else str(cause)
    return Violation(
        IDLE_AFTERWARDS, expected="an ordinary answer to a read of 1000h afterwards", actual=actual
    )


@dataclass(slots=True)
class Restorer:
    """Puts back what cases wrote. ``unrestored`` lists what could not be, with the value due."""

    device: Device
    unrestored: dict[Multiplexer, str] = field(default_factory=dict)

    def restore(self, sdo: Dialogue) -> None:
        """Write the values of the start of the run to what this case wrote, and read them back."""
        known = {entry.mux: entry for entry in self.device.objects}
        for mux in sorted(sdo.written & self.device.values.keys() & known.keys()):
            if known[mux].access.writable:
                self._restore(sdo, known[mux], self.device.values[mux])

    def _restore(self, sdo: Dialogue, known: KnownObject, due: bytes) -> None:
        try:
            if same_value(known, sdo.upload(known), due):
                return
            sdo.download(known, due)
            found = sdo.upload(known)
        except Violation as violation:
            self.unrestored[known.mux] = f"{shown(due)} ({violation.actual})"
            sdo.end_transfer()
            return
        if same_value(known, found, due):
            self.unrestored.pop(known.mux, None)
        else:
            self.unrestored[known.mux] = f"{shown(due)} (it reads {shown(found)} now)"
