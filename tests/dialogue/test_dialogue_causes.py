"""What counts as one cause: a rule, and the kind of answer without its numbers."""

import pytest

from conformance.dialogue.cause_of import NOTHING_SENT, TIMED_OUT, blocked, cause_of
from conformance.dialogue.causes import MANY_RULES, Causes
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    DownloadSegmentResponse,
    RemoteFrame,
    Request,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.kinds import NO_ANSWER, OTHER_DATA
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import (
    ANSWERED,
    FRAME_SHAPE,
    IDLE_AFTERWARDS,
    MULTIPLEXER,
    NO_REBOOT,
    NOT_REFUSED,
    SPECIFIER,
    TOGGLE,
    UNSOLICITED,
    Cause,
    Rule,
    Violation,
    rule_of,
)
from conformance.sdo.rules.defects import (
    ABORT_ANSWERED,
    GAVE_UP,
    GOES_ON,
    IN_BLOCKS,
    SERVED,
    STRUCTURE,
    SWITCHED,
    VALUES_WRONG,
)
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED
from conformance.sdo.seen import Data, NoAnswer, OddFrame, Received, Seen, said

MUX = Multiplexer(0x2010, 1)
READ = UploadInitiate(MUX)
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)


def violation(rule: Rule, actual: Seen | str) -> Violation:
    return Violation(rule, expected="another thing", actual=actual)


def from_hex(frame: str) -> Seen:
    return Received(decode_response(bytes.fromhex(frame)))


# Causes


@pytest.mark.parametrize(
    ("rule", "request_", "actual", "cause"),
    [
        # A rule of one place says all.
        (TOGGLE, READ, said("t={}", 1), "t=…"),
        # A general rule is told apart by the request.
        (ANSWERED, READ, NoAnswer("nothing within 1000 ms"), "no answer to upload initiate"),
        (
            ANSWERED,
            BlockSegment(127, b"ABCDEFG"),
            NoAnswer("nothing within 1000 ms"),
            "no answer to block segment …",
        ),
        (
            SPECIFIER,
            READ,
            from_hex("FF 00 00 00 00 00 00 00"),
            "command specifier to upload initiate",
        ),
        (
            NOT_REFUSED,
            DownloadInitiate.with_size(MUX, 20),
            from_hex("80 10 20 01 02 00 01 06"),
            "abort 06010002h to download initiate, segmented",
        ),
        (
            IDLE_AFTERWARDS,
            DownloadSegment.with_data(b"ABC", toggle=0),
            NoAnswer(),
            "no answer behind download segment",
        ),
        (
            NO_REBOOT,
            Unknown(b"\xff" + bytes(7)),
            "the device booted",
            "the device booted behind command specifier …",
        ),
        (
            NO_REBOOT,
            Unknown(b""),
            "the device booted",
            "the device booted behind frame without data",
        ),
        (NO_REBOOT, NOTHING_SENT, "the device booted", "the device booted"),
        # The code of an abort that is wrong as such does not matter.
        (MULTIPLEXER, READ, from_hex("80 00 00 00 00 00 02 06"), "abort"),
        (UNSOLICITED, READ, from_hex("80 10 20 01 00 00 00 08"), "abort to upload initiate"),
        # Every other length is the same breach.
        (
            FRAME_SHAPE,
            READ,
            OddFrame(CanFrame(0x585, b"\x43"), {"another length than 8": "DLC 1"}),
            "another length than 8",
        ),
    ],
)
def test_cause(rule: Rule, request_: Request, actual: Seen, cause: str) -> None:
    assert str(cause_of(violation(rule, actual), rule, request_)) == f"{rule.id}: {cause}"


@pytest.mark.parametrize("rule", [UNSOLICITED, MULTIPLEXER, SPECIFIER, IDLE_AFTERWARDS])
@pytest.mark.parametrize("frame", ["80 10 20 01 00 00 00 08", "43 00 10 00 91 01 0F 00"])
def test_whatever_answers_an_abort_is_one_cause(rule: Rule, frame: str) -> None:
    cause = cause_of(violation(rule, from_hex(frame)), rule, ABORT)
    assert cause == ABORT_ANSWERED


