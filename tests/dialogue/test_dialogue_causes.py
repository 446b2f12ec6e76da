"""What counts as one cause: a rule, and the kind of answer without its numbers."""

import pytest

from conformance.dialogue.causes import (
    IN_BLOCKS,
    MANY_RULES,
    TIMED_OUT,
    VALUES_WRONG,
    Cause,
    Causes,
    blocked,
    cause_of,
    kind_of_request,
)
from conformance.dialogue.rule_families import NO_ANSWER
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.describe import in_words
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockSegment,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    RemoteFrame,
    Request,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
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
    Rule,
    Violation,
    rule_of,
)
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED

MUX = Multiplexer(0x2010, 1)
READ = UploadInitiate(MUX)
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)


def violation(rule: Rule, actual: str) -> Violation:
    return Violation(rule, expected="another thing", actual=actual)


def from_hex(frame: str) -> str:
    return in_words(decode_response(bytes.fromhex(frame)))


# Causes


@pytest.mark.parametrize(
    ("rule", "request_", "actual", "cause"),
    [
        # A rule of one place says all.
        (TOGGLE, READ, "t=1", "t=…"),
        # A general rule is told apart by the request.
        (ANSWERED, READ, "nothing within 1000 ms", "no answer to upload initiate"),
        (
            ANSWERED,
            BlockSegment(127, b"ABCDEFG"),
            "nothing within 1000 ms",
            "no answer to block segment …",
        ),
        (
            SPECIFIER,
            READ,
            "command specifier FFh, which is not defined",
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
            "no answer",
            "no answer behind download segment",
        ),
        (
            NO_REBOOT,
            Unknown(b"\xff" + bytes(7)),
            "the device booted",
            "the device booted behind command specifier …",
        ),
        # The code of an abort that is wrong as such does not matter.
        (MULTIPLEXER, READ, from_hex("80 00 00 00 00 00 02 06"), "abort"),
        (UNSOLICITED, READ, from_hex("80 10 20 01 00 00 00 08"), "abort to upload initiate"),
        # Every other length is the same breach.
        (FRAME_SHAPE, READ, "585#4300100091 (DLC 5)", "another length than 8"),
        (
            FRAME_SHAPE,
            READ,
            "585#4300100091010F00 (a 29-bit identifier)",
            "a …-bit identifier",
        ),
    ],
)
def test_cause(rule: Rule, request_: Request, actual: str, cause: str) -> None:
    assert cause_of(violation(rule, actual), rule, request_) == Cause(rule.id, cause)


@pytest.mark.parametrize("rule", [UNSOLICITED, MULTIPLEXER, SPECIFIER, IDLE_AFTERWARDS])
@pytest.mark.parametrize("frame", ["80 10 20 01 00 00 00 08", "43 00 10 00 91 01 0F 00"])
def test_whatever_answers_an_abort_is_one_cause(rule: Rule, frame: str) -> None:
    cause = cause_of(violation(rule, from_hex(frame)), rule, ABORT)
    assert cause == Cause("abort.not-answered", "an answer")


def test_silence_and_a_boot_behind_an_abort_are_no_answers_to_it() -> None:
    silence = cause_of(violation(IDLE_AFTERWARDS, "no answer"), IDLE_AFTERWARDS, ABORT)
    assert silence == Cause(IDLE_AFTERWARDS.id, "no answer behind abort")
    boot = cause_of(violation(NO_REBOOT, "the device booted"), NO_REBOOT, ABORT)
    assert boot.rule_id == NO_REBOOT.id


def test_what_answers_a_frame_that_is_hardly_an_abort_is_called_by_its_rule() -> None:
    odd = Abort(MUX, AbortCode.GENERAL_ERROR, reserved_bits=1)
    cause = cause_of(violation(TOGGLE, from_hex("01 39 2C 74 3E 51 57 64")), TOGGLE, odd)
    assert cause.rule_id == TOGGLE.id


