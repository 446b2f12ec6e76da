"""The causes that are known of one device, each told once however many cases meet it.

A cause that cases have met outside their own points *stands*: the suite knows it from then on, and
steps round it or says that it is in the way.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from conformance.dialogue.cause_of import GENERAL, blocked_by, cause_of
from conformance.sdo.abort_codes import APPLICATION_STATE
from conformance.sdo.frames import (
    BlockAck,
    BlockDownloadInitiate,
    BlockEndResponse,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegmentResponse,
    Request,
)
from conformance.sdo.kinds import DOWNLOADS, OTHER_DATA, kind_of, kind_of_request
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.rules import (
    BLOCK_SIZE,
    NOT_REFUSED,
    SPECIFIER,
    UNSOLICITED,
    Cause,
    Rule,
    Violation,
)
from conformance.sdo.rules.block_upload import ENDS
from conformance.sdo.rules.defects import (
    BEHIND_LAST,
    BOOTED_AS_HEARTBEAT,
    EXPEDITED_NOT_STORED,
    IN_BLOCKS,
    NOT_STORED,
    NUMBER_NOT_STORED,
    SERVED,
    STRUCTURE,
    VALUES_WRONG,
)
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED

# What stands for the answer to any of these is a segment behind the last one.
SEGMENT_INSTEAD = frozenset((SPECIFIER.id, IN_BLOCKS.rule_id))
# A segment too many in a sub-block.
EXCEEDED = tuple(Cause(rule.id, BEHIND_LAST.answer) for rule in (BLOCK_SIZE, ENDS))
CONFIRMED = tuple(
    kind_of(response) for response in (DownloadInitiateResponse, DownloadSegmentResponse)
)
# Where values read wrong under that many rules, no further one says what is wrong.
MANY_RULES = 3
BLOCK_UPLOAD = "block-upload."
DOWNLOADING = (DownloadInitiate, BlockDownloadInitiate)
IN_BLOCK_UPLOAD = (BlockUploadStart, BlockAck, BlockEndResponse)
BEHIND_BLOCK_UPLOAD = f"to {kind_of_request(BlockEndResponse())}"
TO_DOWNLOADS = frozenset(f"to {kind}" for kind in DOWNLOADS)


@dataclass(slots=True)
class Standing:
    """A cause that was seen: the case that met it first, and what was wrong there.

    ``aside`` says that no case has failed for it: it was met outside the cases.
    """

    first_case: str
    violation: Violation
    aside: bool = False
    shown_by: set[str] = field(default_factory=set)


class Causes:
    """What is known to be wrong with one device.

    Whatever is met comes ``of_one`` cause where that is known.
    """

    def __init__(self) -> None:
        """Nothing is known to be wrong yet."""
        self._standing: dict[Cause, Standing] = {}
        self.of_one: Cause | None = None

    def __iter__(self) -> Iterator[tuple[Cause, Standing]]:
        """Yield all causes, in the order in which they were met."""
        yield from self._standing.items()

    def get(self, cause: Cause) -> Standing | None:
        """Return what is known of a cause; None for a new one."""
        return self._standing.get(cause)

    def state(self) -> dict[Cause, Standing]:
        """Return what is known now, to come back to."""
        return {
            cause: replace(standing, shown_by=set(standing.shown_by)) for cause, standing in self
        }

    def return_to(self, state: dict[Cause, Standing]) -> None:
        """Know what was known then, and no more."""
        self._standing = state

    def of(self, violation: Violation, rule: Rule, request: Request) -> Cause:
        """Return the cause of a breach, see ``cause_of``.

        A device that sends segments behind the last one sends them in the place of any answer.
        """
        cause = self.of_one or cause_of(violation, rule, request)
        segment = cause.kind == BEHIND_LAST.kind and rule.id in SEGMENT_INSTEAD
        return BEHIND_LAST if segment and BEHIND_LAST in self._standing else cause

    def told_as(self, cause: Cause, request: Request, point: str, *, generated: bool) -> Cause:
        """Return the cause that is known already and the same as one that was met.

        A refusal of the same kind of request with the same code is one, whatever rule is named for
        it. In one state of a matrix a kind of answer is told once, whatever was asked: ``point`` is
        the rule of that state where the case was ``generated``.
        """
        if cause in self._standing:
            return cause
        return (
            self._of_a_stub(cause)
            or self._other_data(cause, request)
            or self._answer_to_the_end(cause, request)
            or self._refusal(cause, request)
            or (self._in_one_state(cause, point) if generated else None)
            or cause
        )

    def _of_a_stub(self, cause: Cause) -> Cause | None:
        """Return by what a device that serves or confirms everything is told."""
        if cause == STRUCTURE and SERVED in self._standing:
            return SERVED  # FFh is but one of those that are served
        if self.nothing_is_stored and cause.kind in CONFIRMED and not cause.request:
            return NOT_STORED
        return None

    def _other_data(self, cause: Cause, request: Request) -> Cause | None:
        """Return by what wrong data are told: those of a block upload, or met in many places."""
        if cause.kind != OTHER_DATA:
            return None
        of_blocks = isinstance(request, IN_BLOCK_UPLOAD) or cause.rule_id.startswith(BLOCK_UPLOAD)
        if of_blocks and IN_BLOCKS in self._standing:
            return IN_BLOCKS
        known = [one for one in self._standing if one.kind == OTHER_DATA]
        if len(known) < MANY_RULES:
            return None
        return next((one for one in known if one.rule_id in GENERAL), VALUES_WRONG)

    def _answer_to_the_end(self, cause: Cause, request: Request) -> Cause | None:
        """Return by what an answer to the end of a block upload is told, wherever that is sent."""
        if isinstance(request, BlockEndResponse):
            for known in self._standing:
                behind = (known.rule_id, known.request) == (UNSOLICITED.id, BEHIND_BLOCK_UPLOAD)
                if behind and known.answer == cause.answer:
                    return known
        return None

    def _refusal(self, cause: Cause, request: Request) -> Cause | None:
        """Return by what a refusal is told that is known from another place.

        That a device writes nothing in its state it may say to downloads of each kind.
        """
        if cause.code is None:
            return None
        blocked = blocked_by(cause.kind)
        if blocked in self._standing:
            return blocked
        if cause.code in APPLICATION_STATE and isinstance(request, DOWNLOADING):
            for known in self._standing:
                refused = (known.rule_id, known.code) == (NOT_REFUSED.id, cause.code)
                if refused and known.request in TO_DOWNLOADS:
                    return known
        known = replace(cause, rule_id=NOT_REFUSED.id, request=f"to {kind_of_request(request)}")
        return known if not cause.request and known in self._standing else None

    def _in_one_state(self, cause: Cause, point: str) -> Cause | None:
        """Return by what an answer of this kind is told that another field of a state has met."""
        if cause.rule_id in GENERAL:
            for known, standing in self:
                alike = (known.rule_id, known.kind) == (cause.rule_id, cause.kind)
                if alike and point in standing.shown_by:
                    return known
        return None

    def add(self, cause: Cause, case_id: str, violation: Violation, *, aside: bool) -> Standing:
        """Take note that a cause was met: ``aside`` of all cases, or by one that fails for it."""
        standing = self._standing.setdefault(cause, Standing(case_id, violation, aside))
        if standing.aside and not aside:
            standing.first_case, standing.violation, standing.aside = case_id, violation, False
        return standing

    def aside(self) -> list[tuple[Cause, Standing]]:
        """Return what no case has failed for: it was met outside the cases."""
        return [(cause, standing) for cause, standing in self if standing.aside]

    @property
    def aborts_are_answered(self) -> bool:
        """Whether the device was seen to answer an abort of its client."""
        return any(cause.rule_id == ABORT_NOT_ANSWERED.id for cause in self._standing)

    @property
    def nothing_is_stored(self) -> bool:
        """Whether the device was seen to confirm a download and to keep what it held."""
        return NOT_STORED in self._standing

    def unstored(self, *, number: bool, size: int) -> Cause | None:
        """Return how it is told that the device stores no value like this, if that was seen."""
        if self.nothing_is_stored:
            return NOT_STORED
        if number and NUMBER_NOT_STORED in self._standing:
            return NUMBER_NOT_STORED
        expedited = 0 < size <= EXPEDITED_LENGTH and EXPEDITED_NOT_STORED in self._standing
        return EXPEDITED_NOT_STORED if expedited else None

    @property
    def sub_blocks_are_exceeded(self) -> bool:
        """Whether the device was seen to send more segments in a sub-block than it has."""
        return any(cause in self._standing for cause in EXCEEDED)

    @property
    def boots_up_as_heartbeat(self) -> bool:
        """Whether the device was seen to send a heartbeat in the place of a boot-up message."""
        return BOOTED_AS_HEARTBEAT in self._standing

    @property
    def noisy(self) -> bool:
        """Whether the device was seen to send unsolicited responses."""
        unasked = (ABORT_NOT_ANSWERED.id, UNSOLICITED.id)
        return any(cause.rule_id in unasked for cause in self._standing)