def test_silence_and_a_boot_behind_an_abort_are_no_answers_to_it() -> None:
    silence = cause_of(violation(IDLE_AFTERWARDS, NoAnswer()), IDLE_AFTERWARDS, ABORT)
    assert silence == Cause(IDLE_AFTERWARDS.id, *NO_ANSWER, "behind abort")
    boot = cause_of(violation(NO_REBOOT, "the device booted"), NO_REBOOT, ABORT)
    assert boot.rule_id == NO_REBOOT.id


def test_what_answers_a_frame_that_is_hardly_an_abort_is_called_by_its_rule() -> None:
    odd = Abort(MUX, AbortCode.GENERAL_ERROR, reserved_bits=1)
    cause = cause_of(violation(TOGGLE, from_hex("01 39 2C 74 3E 51 57 64")), TOGGLE, odd)
    assert cause.rule_id == TOGGLE.id


def test_a_cause_in_words() -> None:
    assert str(Cause(TOGGLE.id, "t=…")) == f"{TOGGLE.id}: t=…"
    refused = Cause(NOT_REFUSED.id, "abort", AbortCode.GENERAL_ERROR, "to upload initiate")
    assert str(refused) == f"{NOT_REFUSED.id}: abort 08000000h to upload initiate"


# What stands


CAUSE = Cause(TOGGLE.id, "t=…")


def test_what_was_met_beside_the_cases_is_aside_until_a_case_fails_for_it() -> None:
    causes = Causes()
    first = violation(TOGGLE, "t=1")
    causes.add(CAUSE, "the beginning of the run", first, aside=True)
    assert [cause for cause, _ in causes.aside()] == [CAUSE]
    later = violation(TOGGLE, "t=0")
    standing = causes.add(CAUSE, "a.case", later, aside=False)
    assert causes.aside() == []
    assert (standing.first_case, standing.violation) == ("a.case", later)


def test_the_case_that_met_it_first_stays() -> None:
    causes = Causes()
    for case_id in ("first", "second"):
        causes.add(CAUSE, case_id, violation(TOGGLE, "t=1"), aside=False)
    causes.add(CAUSE, "beside", violation(TOGGLE, "t=1"), aside=True)
    standing = causes.get(CAUSE)
    assert standing is not None
    assert (standing.first_case, standing.aside) == ("first", False)
    assert [cause for cause, _ in causes] == [CAUSE]
    assert causes.get(Cause(TOGGLE.id, "another")) is None


@pytest.mark.parametrize(
    ("rule", "noisy", "answers_aborts"),
    [
        (rule_of("abort.not-answered"), True, True),
        (UNSOLICITED, True, False),
        (TOGGLE, False, False),
    ],
    ids=lambda value: value.id if isinstance(value, Rule) else str(value),
)
def test_what_the_suite_has_to_mind(rule: Rule, *, noisy: bool, answers_aborts: bool) -> None:
    causes = Causes()
    assert not causes.noisy
    causes.add(Cause(rule.id, "an answer"), "a.case", violation(rule, "something"), aside=True)
    assert (causes.noisy, causes.aborts_are_answered) == (noisy, answers_aborts)


# One defect under several rules


@pytest.mark.parametrize(
    "rule_id", ["block-upload.not-started", "block-upload.foreign", "block-upload.over"]
)
def test_what_is_served_within_a_block_upload_is_one_cause(rule_id: str) -> None:
    served = violation(rule_of(rule_id), Received(BlockSegment(1, b"ABCDEFG", last=True)))
    assert str(cause_of(served, served.rule, READ)) == "block-upload.foreign: served"


def test_a_defect_is_told_as_what_it_is() -> None:
    found = violation(TOGGLE, Received(DownloadSegmentResponse(0)))
    found.told_as = GOES_ON
    assert cause_of(found, TOGGLE, READ) == GOES_ON


def test_giving_up_where_nothing_is_due_to_end_is_one_cause() -> None:
    """But not where a time-out is what the rule is about."""
    actual = Received(Abort(MUX, AbortCode.TIMED_OUT))
    for rule in (TOGGLE, rule_of("block-upload.invalid-block-size")):
        assert cause_of(violation(rule, actual), rule, READ) == GAVE_UP
    rule = rule_of("time-out.value")
    assert cause_of(violation(rule, actual), rule, READ) == Cause(rule.id, *TIMED_OUT)