def test_a_cause_in_words() -> None:
    assert str(Cause(TOGGLE.id, "t=…")) == f"{TOGGLE.id}: t=…"


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


# One habit under several rules


@pytest.mark.parametrize(
    "rule_id", ["block-upload.not-started", "block-upload.foreign", "block-upload.over"]
)
def test_what_is_served_within_a_block_upload_is_one_cause(rule_id: str) -> None:
    served = violation(rule_of(rule_id), "block segment 1, last: 41")
    assert str(cause_of(served, served.rule, READ)) == "block-upload.foreign: served"


def test_a_habit_is_told_as_what_it_is() -> None:
    found = violation(TOGGLE, "download segment response, t=0")
    found.habit = ("server.nothing-afterwards", "the transfer goes on")
    assert str(cause_of(found, TOGGLE, READ)) == "server.nothing-afterwards: the transfer goes on"


def test_giving_up_where_nothing_is_due_to_end_is_one_cause() -> None:
    """But not where a time-out is what the rule is about."""
    actual = in_words(Abort(MUX, AbortCode.TIMED_OUT))
    cause = f"{UNSOLICITED.id}: {TIMED_OUT} though no transfer is due to end"
    for rule in (TOGGLE, rule_of("block-upload.invalid-block-size")):
        assert str(cause_of(violation(rule, actual), rule, READ)) == cause
    rule = rule_of("time-out.value")
    assert cause_of(violation(rule, actual), rule, READ) == Cause(rule.id, TIMED_OUT)


def test_a_time_out_that_the_client_has_said_is_its_abort_come_back() -> None:
    given_up = Abort(MUX, AbortCode.TIMED_OUT)
    echoed = cause_of(
        violation(ABORT_NOT_ANSWERED, in_words(given_up)), ABORT_NOT_ANSWERED, given_up
    )
    assert echoed == Cause(ABORT_NOT_ANSWERED.id, "an answer")


@pytest.mark.parametrize(
    "request_", [DownloadInitiate.with_size(MUX, None), BlockDownloadInitiate.with_size(MUX, None)]
)
def test_a_refusal_of_one_kind_of_request_is_one_cause(request_: Request) -> None:
    """Whatever rule is named where it is met again."""
    causes, refusal = Causes(), violation(NOT_REFUSED, "abort 2010h:01, 06070010h (length)")
    known = cause_of(refusal, NOT_REFUSED, DownloadInitiate.with_size(MUX, None))
    causes.add(known, "a.case", refusal, aside=False)
    other = Cause("request.reserved-bytes", "abort 06070010h")
    assert causes.told_as(other, request_, "a.point", generated=False) == known
    assert causes.told_as(other, READ, "a.point", generated=False) == other


def test_a_state_of_the_matrix_tells_a_kind_of_answer_once() -> None:
    causes, silence = Causes(), violation(ANSWERED, "nothing within 250 ms")
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
    assert cause_of(violation(rule, "no answer"), rule, READ) == Cause(rule.id, NO_ANSWER)


def test_wrong_data_are_one_cause_whatever_was_asked_last() -> None:
    wrong = violation(IDLE_AFTERWARDS, "4 bytes: 01 02 03 04")
    causes = {cause_of(wrong, IDLE_AFTERWARDS, request) for request in (READ, UploadSegment(0))}
    assert causes == {Cause(IDLE_AFTERWARDS.id, "other data")}


def test_reserved_bits_make_no_other_request() -> None:
    assert kind_of_request(UploadInitiate(MUX, reserved_bits=1)) == "upload initiate"
    assert kind_of_request(BlockAck(1, 2, reserved=b"\1\2\3\4\5")) == "block acknowledgement"


def test_a_remote_frame_is_no_request() -> None:
    silence = violation(ANSWERED, "nothing within 1000 ms")
    cause = cause_of(silence, ANSWERED, RemoteFrame(b"", 8))
    assert cause == Cause(ANSWERED.id, "no answer to remote frame")


