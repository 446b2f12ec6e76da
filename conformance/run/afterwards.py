"""What a case leaves behind: is the server idle, and are the values what they were?"""

from dataclasses import dataclass, field

from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.objects import KnownObject
from conformance.run.channel_steps import is_cob_id
from conformance.run.dialogue import Dialogue
from conformance.run.steps import same_value, shown
from conformance.run.verdict import Afterwards
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import describe_response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, IDLE_AFTERWARDS, UNSOLICITED, Violation

# How many bytes more than its value an object may fill up with, as strings are with 00h.
MOST_PADDING = 64


@dataclass(slots=True)
class Leaving:
    """How the case left the server, and what was found on the way."""

    afterwards: Afterwards
    violation: Violation | None = None


def leave(sdo: Dialogue, *, failed: bool) -> Leaving:
    """End what the case left open and read 1000h; where that fails, abort and read it again.

    A server that failed the case may have a transfer running that it should not have: it is told
    to end that as well, so that the next case does not meet it.
    """
    sdo.end_nmt()
    sdo.end_transfer()
    leaving = _look(sdo)
    if failed and leaving.afterwards is Afterwards.IDLE and sdo.tracker.latest is not None:
        sdo.channel.abort(sdo.tracker.latest, AbortCode.GENERAL_ERROR)
        sdo.drain()
    return leaving


def _look(sdo: Dialogue) -> Leaving:
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
    # Some servers mind only an abort that names the transfer that they think is running.
    sdo.channel.abort(sdo.tracker.latest or DEVICE_TYPE, AbortCode.GENERAL_ERROR)
    try:
        sdo.fence()
    except (Violation, ServerAborted) as error:
        silent = isinstance(error, Violation) and error.rule is ANSWERED
        return Leaving(Afterwards.LOST if silent else Afterwards.ANSWERS_WRONGLY, _not_idle(cause))
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
        for known in self._written(sdo):
            self._restore(sdo, known, self.device.values[known.mux])
        parameters = [
            (KnownObject(mux), due)
            for mux, due in sorted(self.device.parameters.items())
            if mux in sdo.written
        ]
        for known, due in parameters:
            if is_cob_id(known.mux) and not self._reads(sdo, known, due):
                # It may only be moved while it is not in use.
                sdo.disable(known.mux)
        for known, due in parameters:
            self._restore(sdo, known, due)

    def give_up(self, sdo: Dialogue) -> None:
        """Take down what a case wrote to a device that answers no more."""
        for known in self._written(sdo):
            self.unrestored[known.mux] = shown(self.device.values[known.mux])
        for mux in self.device.parameters.keys() & sdo.written:
            self.unrestored[mux] = shown(self.device.parameters[mux])

    def restore_pending(self, sdo: Dialogue) -> None:
        """Try once more what could not be put back, as with a device that was lost meanwhile."""
        for known in self.device.objects:
            if known.mux in self.unrestored and known.access.writable:
                self._restore(sdo, known, self.device.values[known.mux])

    def _written(self, sdo: Dialogue) -> list[KnownObject]:
        return [
            known
            for known in self.device.objects
            if known.mux in sdo.written
            and known.mux in self.device.values
            and known.access.writable
        ]

    def _restore(self, sdo: Dialogue, known: KnownObject, due: bytes) -> None:
        self.unrestored[known.mux] = shown(due)
        if not self._reads(sdo, known, due):
            try:
                sdo.download(known, due)
            except Violation as violation:
                self.unrestored[known.mux] += f" ({violation.actual})"
                sdo.end_transfer()
                return
            if not self._reads(sdo, known, due):
                return
        del self.unrestored[known.mux]

    def _reads(self, sdo: Dialogue, known: KnownObject, due: bytes) -> bool:
        """Say whether an object reads as it should; what cannot be read does not.

        What announces far more than is due need not be read to its end to know that.
        """
        try:
            response = sdo.initiate_upload(known)
            if response.size is not None and response.size > len(due) + MOST_PADDING:
                sdo.end_transfer()
                return False
            return same_value(known, sdo.finish_upload(known, response), due)
        except Violation:
            sdo.end_transfer()
            return False
