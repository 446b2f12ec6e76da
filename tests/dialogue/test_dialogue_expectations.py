"""The point of a case: what is expected, what is accepted with a remark, and what fails it."""

from collections.abc import Callable

import pytest
from support.run_bench import (
    HASTY,
    NODE_ID,
    NUMBER,
    RULE,
    TEXT,
    Scripted,
    discovered,
    recording,
    undiscovered,
)

from conformance.dialogue.dialogue import Dialogue
from conformance.faults.catalogue import build_node
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    DownloadInitiateResponse,
    Response,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.rules import (
    FILLER,
    MULTIPLEXER,
    NOT_REFUSED,
    RESERVED,
    RESTART,
    SPECIFIER,
    SUBSTITUTE,
    UNSOLICITED,
    Violation,
)
from conformance.sdo.rules.defects import GOES_ON, OLD_GOES_ON

READ = UploadInitiate(Multiplexer(0x1018, 1))
OTHER = Multiplexer(0x1018, 2)
MISSING = AbortCode.OBJECT_MISSING
REFUSED = Abort(READ.mux, MISSING)
SERVED = "43 18 10 01 00 00 0C 5D"
BASELINE = "43 00 10 00 91 01 0F 00"


def converse(
    step: Callable[[Dialogue], object], *answers: Message | str, request: Message = READ
) -> Dialogue:
    """Send a request that is answered as given, take ``step``, and return what was noted."""
    frames = [bytes.fromhex(a) if isinstance(a, str) else a.encode() for a in answers]
    fence = bytes.fromhex(BASELINE)

    def answer(data: bytes) -> list[bytes]:
        if data[0] == 0x80:
            return []
        return [fence] if data[1:4] == b"\x00\x10\x00" else frames

    with undiscovered(Scripted(answer)) as bench:
        sdo = bench.dialogue()
        sdo.send(request)
        step(sdo)
    return sdo


def breach(step: Callable[[Dialogue], object], *answers: Message | str) -> Violation:
    with pytest.raises(Violation) as raised:
        converse(step, *answers)
    return raised.value


def minor(sdo: Dialogue) -> list[str]:
    return [violation.rule.id for violation in sdo.record.minor]


# Exactly this response


def test_exactly_this_response() -> None:
    converse(lambda sdo: sdo.expect(DownloadInitiateResponse(TEXT.mux)), "60 10 20 00 00 00 00 00")


@pytest.mark.parametrize(
    "answer", ["60 10 20 01 00 00 00 00", "61 10 20 00 00 00 00 00", "60 10 20 00 00 00 00 01"]
)
def test_not_exactly_this_response(answer: str) -> None:
    found = breach(lambda sdo: sdo.expect(DownloadInitiateResponse(TEXT.mux)), answer)
    assert found.rule is RULE
    assert answer in found.actual
    assert "60 10 20 00 00 00 00 00" in found.expected


# Aborts


def expect_missing(sdo: Dialogue) -> None:
    sdo.expect_abort(MISSING, of=READ.mux)


def test_an_abort() -> None:
    assert minor(converse(expect_missing, REFUSED)) == []
    either = (AbortCode.SUB_INDEX_MISSING, MISSING)
    assert minor(converse(lambda sdo: sdo.expect_abort(*either, of=None), REFUSED)) == []


def test_an_abort_with_general_error_counts_as_a_should() -> None:
    sdo = converse(expect_missing, Abort(READ.mux, AbortCode.GENERAL_ERROR))
    assert [violation.rule for violation in sdo.record.minor] == [SUBSTITUTE]
    assert "06020000h" in sdo.record.minor[0].expected
    assert "08000000h" in sdo.record.minor[0].actual


def test_general_error_is_not_always_tolerated() -> None:
    found = breach(
        lambda sdo: sdo.expect_abort(MISSING, of=READ.mux, tolerated=()),
        Abort(READ.mux, AbortCode.GENERAL_ERROR),
    )
    assert found.rule is RULE