def test_a_time_out_that_the_client_has_said_is_its_abort_come_back() -> None:
    given_up = Abort(MUX, AbortCode.TIMED_OUT)
    echoed = cause_of(
        violation(ABORT_NOT_ANSWERED, Received(given_up)), ABORT_NOT_ANSWERED, given_up
    )
    assert echoed == ABORT_ANSWERED


@pytest.mark.parametrize(
    "request_", [DownloadInitiate.with_size(MUX, None), BlockDownloadInitiate.with_size(MUX, None)]
)
def test_a_refusal_of_one_kind_of_request_is_one_cause(request_: Request) -> None:
    """Whatever rule is named where it is met again."""
    abort = Received(Abort(MUX, AbortCode.LENGTH_MISMATCH))
    causes, refusal = Causes(), violation(NOT_REFUSED, abort)
    known = cause_of(refusal, NOT_REFUSED, DownloadInitiate.with_size(MUX, None))
    causes.add(known, "a.case", refusal, aside=False)
    other = Cause("request.reserved-bytes", *abort.kind)
    assert causes.told_as(other, request_, "a.point", generated=False) == known
    assert causes.told_as(other, READ, "a.point", generated=False) == other


def test_a_state_of_the_matrix_tells_a_kind_of_answer_once() -> None:
    causes, silence = Causes(), violation(ANSWERED, NoAnswer())
    known, other = (cause_of(silence, ANSWERED, each) for each in (READ, UploadSegment()))
    causes.add(known, "a.case", silence, aside=False).shown_by.add("a.state")
    assert causes.told_as(other, UploadSegment(), "a.state", generated=True) == known
    assert causes.told_as(other, UploadSegment(), "another.state", generated=True) == other
    assert causes.told_as(other, UploadSegment(), "a.state", generated=False) == other


# Rules that one defect breaks together


@pytest.mark.parametrize(
    ("rule_id", "frame", "cause"),
    [
        (
            "segmented-download.number-too-short",
            "80 01 20 00 12 00 07 06",
            "download.too-short: abort 06070012h",
        ),
        (
            "segmented-download.number-too-short",
            "20 00 00 00 00 00 00 00",
            "segmented-download.number-too-short: download segment response",
        ),
        (
            "dictionary.structure",
            "80 00 10 FF 00 00 02 06",
            "object.sub-index-missing: abort 06020000h",
        ),
        ("frame.short-segment", "20 00 00 00 00 00 00 00", "frame.short: served"),
        ("frame.short-download", "60 02 20 00 00 00 00 00", "frame.short: served"),
        (
            "segmented-download.block-frames",
            "A4 00 00 00 7F 00 00 00",
            "segmented-download.upload-segment: served",
        ),
        (
            "segmented-upload.block-frames",
            "20 00 00 00 00 00 00 00",
            "segmented-upload.download-segment: served",
        ),
        ("download.too-long", "60 00 20 00 00 00 00 00", "download.too-long: taken"),
        (
            "object.sub-index-missing",
            "43 00 10 01 92 01 00 00",
            "object.sub-index-missing: served",
        ),
        (
            "abort.code",
            "80 00 10 00 FF 00 00 00",
            "abort.code: abort with a code that is none",
        ),
        ("block-upload.not-started", "01 41 42 43 44 45 46 47", "block-upload.foreign: served"),
    ],
)
def test_what_one_defect_breaks_in_several_places_is_one_cause(
    rule_id: str, frame: str, cause: str
) -> None:
    rule = rule_of(rule_id)
    assert str(cause_of(violation(rule, from_hex(frame)), rule, READ)) == cause


def test_silence_is_told_by_the_rule_that_it_breaks() -> None:
    rule = rule_of("frame.short-segment")
    assert cause_of(violation(rule, NoAnswer()), rule, READ) == Cause(rule.id, *NO_ANSWER)


