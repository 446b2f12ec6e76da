"""Aborts by which a server ends a transfer that is running: it may do so at any time (7.2.4.3.17).

Once is nothing to blame it for, so a case that one has ended is tried again. What ends each try
in the same way is no chance: the server refuses the service.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeGuard

from conformance.device.effort import TRIES_OF_TRANSFER
from conformance.sdo.abort_codes import ACCUSATIONS, APPLICATION_STATE, AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import (
    INITIATES,
    Abort,
    BlockSegment,
    Request,
    Response,
)
from conformance.sdo.kinds import kind_of_request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import NOT_REFUSED, Violation

_CODES = frozenset(AbortCode)


@dataclass(frozen=True, slots=True)
class Way:
    """How a try has ended: the rule that it breaks, the abort, and behind which request.

    ``transfers`` counts those that had begun. Before the first try ends it may have been found out
    what an object takes, so the count may differ there.
    """

    rule_id: str
    abort: Abort
    request: str
    transfers: int

    def resembles(self, other: "Way") -> bool:
        """Say whether all but the count is the same."""
        return replace(self, transfers=0) == replace(other, transfers=0)


def is_systematic(ways: Sequence[Way]) -> bool:
    """Say whether all tries have ended in one way, and all but the first at the same place."""
    alike = all(way.resembles(ways[-1]) for way in ways)
    return len(ways) >= TRIES_OF_TRANSFER and alike and len(set(ways[1:])) == 1


class EarlyAborts:
    """Notes that the server has ended transfers early.

    ``met`` is the abort that has ended the latest one, until the next begins. ``transfers`` counts
    the initiates that were sent. ``has_crossed``: an abort of the server has crossed with that of
    the client, so the request behind that may be served yet.
    """

    def __init__(self) -> None:
        """No transfer has begun."""
        self.transfers = 0
        self.has_crossed = False
        self._given_up: Multiplexer | None = None
        self._met: Abort | None = None
        self._all: list[Abort] = []

    @property
    def met(self) -> Abort | None:
        """The abort that has ended the latest transfer."""
        return self._met

    def sent(self, request: Request) -> None:
        """Take what a case sends."""
        if isinstance(request, INITIATES):
            self._met = None
            self.transfers += 1

    def aborted(self, running: Multiplexer | None) -> None:
        """Take an abort of the client; ``running`` is the object of the transfer that it ends."""
        self._given_up = running

    def note(self, abort: Abort) -> None:
        """Take an abort that has ended a transfer early."""
        self._met = abort
        if abort not in self._all:
            self._all.append(abort)

    def received(self, response: Response, running: Multiplexer | None) -> None:
        """Take a response; ``running`` is the object of the transfer that is, if there is one."""
        if isinstance(response, Abort):
            if is_early(response, running):
                self.note(response)
            elif is_early(response, self._given_up):
                self.has_crossed = True
                self.note(response)
        self._given_up = None

    def forget(self) -> None:
        """Begin with something else."""
        self.transfers, self._met, self._all = 0, None, []

    def way(self, error: BaseException | None, asked: Request) -> Way | None:
        """Say in which way a try has ended; None where the server has not left early."""
        match error:
            case Violation():
                abort = self._met or self._told_of(error)
                rule_id, asked = error.rule.id, error.asked or asked
            case ServerAborted():
                abort = error.abort if error.abort in self._all else None
                rule_id = NOT_REFUSED.id
            case _:
                return None
        if abort is None or _accuses(abort, asked):
            return None
        return Way(rule_id, abort, kind_of_request(asked), self.transfers)

    def _told_of(self, error: Violation) -> Abort | None:
        """Return the abort that a breach tells of: what came since may have been tidying."""
        return next((abort for abort in self._all if abort in error.seen.responses), None)


def _accuses(abort: Abort, asked: Request) -> bool:
    """Say whether an abort calls a request wrong: there is no chance in that.

    A server may have lost a segment of a burst, and call the next one out of sequence.
    """
    lost = isinstance(asked, BlockSegment) and abort.code == AbortCode.INVALID_SEQUENCE_NUMBER
    return abort.code in ACCUSATIONS and not lost


def leaves(response: Response, running: Multiplexer | None) -> bool:
    """Say whether a server ends what runs for a reason of its own, not for what it was sent."""
    return is_early(response, running) and response.code in APPLICATION_STATE


def is_early(response: Response, running: Multiplexer | None) -> TypeGuard[Abort]:
    """Say whether a response is an abort of what runs, and nothing is wrong with it."""
    return (
        running is not None
        and isinstance(response, Abort)
        and response.mux == running
        and response.code in _CODES
        and not response.reserved_bits
    )
