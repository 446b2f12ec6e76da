"""Aborts of a running transfer, which a server may send at any time (CiA 301, 7.2.4.3.17).

Frames cross on the wire: what the client had sent when it met the abort may have reached a server
that was idle by then, and each such frame may be answered for what it looks like.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from conformance.sdo.abort_codes import APPLICATION_STATE
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort
from conformance.sdo.oracle.answers import (
    BLOCK_UPLOAD,
    KNOWN_CODES,
    DueAbort,
    is_segment,
    shape,
    violation,
)
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.oracle.branch import Branch, quiet
from conformance.sdo.oracle.lost import Lost, most_answers
from conformance.sdo.oracle.states import IDLE, Running
from conformance.sdo.rules import ABORT_CODE, MULTIPLEXER, Violation, idle


@dataclass(frozen=True, slots=True)
class Ended:
    """A transfer that the server has ended with an abort that was not due.

    ``violation`` is what would be wrong if it did so every time; ``refusal`` says that the client
    had asked for an abort, if for another one.
    """

    abort: Abort
    violation: Violation
    refusal: bool


@dataclass(frozen=True, slots=True)
class Ending:
    """What an abort makes of the branches in which a transfer runs.

    ``wrong`` is what is the matter with the abort itself; ``due`` says that it is one for which
    there is a reason. One that is ``senseless`` would have one, if the client were wrong or had
    asked for another service.
    """

    abort: Abort
    branches: list[Branch]
    wrong: list[Violation]
    due: bool
    senseless: bool

    @property
    def may_cross(self) -> bool:
        """Whether it may have been sent before the request that it seems to answer."""
        return not self.wrong and (self.due or self.abort.code in APPLICATION_STATE)


def ending(branches: Iterable[Branch], frame: bytes, sent: Sequence[bytes]) -> Ending | None:
    """Take a frame for the abort of what runs; None where it is none, or nothing runs.

    ``sent`` are the requests since the response before.
    """
    abort = decode_response(frame)
    running = [(branch, branch.state) for branch in branches if isinstance(branch.state, Running)]
    if not isinstance(abort, Abort) or not running:
        return None
    muxes = [state.mux for _, state in running]
    if is_segment(frame, muxes) and all(state.name == BLOCK_UPLOAD for _, state in running):
        return None
    own = [(branch, state) for branch, state in running if state.mux == abort.mux] or running
    # What is still to be acknowledged may have been refused for a segment behind it.
    reasons = [
        refusal
        for branch, state in own
        if isinstance(state, SubBlock)
        for refusal in state.behind(branch.backlog).refusals()
    ]
    wrong = list(shape(abort, frame))
    due = own[0][1].mux
    if abort.mux != due:
        wrong.append(violation(MULTIPLEXER, f"multiplexer {due}", frame))
    if abort.code not in KNOWN_CODES:
        wrong.append(violation(ABORT_CODE, "an abort with any code of CiA 301", frame))
    ended = [after for branch, _ in own for after in _after(branch, sent)]
    best = _best(reasons, abort, frame)
    if best is not None and not wrong:
        ended = [branch.noting(*best) for branch in ended]
    senseless = best is None and all(abort.code in state.senseless for _, state in own)
    return Ending(abort, ended, wrong, best is not None, senseless)


def _best(reasons: Iterable[DueAbort], abort: Abort, frame: bytes) -> list[Violation] | None:
    """Return what an abort misses if it is one of those for which there is a reason."""
    for refusal in reasons:
        if abort.code in refusal.codes:
            return []
    for refusal in reasons:
        if abort.code in refusal.tolerated:
            return list(refusal.breaches(abort, frame))
    return None


def _after(branch: Branch, sent: Sequence[bytes]) -> Iterable[Branch]:
    """Yield where a server may be that has ended a transfer while ``sent`` was on its way."""
    memory = branch.memory
    # Where the answer before this one came late as well, more is on its way than was sent since.
    on_its_way = max(sent, branch.backlog, key=len)
    if len(on_its_way) > 1:
        owed = sum(most_answers(frame) for frame in on_its_way)
        yield quiet(Lost(owed), memory.in_doubt(), idle.ABORT_NOT_ANSWERED)
        return
    rest = quiet(IDLE, memory, idle.ABORT_NOT_ANSWERED).choosing(*branch.freedoms)
    yield rest
    if sent:
        yield from (after.choosing(*branch.freedoms) for after in IDLE.receive(sent[0], memory))
