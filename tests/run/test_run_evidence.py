"""What a failure shows: the frames in words, the middle of many left out, and how to send them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import pytest

from conformance.bus.link import Captured, Direction
from conformance.device.not_testable import Lack, Missing
from conformance.run.evidence import (
    cansend_lines,
    evidence_text,
    line_text,
)
from conformance.run.trace import ASIDE, FIRST_LINES, LAST_LINES, TraceLine, trace_of
from conformance.run.verdict import Afterwards, CaseResult, Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.rules import Cause

MOST = FIRST_LINES + LAST_LINES


def captured(frame: CanFrame, seconds: float = 0.0, *, sent: bool = True) -> Captured:
    return Captured(1000.0 + seconds, Direction.SENT if sent else Direction.RECEIVED, frame)


def frame(can_id: int, data: str) -> CanFrame:
    return CanFrame(can_id, bytes.fromhex(data))


def reads(number: int) -> list[Captured]:
    return [captured(frame(0x605, f"4018100{n % 10} 00000000"), n / 1000) for n in range(number)]


def lines(frames: list[Captured], own: int | None = None) -> list[str]:
    shown = trace_of(frames, [ChannelIds.default(5)], own=own)
    return [line_text(line) for line in shown.lines]


def test_frames_in_words() -> None:
    frames = [
        captured(frame(0x605, "2110200009000000")),
        captured(frame(0x585, "6010200000000000"), 0.0015, sent=False),
        captured(frame(0x605, "0041424344454647"), 0.002),
        captured(frame(0x585, "2000000000000000"), 1.25, sent=False),
        captured(frame(0x705, "00"), 1.3, sent=False),
        captured(CanFrame(0x605, frame(0, "4000100000000000").data, extended=True), 1.4),
        captured(CanFrame(0x605, remote=True, length=8), 1.5),
        captured(frame(0x585, "4300"), 1.6, sent=False),
    ]
    shape = "not a data frame of 8 bytes with an 11-bit identifier"
    assert lines(frames) == [
        "      0.0 ms > 605#2110200009000000 download initiate 2010h:00, segmented, 9 bytes",
        "      1.5 ms < 585#6010200000000000 download initiate response 2010h:00",
        "      2.0 ms > 605#0041424344454647 download segment, t=0, 7 bytes: 41 42 43 44 45 46 47",
        "   1250.0 ms < 585#2000000000000000 download segment response, t=0",
        "   1300.0 ms < 705#00               boot-up of node 5",
        f"   1400.0 ms > 00000605#4000100000000000 DLC 8, {shape}",
        f"   1500.0 ms > 605#R8               DLC 8, {shape}",
        f"   1600.0 ms < 585#4300             DLC 2, {shape}",
    ]


def test_the_frame_that_was_wrong_is_marked_though_others_follow() -> None:
    frames = [
        captured(frame(0x605, "2010200000000000")),
        captured(frame(0x585, "8010200010000706"), 0.001, sent=False),
        captured(frame(0x605, "2110200007000000"), 0.002),
        captured(frame(0x585, "6010200000000000"), 0.003, sent=False),
    ]
    ids = [ChannelIds.default(5)]
    for shown, marked in (((frames[1].frame.data,), 1), ((), 3)):
        assert trace_of(frames, ids, decisive=True, shown=shown).decisive == marked


def marked(frames: Sequence[Captured]) -> int | None:
    return trace_of(frames, [ChannelIds.default(5)], decisive=True).decisive


def test_of_a_silence_the_first_request_without_an_answer_is_marked() -> None:
    """Behind it the suite aborts and reads, in vain."""
    answered = [
        captured(frame(0x605, "4000100000000000")),
        captured(frame(0x585, "4300100091010F00"), 0.001, sent=False),
    ]
    lost = [captured(frame(0x605, data), 0.002) for data in ("E000", "8000", "4000100000000000")]
    assert marked([*answered, *lost]) == 2
    assert marked([*answered, lost[0], *answered]) == 4, "the read behind it is answered"
    burst = [captured(frame(0x605, f"{number:02X}" + "00" * 7)) for number in range(1, 10)]
    assert marked([*answered, *burst]) == 10, "of a burst the last is to be answered"


def test_no_frames() -> None:
    assert lines([]) == []
    assert lines([], own=0) == []
    assert cansend_lines([], "can0") == []


def test_where_the_case_ends() -> None:
    assert lines(reads(3), own=2) == [*lines(reads(3))[:2], ASIDE, lines(reads(3))[2]]
    assert lines(reads(3), own=0)[0] == ASIDE
    assert lines(reads(3), own=3) == lines(reads(3))


def test_as_many_as_may_be_are_shown() -> None:
    assert len(lines(reads(MOST))) == MOST


@pytest.mark.parametrize("number", [MOST + 1, MOST + 7, 5000])
def test_the_middle_of_many_is_left_out(number: int) -> None:
    frames = reads(number)
    whole = [lines([one])[0][13:] for one in frames]
    shown = lines(frames)
    mark = f"… {number - MOST} frames left out; bus.log has them all"
    assert shown[FIRST_LINES] == mark
    assert [line[13:] for line in shown[:FIRST_LINES]] == whole[:FIRST_LINES]
    assert [line[13:] for line in shown[FIRST_LINES + 1 :]] == whole[-LAST_LINES:]


def test_what_is_left_out_is_followed_all_the_same() -> None:
    """A segment at the end is read by the initiate that is not shown."""
    block = [captured(frame(0x605, "0041424344454647")) for _ in range(MOST + 20)]
    initiate = captured(frame(0x605, "2110200009000000"))
    shown = lines([*reads(FIRST_LINES), initiate, *block])
    assert shown[-1].endswith("download segment, t=0, 7 bytes: 41 42 43 44 45 46 47")


@pytest.mark.parametrize("own", [FIRST_LINES, FIRST_LINES + 10, FIRST_LINES + 100])
def test_where_the_case_ends_is_shown_also_among_what_is_left_out(own: int) -> None:
    shown = lines(reads(MOST + 100), own=own)
    assert shown.count(ASIDE) == 1
    assert FIRST_LINES <= shown.index(ASIDE) <= FIRST_LINES + 1


def test_what_was_sent_as_commands() -> None:
    frames = [
        captured(frame(0x605, "4000100000000000")),
        captured(frame(0x585, "4300100091010F00"), sent=False),
        captured(CanFrame(0x605, remote=True, length=8)),
        captured(CanFrame(0x605, b"\x40", extended=True)),
    ]
    assert cansend_lines(frames, "vcan1") == [
        "cansend vcan1 605#4000100000000000",
        "cansend vcan1 605#R8",
        "cansend vcan1 00000605#40",
    ]


def test_the_middle_of_many_commands_is_a_comment() -> None:
    shown = cansend_lines(reads(MOST + 5), "can0")
    assert len(shown) == MOST + 1
    assert shown[FIRST_LINES] == "# … 5 frames left out; bus.log has them all"
    assert len(cansend_lines(reads(MOST), "can0")) == MOST


RESULT = CaseResult(
    case_id="upload.size[8]",
    service="expedited upload",
    node_id=5,
    level="MUST",
    clause="7.2.4.3.6",
    requirement="A sentence.",
    verdict=Verdict.FAIL,
    broken_rule="response.toggle",
    broken_sentence="Another sentence.",
    expected="t=0",
    actual="t=1",
    afterwards=Afterwards.NEEDED_ABORT,
    notes=["also this", "and that"],
    trace=[TraceLine("upload initiate 1000h:00", "605#4000100000000000", sent=True)],
    reproduce=["cansend can0 605#4000100000000000"],
)


def test_everything_that_a_failure_has_to_show() -> None:
    assert evidence_text(RESULT).splitlines() == [
        "upload.size[8]: FAIL (MUST, CiA 301 clause 7.2.4.3.6, node 5)",
        "  requirement: A sentence.",
        "  broken rule: response.toggle: Another sentence.",
        "  expected: t=0",
        "  actual: t=1",
        "  afterwards: needed an abort",
        "  note: also this",
        "  note: and that",
        "  frames (> sent, < received):",
        "        0.0 ms > 605#4000100000000000 upload initiate 1000h:00",
        "  to repeat what was sent:",
        "    cansend can0 605#4000100000000000",
    ]


def test_the_sentence_of_a_case_that_is_broken_itself_stands_once() -> None:
    result = replace(RESULT, broken_rule="upload.size", broken_sentence="A sentence.")
    assert "  broken rule: upload.size" in evidence_text(result).splitlines()


def test_a_result_survives_being_written_and_read() -> None:
    cause = Cause("response.toggle", "abort", AbortCode.GENERAL_ERROR)
    result = replace(RESULT, cause=cause, met=[cause], state="idle", stimulus="40h")
    result.missing, result.decisive = Missing(Lack.PERMISSION, "nmt"), 0
    values = result.as_dict()
    assert CaseResult.from_dict(values) == result
    assert set(map(type, each_in(values))) <= {str, int, float, bool, list, dict, type(None)}


def each_in(values: Any) -> Iterator[Any]:
    """Yield a value and all within it."""
    yield values
    inner = values.values() if isinstance(values, dict) else values
    for each in inner if isinstance(values, dict | list) else ():
        yield from each_in(each)
