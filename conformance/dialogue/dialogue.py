"""What a case says to a device and what it expects back: the ``sdo`` that cases are written with.

Transfers (see ``transfers``) perform what leads to the point of a case. The expectations here are
the point, and fail by the case's rule; those of values are in ``held_values``.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from conformance.device.known_objects import KnownObject
from conformance.dialogue import held_values
from conformance.dialogue.transfers import Target, Transfers, mux_of
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import same_value, segments_of
from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import in_words, shown
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Response,
)
from conformance.sdo.layout import Message
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.rules import (
    MULTIPLEXER,
    NOT_REFUSED,
    RESTART,
    SUBSTITUTE,
    UNSOLICITED,
    Rule,
    Violation,
    accepted,
)
from conformance.sdo.rules.defects import GOES_ON, OLD_GOES_ON
from conformance.sdo.rules.timing import SERVER_TIME_OUT
from conformance.sdo.seen import Data, NoAnswer, Received, abort_in, said

# How often a server may acknowledge a sub-block that does not go on, before it gives up.
MOST_ACKNOWLEDGEMENTS = 4
# The part of the declared time during which a server may certainly not give up.
PROMPT = 0.5


def named(codes: tuple[AbortCode, ...]) -> str:
    """Write abort codes as alternatives."""
    return " or ".join(describe_code(code) for code in codes) or "any code of CiA 301"


class Dialogue(Transfers):
    """The conversation of one case with one device."""

    # Expectations: the point of a case

    def expect(self, response: Message) -> None:
        """Expect exactly this response."""
        found = self.receive()
        if found.encode() != response.encode():
            raise self.breach(in_words(response), Received(found))

    def expect_abort(
        self,
        *codes: AbortCode,
        of: Target | None,
        tolerated: tuple[AbortCode, ...] = accepted.GENERAL,
        rule: Rule | None = None,
    ) -> Abort:
        """Expect an abort with one of the codes and the multiplexer of ``of`` (None: any).

        ``tolerated`` codes are accepted as well but count as a breach of a SHOULD. Any other answer
        breaks the ``rule``, by default that of the case.
        """
        return self.take_abort(self.receive(), codes, of, tolerated, rule)

    def take_abort(
        self,
        response: Response,
        codes: tuple[AbortCode, ...],
        of: Target | None,
        tolerated: tuple[AbortCode, ...] = accepted.GENERAL,
        rule: Rule | None = None,
    ) -> Abort:
        """Hold a response that came to what ``expect_abort`` expects."""
        due = f"abort with {named(codes)}"
        broken = self.record.rule if rule is None else rule
        if not isinstance(response, Abort):
            raise Violation(broken, expected=due, actual=Received(response))
        abort = self.checks.abort(response, None)
        if of is not None and abort.mux != mux_of(of):
            # The case goes on: whether the transfer has ended is another question.
            expected = f"multiplexer {mux_of(of)}"
            self.note(Violation(MULTIPLEXER, expected=expected, actual=Received(abort)))
        if abort.code not in codes:
            if abort.code not in tolerated:
                raise Violation(broken, expected=due, actual=Received(abort))
            self.note(Violation(SUBSTITUTE, expected=due, actual=Received(abort)))
        return abort

    def expect_download_refused(
        self, target: Target, data: bytes, *codes: AbortCode, size: int | None
    ) -> int:
        """Send a segmented download that has to be refused; at which moment is the server's choice.

        ``size`` is what the initiate indicates, None for nothing. Returns the number of segments
        that the server took before it refused.
        """
        self.send(DownloadInitiate.with_size(mux_of(target), size))
        response = self.receive()
        if isinstance(response, Abort):
            if size is None and response.code not in codes:
                raise ServerAborted(response)  # for what follows it cannot be
            self.take_abort(response, codes, target)
            self._expect_nothing_taken(data, 0, size)
            return 0
        self.checks.download_initiate(response, mux_of(target))
        chunks = segments_of(data)
        for number, chunk in enumerate(chunks):
            last = number == len(chunks) - 1
            self.send(DownloadSegment.with_data(chunk, toggle=number % 2, last=last))
            response = self.receive()
            if isinstance(response, Abort):
                self.take_abort(response, codes, target)
                self._expect_nothing_taken(data, number, size)
                return number + 1
            self.checks.download_segment(response, mux_of(target), number % 2)
        raise self.breach(
            f"abort with {named(codes)}, at the last segment at the latest",
            Received(response, remark=" for the last segment"),
        )

    def _expect_nothing_taken(self, data: bytes, number: int, size: int | None) -> None:
        """Expect a segmented download to be over that was refused at its segment ``number``.

        The segment that is due would be taken by a server that goes on: one that fits what was
        announced, whether or not the refused one counts there.
        """
        before = number * SEGMENT_LENGTH
        counted = min(before + SEGMENT_LENGTH, len(data))
        rests = [1 if size is None else max(size - before, 0)]
        if number and size is not None and 0 < size - counted < rests[0]:
            rests.append(size - counted)
        for rest in rests:
            last = size is not None and rest <= SEGMENT_LENGTH
            chunk = data[: min(rest, SEGMENT_LENGTH)]
            self.expect_dead(DownloadSegment.with_data(chunk, toggle=number % 2, last=last))

    def expect_upload_or_abort(
        self, known: KnownObject, due: bytes, *codes: AbortCode, warned: tuple[AbortCode, ...] = ()
    ) -> None:
        """Expect the upload that was asked for to be served, with the data due, or refused.

        A refusal with a code that is only tolerated counts as a breach of a SHOULD. Which
        multiplexer it carries is open: a server may not know what it was asked.
        """
        response = self.receive()
        if isinstance(response, Abort):
            self.take_abort(response, codes, None, (*accepted.GENERAL, *warned))
            return
        initiated = self.checks.upload_initiate(response, known.mux)
        found = self.finish_upload(known, initiated)
        if not same_value(known, found, due):
            raise self.breach(f"{known} reads {shown(due)}", Data(found))

    def expect_download_or_abort(
        self, known: KnownObject, *codes: AbortCode, tolerated: tuple[AbortCode, ...] = ()
    ) -> None:
        """Expect the download initiate that was sent to be confirmed, or refused.

        A refusal with a code that is only tolerated counts as a breach of a SHOULD.
        """
        response = self.receive()
        if isinstance(response, Abort):
            self.take_abort(response, codes, None, (*accepted.GENERAL, *tolerated))
        else:
            self.checks.download_initiate(response, known.mux)

    def expect_restart_or_abort(
        self, request: Request, old: Target, new: Target
    ) -> Response | None:
        """Send an initiate in mid-transfer: it is served, or refused and the server is idle.

        Returns the positive response, or None for a refusal, which counts as a breach of a SHOULD.
        """
        self.send(request)
        response = self.receive()
        if not isinstance(response, Abort):
            return response
        self.checks.abort(response, None)
        if response.mux not in (mux_of(old), mux_of(new)):
            raise self.breach(f"an abort of {mux_of(old)} or {mux_of(new)}", Received(response))
        served = self.behind_superseded(response, mux_of(old))
        if served is not None:
            return served
        self.note(
            Violation(
                RESTART,
                expected=f"{mux_of(new)} served",
                actual=Received(response),
            )
        )
        return None

    @contextmanager
    def one_transfer(self) -> Iterator[None]:
        """Expect a transfer that was begun in mid-transfer to be the only one from there on.

        Whatever goes wrong with either is one cause, unless it is a known one.
        """
        try:
            yield
        except ServerAborted as refused:
            seen = Received(refused.abort)
            expected = "the new transfer to be served"
            raise Violation(
                NOT_REFUSED, expected=expected, actual=seen, told_as=OLD_GOES_ON
            ) from None
        except Violation as breach:
            if breach.told_as is None and not self.record.is_known(breach, self.wire.last_sent):
                breach.told_as = OLD_GOES_ON
            raise

    def expect_dead(self, request: Request) -> None:
        """Send a request of a transfer that is over: it must not go on.

        Whether a server aborts or keeps silent, with which multiplexer and code, is open.
        """
        self.send(request)
        self.expect_over()

    def expect_over(self) -> None:
        """Expect that a transfer does not go on with what was sent last, as ``expect_dead``."""
        aborted = self.wire.server_aborted
        try:
            self.expect_silence_or_abort()
        except Violation as breach:
            # Several answers are none that was asked for: the segments of a sub-block, say.
            told = breach.rule is self.record.rule or breach.rule is UNSOLICITED
            if aborted and told and abort_in(breach.seen) is None:
                breach.told_as = GOES_ON
            raise

    def expect_refusals(self) -> None:
        """Expect no more than aborts of segments that are behind an abort: the server is idle."""
        for answer in self.fence():
            if not isinstance(answer, Abort):
                expected = "an abort of each segment at the most"
                raise self.breach(expected, Received(answer), told_as=GOES_ON)
            self.checks.abort(answer, None)

    def expect_nothing(self) -> None:
        """Expect that what was sent last is not answered."""
        answer = self.reaction()
        if answer is not None:
            raise self.breach("no answer", Received(answer))

    def expect_silence_or_abort(self, *codes: AbortCode) -> None:
        """Expect no answer, or an abort with one of the codes; without codes, with any.

        The multiplexer is not checked: no clause says which one such an abort carries.
        """
        answer = self.reaction()
        if answer is None:
            return
        if not isinstance(answer, Abort) or (codes and answer.code not in codes):
            raise self.breach(f"no answer, or an abort with {named(codes)}", Received(answer))
        self.checks.abort(answer, None)

    def expect_timed_out(self, target: Target, seconds: float) -> None:
        """Send nothing: the server gives up after ``seconds`` from the last frame, and says so.

        A server that waits for segments of a block may acknowledge what it has before.
        """
        now = self.channel.link.now
        begin = now() if self.wire.pauses.active_at is None else self.wire.pauses.active_at
        for _ in range(MOST_ACKNOWLEDGEMENTS):
            response = self.wait(seconds + self.channel.response_timeout)
            if not isinstance(response, BlockAck):
                break
        due = f"abort with {named(SERVER_TIME_OUT.codes)} after {seconds:g} s of silence"
        if response is None:
            raise self.breach(due, NoAnswer(f"nothing within {now() - begin:.3g} s"))
        self.take_abort(response, SERVER_TIME_OUT.codes, target, SERVER_TIME_OUT.tolerated)
        elapsed = self.channel.arrived - begin
        if elapsed < seconds * PROMPT:
            raise self.breach(due, said("it came after {} s", f"{elapsed:.3g}"))

    def expect_patience(self, seconds: float) -> bool:
        """Send nothing for a time that the server has to wait; say whether it kept silent.

        It need not where it waits for segments of a block: it may acknowledge what it has.
        """
        response = self.wire.pause(seconds)
        if response is not None and not isinstance(response, BlockAck):
            raise self.breach(f"no answer for {seconds:g} s", Received(response))
        return response is None

    def expect_clean(self, rule: Rule) -> None:
        """Expect that no response of this case broke a rule that does not stop a transfer."""
        for violation in self.record.minor:
            if violation.rule is rule:
                raise violation

    # Values

    def expect_value(self, known: KnownObject, due: bytes) -> None:
        """Expect an object to read as ``due``; a string may end in 00h."""
        held_values.expect_value(self, known, due)

    @contextmanager
    def unchanged(self, known: KnownObject) -> Iterator[bytes]:
        """Expect an object to keep its value; see ``expect_kept``."""
        before = ValueAccess(self).read(known)
        self.wire.parts.pop(known.mux, None)
        yield before
        self.end_transfer()
        self.expect_kept(known, before)

    def expect_kept(self, known: KnownObject, before: bytes) -> None:
        """Expect an object to read as before a download that was aborted.

        Of a string what came before the abort may have been written, a domain may hold anything;
        both count as a breach of a SHOULD.
        """
        held_values.expect_kept(self, known, before)