def test_an_abort_with_another_code() -> None:
    found = breach(expect_missing, Abort(READ.mux, AbortCode.READ_OF_WRITE_ONLY))
    assert found.rule is RULE
    assert found.expected == "abort with 06020000h (object does not exist)"
    assert "06010001h" in found.actual


def test_an_abort_with_a_code_of_its_own() -> None:
    assert breach(expect_missing, Abort(READ.mux, 0x0F00FFC0)).rule.id == "abort.code"


def test_no_abort() -> None:
    found = breach(expect_missing, SERVED)
    assert found.rule is RULE
    assert SERVED in found.actual


def test_an_abort_of_another_object_fails_the_case_and_lets_it_go_on() -> None:
    sdo = converse(expect_missing, Abort(OTHER, MISSING))
    assert [violation.rule for violation in sdo.record.minor] == [MULTIPLEXER]
    assert (
        minor(converse(lambda sdo: sdo.expect_abort(MISSING, of=None), Abort(OTHER, MISSING))) == []
    )


def test_an_abort_with_reserved_bits() -> None:
    sdo = converse(expect_missing, Abort(READ.mux, MISSING, 1))
    with pytest.raises(Violation) as raised:
        sdo.expect_clean(RESERVED)
    assert raised.value.rule is RESERVED
    sdo.expect_clean(FILLER)


# Silence


def test_nothing() -> None:
    converse(Dialogue.expect_nothing)
    found = breach(Dialogue.expect_nothing, REFUSED)
    assert (found.rule, found.expected) == (RULE, "no answer")
    assert breach(Dialogue.expect_nothing, REFUSED, REFUSED).rule is UNSOLICITED


def test_silence_or_an_abort() -> None:
    for answers in ([], [REFUSED], [Abort(OTHER, MISSING)]):
        converse(lambda sdo: sdo.expect_silence_or_abort(MISSING), *answers)
        converse(Dialogue.expect_silence_or_abort, *answers)
    for answer in (SERVED, Abort(READ.mux, AbortCode.GENERAL_ERROR)):
        found = breach(lambda sdo: sdo.expect_silence_or_abort(MISSING), answer)
        assert found.rule is RULE
    assert breach(Dialogue.expect_silence_or_abort, Abort(READ.mux, 0)).rule.id == "abort.code"


def test_a_request_of_a_transfer_that_is_over() -> None:
    with discovered(recording()) as bench:
        bench.dialogue().expect_dead(UploadSegment(0))
    node = build_node("upload-segment-without-initiate", NODE_ID)
    with discovered(node) as bench, pytest.raises(Violation) as raised:
        bench.dialogue().expect_dead(UploadSegment(0))
    assert raised.value.rule is RULE


NAME = Multiplexer(0x1008)


def test_what_a_server_has_aborted_and_lets_go_on_is_one_cause() -> None:
    node = build_node("abort-in-transfer-unnamed", NODE_ID)
    with discovered(node) as bench:
        sdo = bench.dialogue()
        sdo.start_segmented_upload(NAME)
        sdo.send(UploadSegment(1))
        sdo.receive()
        with pytest.raises(Violation) as raised:
            sdo.expect_dead(UploadSegment(0))
    assert raised.value.told_as == GOES_ON


def test_segments_behind_an_abort_may_each_be_refused_and_not_be_taken() -> None:
    converse(Dialogue.expect_refusals, REFUSED, REFUSED)
    assert breach(Dialogue.expect_refusals, REFUSED, SERVED).told_as == GOES_ON


def test_a_transfer_that_goes_on_behind_a_new_one_is_one_cause() -> None:
    with discovered(build_node("initiate-joins-running-transfer", NODE_ID)) as bench:
        sdo = bench.dialogue()
        sdo.start_segmented_upload(NAME)
        sdo.upload_segment(toggle=0)
        sdo.start_segmented_upload(NAME)
        with pytest.raises(Violation) as raised, sdo.one_transfer():
            sdo.upload_segment(toggle=0)
    assert raised.value.rule is NOT_REFUSED, "for its toggle bit"
    assert raised.value.told_as == OLD_GOES_ON


