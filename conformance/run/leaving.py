"""What a case leaves behind: is the server idle?"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

from conformance.device.device import DEVICE_TYPE
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.shape_breaches import unasked, unsolicited
from conformance.dialogue.wire import PLAIN_READING
from conformance.run.verdict import Afterwards
from conformance.sdo.abort_codes import AbortCode, meaning_of
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import Abort, Response
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.line import ASKS_FOR_SEGMENTS
from conformance.sdo.rules import ANSWERED, IDLE_AFTERWARDS, Violation
from conformance.sdo.rules.defects import STREAMS
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED
from conformance.sdo.seen import Said, Seen


@dataclass(slots=True)
class Leaving:
    """How the case left the server, and what was found on the way.

    ``stray`` are the responses that came before the answer to the read of 1000h.
    """

    afterwards: Afterwards
    violation: Violation | None = None
    stray: Sequence[Response] = ()

    @property
    def answers_abort(self) -> bool:
        """Whether the first that came is an abort, behind that by which the suite left."""
        return self.violation is not None and self.violation.rule is ABORT_NOT_ANSWERED


class Proof(Enum):
    """What proves, behind a case, that the server is idle.

    ANEW: a read of 1000h, whatever the case has shown. FENCE: also one in the case, behind which
    nothing but ordinary uploads were served. UPLOAD: also an ordinary upload, as the case ends.
    """

    ANEW = auto()
    FENCE = auto()
    UPLOAD = auto()


def leave(sdo: Dialogue, *, failed: bool, proof: Proof = Proof.ANEW) -> Leaving:
    """End what the case left open and read 1000h; where that fails, abort and read it again.

    It need not be read if there is a ``proof`` already.

    A server that failed the case may have a transfer running that it should not have: it is told
    to end that as well, so that the next case does not meet it.
    """
    asked = sdo.wire.last_sent
    sdo.end_transfer()
    if failed:
        sdo.device.contents.current.clear()  # who knows what such a server does yet
    elif stream := _stream(sdo):
        return Leaving(Afterwards.IDLE, _streams(stream), stream)
    elif _is_idle(sdo, proof):
        return Leaving(Afterwards.IDLE)
    leaving = _look(sdo)
    if failed and leaving.afterwards is Afterwards.IDLE and sdo.line.latest is not None:
        sdo.channel.abort(sdo.line.latest, AbortCode.GENERAL_ERROR)
        take_the_rest(sdo)
    if failed and (isinstance(asked, ASKS_FOR_SEGMENTS) or sdo.line.misplaced):
        sdo.silence.outlast()
    return leaving


def _stream(sdo: Dialogue) -> list[Response]:
    """Return what a server goes on to send behind what asks for segments out of place.

    One that was seen to send nothing there is not waited for again.
    """
    misplaced, learned = sdo.line.misplaced, sdo.device.learned
    if misplaced <= learned.says_all and not (misplaced and learned.streams):
        return []
    found = sdo.silence.outlast()
    learned.streams |= _are_segments(found)
    if not found:
        learned.says_all |= misplaced
    return found


def _are_segments(found: Sequence[Response]) -> bool:
    return any(not isinstance(response, Abort) for response in found)


def _streams(stream: Sequence[Response]) -> Violation:
    violation = unsolicited(stream, "no further answer")
    if _are_segments(stream):
        violation.told_as = STREAMS
    return violation


def _is_idle(sdo: Dialogue, proof: Proof) -> bool:
    wire = sdo.wire
    uploaded = proof is Proof.UPLOAD and isinstance(wire.last_sent, PLAIN_READING)
    if not uploaded and (proof is Proof.ANEW or not wire.is_proven):
        return False
    return not (wire.line.owed or wire.server_aborted or wire.channel.waiting())


def take_the_rest(sdo: Dialogue) -> None:
    """Take what a server sends behind an abort of the suite: it belongs to no case."""
    try:
        sdo.fence()
    except (Violation, ServerAborted):
        sdo.drain()


def shift(sdo: Dialogue, transfers: int) -> None:
    """Read an object some times, for a server that does something in every n-th transfer."""
    values = sdo.device.values
    long = [mux for mux in values if len(values[mux]) > EXPEDITED_LENGTH]
    for _ in range(transfers if long else 0):
        try:
            sdo.read(min(long, key=lambda mux: len(values[mux])))
        except (Violation, ServerAborted):
            sdo.silence.recover(crossed=True)


def _look(sdo: Dialogue) -> Leaving:
    aborted = sdo.wire.has_aborted
    try:
        stray = sdo.fence()
    except (Violation, ServerAborted) as error:
        return _recover(sdo, error)
    if not stray:
        return Leaving(Afterwards.IDLE)
    echoed = stray[0] == sdo.wire.own_abort
    first = unasked(stray[0], aborted=aborted or echoed)
    others = stray[1:]
    if others:
        first = Violation(
            first.rule,
            expected=first.expected,
            actual=first.seen.remarking(f"; {unsolicited(others).actual}"),
        )
    return Leaving(Afterwards.IDLE, first, stray)


def _recover(sdo: Dialogue, cause: Violation | ServerAborted) -> Leaving:
    sdo.drain()
    # Some servers mind only an abort that names the transfer that they think is running.
    sdo.channel.abort(sdo.line.latest or DEVICE_TYPE, AbortCode.GENERAL_ERROR)
    try:
        sdo.fence()
    except (Violation, ServerAborted) as error:
        silent = isinstance(error, Violation) and error.rule is ANSWERED
        return Leaving(Afterwards.LOST if silent else Afterwards.ANSWERS_WRONGLY, _not_idle(cause))
    return Leaving(Afterwards.NEEDED_ABORT, _not_idle(cause))


def _refused(cause: ServerAborted) -> Seen:
    return Said(str(cause), f"the server aborted, … ({meaning_of(cause.abort.code)})")


def _not_idle(cause: Violation | ServerAborted) -> Violation:
    actual = cause.seen if isinstance(cause, Violation) else _refused(cause)
    return Violation(
        IDLE_AFTERWARDS,
        expected="an ordinary answer to a read of 1000h afterwards",
        actual=actual,
        told_as=cause.told_as if isinstance(cause, Violation) else None,
    )