def test_wrong_data_are_one_cause_whatever_was_asked_last() -> None:
    wrong = violation(IDLE_AFTERWARDS, Data(b"\1\2\3\4"))
    causes = {cause_of(wrong, IDLE_AFTERWARDS, request) for request in (READ, UploadSegment(0))}
    assert causes == {Cause(IDLE_AFTERWARDS.id, *OTHER_DATA)}


def test_a_remote_frame_is_no_request() -> None:
    silence = violation(ANSWERED, NoAnswer("nothing within 1000 ms"))
    cause = cause_of(silence, ANSWERED, RemoteFrame(b"", 8))
    assert cause == Cause(ANSWERED.id, *NO_ANSWER, "to remote frame")


def test_a_served_sub_index_ffh_is_one_of_those_that_are_served() -> None:
    causes = Causes()
    assert causes.told_as(STRUCTURE, READ, "a.case", generated=False) == STRUCTURE
    causes.add(SERVED, "a.case", violation(NOT_REFUSED, "served"), aside=False)
    assert causes.told_as(STRUCTURE, READ, "a.case", generated=False) == SERVED


@pytest.mark.parametrize(
    "rule_id", ["block-upload.above-threshold", "block.unsupported", "response.specifier"]
)
def test_an_ordinary_upload_for_a_block_upload_is_one_cause(rule_id: str) -> None:
    ordinary = violation(rule_of(rule_id), from_hex("43 10 20 01 92 01 00 00"))
    cause = cause_of(ordinary, ordinary.rule, BlockUploadInitiate(MUX, 127))
    assert cause == SWITCHED


def test_an_ordinary_upload_of_another_object_is_no_answer_to_a_block_upload() -> None:
    late = violation(SPECIFIER, from_hex("43 00 10 00 92 01 00 00"))
    cause = cause_of(late, late.rule, BlockUploadInitiate(MUX, 127))
    assert cause == Cause(
        "response.specifier", "upload initiate response", request="to block upload initiate"
    )


WRONG = violation(NOT_REFUSED, Data(b"\1\2"))


def other_data(rule_id: str) -> Cause:
    return Cause(rule_id, *OTHER_DATA)


def test_wrong_data_under_many_rules_are_values_that_do_not_read_as_they_were_written() -> None:
    causes, last = Causes(), other_data("data.empty")
    for number in range(MANY_RULES):
        assert causes.told_as(last, READ, "a.case", generated=False) == last
        causes.add(other_data(f"a.rule-{number}"), "a.case", WRONG, aside=False)
    assert causes.told_as(last, READ, "a.case", generated=False) == VALUES_WRONG
    known = other_data("a.rule-0")
    assert causes.told_as(known, READ, "a.case", generated=False) == known, "it has been told"
    general = other_data(IDLE_AFTERWARDS.id)
    causes.add(general, "a.case", WRONG, aside=False)
    assert causes.told_as(last, READ, "a.case", generated=False) == general


@pytest.mark.parametrize(
    ("rule_id", "request_"),
    [("block-upload.acknowledged", READ), (IDLE_AFTERWARDS.id, BlockAck(1, 2))],
)
def test_wrong_data_of_a_block_upload_are_one_cause(rule_id: str, request_: Request) -> None:
    causes, other = Causes(), other_data(rule_id)
    assert causes.told_as(other, request_, "a.case", generated=False) == other
    causes.add(IN_BLOCKS, "a.case", WRONG, aside=False)
    assert causes.told_as(other, request_, "a.case", generated=False) == IN_BLOCKS


def test_a_server_that_refuses_whatever_is_asked_is_one_cause() -> None:
    device = Multiplexer(0x1000)
    refusals = [Abort(device, AbortCode.LOCAL_CONTROL)] * 2
    refused = blocked(refusals, device)
    assert refused is not None
    causes = Causes()
    causes.add(refused, "a.case", WRONG, aside=False)
    met = cause_of(violation(NOT_REFUSED, Received(refusals[0])), NOT_REFUSED, READ)
    assert causes.told_as(met, READ, "a.case", generated=False) == refused
    elsewhere = Abort(MUX, AbortCode.LOCAL_CONTROL)
    assert blocked([elsewhere, *refusals], device) == refused
    for others in ([], [elsewhere], [*refusals, Abort(device, AbortCode.TIMED_OUT)]):
        assert blocked(others, device) is None