def test_a_known_cause_keeps_its_name_in_a_new_transfer() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        known = Violation(RULE, expected="7 bytes", actual="8 bytes")
        sdo.record.causes.add(
            sdo.record.cause_of(known, sdo.wire.last_sent), "a.case", known, aside=False
        )
        with pytest.raises(Violation) as raised, sdo.one_transfer():
            raise known
    assert raised.value.told_as is None


# Served or refused


def test_an_upload_or_an_abort() -> None:
    known = TEXT

    def expect(sdo: Dialogue) -> None:
        sdo.expect_upload_or_abort(known, b"text", MISSING, warned=(AbortCode.LOCAL_CONTROL,))

    text = "43 10 20 00 74 65 78 74"
    read = UploadInitiate(TEXT.mux)
    assert minor(converse(expect, text, request=read)) == []
    assert minor(converse(expect, Abort(OTHER, MISSING), request=read)) == []
    warned = converse(expect, Abort(TEXT.mux, AbortCode.LOCAL_CONTROL), request=read)
    assert len(warned.record.minor) == 1
    for answer in ("43 10 20 00 74 65 78 75", Abort(TEXT.mux, AbortCode.OUT_OF_MEMORY)):
        assert breach(expect, answer).rule is RULE


def test_a_download_or_an_abort() -> None:
    def expect(sdo: Dialogue) -> None:
        sdo.expect_download_or_abort(TEXT, AbortCode.COMMAND_NOT_VALID)

    converse(expect, DownloadInitiateResponse(TEXT.mux))
    converse(expect, Abort(OTHER, AbortCode.COMMAND_NOT_VALID))
    assert breach(expect, REFUSED).rule is RULE
    assert breach(expect, DownloadInitiateResponse(OTHER)).rule is MULTIPLEXER
    assert breach(expect, SERVED).rule is SPECIFIER


def test_a_restart_or_an_abort() -> None:
    new = UploadInitiate(OTHER)

    def expect(sdo: Dialogue) -> Response | None:
        sdo.fence()  # behind the answers to the first request
        sdo.channel.response_timeout = HASTY
        return sdo.expect_restart_or_abort(new, TEXT, OTHER)

    served = "43 18 10 02 00 00 00 00"
    assert minor(converse(expect, served)) == []
    for mux in (TEXT.mux, OTHER):
        refused = converse(expect, Abort(mux, AbortCode.COMMAND_NOT_VALID))
        assert [violation.rule for violation in refused.record.minor] == [RESTART]
    both = converse(expect, Abort(TEXT.mux, AbortCode.GENERAL_ERROR), served)
    assert (minor(both), len(both.record.notes)) == ([], 1), (
        "the superseded transfer may be aborted"
    )
    assert breach(expect, Abort(NUMBER.mux, MISSING)).rule is RULE


# Segmented downloads that have to be refused

TOO_LONG = (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_MISMATCH)


@pytest.mark.parametrize(
    ("server", "size", "taken"),
    [(None, 14, 0), (None, None, 1), ("sizes-checked-at-the-end", 14, 2)],
)
def test_a_download_is_refused_at_a_moment_of_the_servers_choice(
    server: str | None, size: int | None, taken: int
) -> None:
    with discovered(build_node(server, NODE_ID)) as bench:
        sdo = bench.dialogue()
        before = sdo.upload(NUMBER)
        assert sdo.expect_download_refused(NUMBER, bytes(14), *TOO_LONG, size=size) == taken
        assert sdo.upload(NUMBER) == before


def test_a_download_that_is_not_refused() -> None:
    with discovered(recording()) as bench, pytest.raises(Violation) as raised:
        bench.dialogue().expect_download_refused(TEXT, bytes(9), *TOO_LONG, size=9)
    assert raised.value.rule is RULE
    assert raised.value.expected.endswith("at the last segment at the latest")