def test_a_served_sub_index_ffh_is_one_of_those_that_are_served() -> None:
    structure = Cause("dictionary.structure", "other data")
    causes = Causes()
    assert causes.told_as(structure, READ, "a.case", generated=False) == structure
    served = Cause("object.sub-index-missing", "served")
    causes.add(served, "a.case", violation(NOT_REFUSED, "served"), aside=False)
    assert causes.told_as(structure, READ, "a.case", generated=False) == served


@pytest.mark.parametrize(
    "rule_id", ["block-upload.above-threshold", "block.unsupported", "response.specifier"]
)
def test_an_ordinary_upload_for_a_block_upload_is_one_cause(rule_id: str) -> None:
    ordinary = violation(rule_of(rule_id), from_hex("43 10 20 01 92 01 00 00"))
    cause = cause_of(ordinary, ordinary.rule, BlockUploadInitiate(MUX, 127))
    assert cause == Cause("block-upload.no-switch", "upload initiate response")


def test_an_ordinary_upload_of_another_object_is_no_answer_to_a_block_upload() -> None:
    late = violation(SPECIFIER, from_hex("43 00 10 00 92 01 00 00"))
    cause = cause_of(late, late.rule, BlockUploadInitiate(MUX, 127))
    assert cause == Cause("response.specifier", "upload initiate response to block upload initiate")


OTHER_DATA = violation(NOT_REFUSED, "2 bytes: 01 02")


def other_data(rule_id: str) -> Cause:
    return Cause(rule_id, "other data")


def test_wrong_data_under_many_rules_are_values_that_do_not_read_as_they_were_written() -> None:
    causes, last = Causes(), other_data("data.empty")
    for number in range(MANY_RULES):
        assert causes.told_as(last, READ, "a.case", generated=False) == last
        causes.add(other_data(f"a.rule-{number}"), "a.case", OTHER_DATA, aside=False)
    assert causes.told_as(last, READ, "a.case", generated=False) == VALUES_WRONG
    known = other_data("a.rule-0")
    assert causes.told_as(known, READ, "a.case", generated=False) == known, "it has been told"
    general = other_data(IDLE_AFTERWARDS.id)
    causes.add(general, "a.case", OTHER_DATA, aside=False)
    assert causes.told_as(last, READ, "a.case", generated=False) == general


@pytest.mark.parametrize(
    ("rule_id", "request_"),
    [("block-upload.acknowledged", READ), (IDLE_AFTERWARDS.id, BlockAck(1, 2))],
)
def test_wrong_data_of_a_block_upload_are_one_cause(rule_id: str, request_: Request) -> None:
    causes, other = Causes(), other_data(rule_id)
    assert causes.told_as(other, request_, "a.case", generated=False) == other
    causes.add(IN_BLOCKS, "a.case", OTHER_DATA, aside=False)
    assert causes.told_as(other, request_, "a.case", generated=False) == IN_BLOCKS


def test_a_server_that_refuses_whatever_is_asked_is_one_cause() -> None:
    device = Multiplexer(0x1000)
    refusals = [Abort(device, AbortCode.LOCAL_CONTROL)] * 2
    habit = blocked(refusals, device)
    assert habit is not None
    causes = Causes()
    causes.add(Cause(*habit), "a.case", OTHER_DATA, aside=False)
    met = cause_of(violation(NOT_REFUSED, in_words(refusals[0])), NOT_REFUSED, READ)
    assert causes.told_as(met, READ, "a.case", generated=False) == Cause(*habit)
    elsewhere = Abort(MUX, AbortCode.LOCAL_CONTROL)
    assert blocked([elsewhere, *refusals], device) == habit
    for others in ([], [elsewhere], [*refusals, Abort(device, AbortCode.TIMED_OUT)]):
        assert blocked(others, device) is None
