"""What one case has found: each breach with what was asked, and of very many the first ones."""

from support.run_bench import RULE

from conformance.dialogue.case_record import MOST_NOTED, CaseRecord
from conformance.dialogue.cause_of import NOTHING_SENT
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort, BlockEnd, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import NOT_REFUSED, RESERVED, Violation
from conformance.sdo.seen import Received

ASKED = UploadInitiate(Multiplexer(0x1000))
LATER = UploadInitiate(Multiplexer(0x1018))


def breach() -> Violation:
    return Violation(RESERVED, expected="0", actual="1")


def test_a_breach_is_noted_with_what_was_asked() -> None:
    record = CaseRecord(RULE)
    known = breach()
    known.asked = ASKED
    record.note(known, LATER)
    record.note(breach(), LATER)
    assert [found.asked for found in record.minor] == [ASKED, LATER]


def test_of_very_many_breaches_of_a_rule_the_first_are_kept() -> None:
    record = CaseRecord(RULE)
    for _ in range(MOST_NOTED + 1):
        record.note(breach(), ASKED)
    other = Violation(RULE, expected="this", actual="that")
    record.note(other, ASKED)
    assert (len(record.minor), record.minor[-1]) == (MOST_NOTED + 1, other)


def test_what_is_known_is_known_by_its_cause() -> None:
    record = CaseRecord(RULE)
    assert not record.is_known(breach(), ASKED)
    assert not record.is_known(None, ASKED)
    cause = record.cause_of(breach(), NOTHING_SENT)
    record.causes.add(cause, "a.case", breach(), aside=False)
    assert record.is_known(breach(), ASKED)


def test_a_refusal_is_known_by_whatever_rule_it_was_told() -> None:
    """By the code, and by what was refused."""
    mux = Multiplexer(0x2010)
    record, told = CaseRecord(RULE), Received(Abort(mux, AbortCode.CRC_ERROR))
    refused = Violation(NOT_REFUSED, expected="a positive answer", actual=told)
    refused.asked = BlockEnd(0, 3)
    cause = record.cause_of(refused, NOTHING_SENT)
    record.causes.add(cause, "a.case", refused, aside=False)
    own = Violation(RULE, expected="a download to be confirmed", actual=told)
    assert record.is_known(own, BlockEnd(0, 3))
    assert not record.is_known(own, ASKED)
    other = in_words(Abort(mux, AbortCode.GENERAL_ERROR))
    assert not record.is_known(Violation(RULE, expected="the same", actual=other), BlockEnd(0, 3))
