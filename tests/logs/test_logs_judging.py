"""What ``decode --judge`` finds in conversations, and which it leaves alone."""

import pytest
from judged_logs import found_in, seen_in, told_of

from conformance.logs.judging import LogJudge
from conformance.logs.reading import Seen
from conformance.sdo.can_frame import CanFrame

IDLE = "0.0 > 80 00 00 00 00 00 04 05"
READ, SERVED = "> 40 18 10 01", "< 43 18 10 01 5D"
OTHER, OTHER_SERVED = "> 40 00 20 00", "< 43 00 20 00 01"
TIMED_OUT = "> 80 00 20 00 00 00 04 05"
END = "99.0 081#0000000000000000"
SAVE, SAVED = "> 23 10 10 01 73 61 76 65", "< 60 10 10 01"
WRITE, WRITTEN = "> 2F 00 20 00 01", "< 60 00 20 00"
BLOCK = ("0.1 > C2 10 20 00 0E", "0.101 < A0 10 20 00 7F")
BURST = ("0.102 > 01 30 31 32 33 34 35 36", "0.1021 > 82 37 38 39 3A 3B 3C 3D")


@pytest.mark.parametrize(
    "lines",
    [
        (f"0.1 {SAVE}", f"3.1 {SAVED}"),
        (f"0.1 {SAVE}", "0.4 > 80 10 10 01 00 00 04 05", f"0.7 {SAVED}", f"0.8 {READ}",
         f"0.801 {SERVED}"),
        (f"0.1 {SAVE}", f"1.1 {SAVE}", f"2.6 {SAVED}", f"2.7 {READ}", f"2.8 {SERVED}"),
        (f"0.1 {SAVE}", f"1.1 {SAVE}", f"2.6 {SAVED}", f"4.6 {SAVED}"),
        (f"0.1 {WRITE}", f"0.4 {WRITTEN}", f"0.5 {READ}", f"0.501 {SERVED}"),
        (f"0.1 {WRITE}", f"0.3 {TIMED_OUT}", f"0.4 {WRITTEN}", f"0.5 {READ}", f"0.501 {SERVED}"),
        (f"0.1 {WRITE}", f"0.3 {TIMED_OUT}", f"0.5 {READ}", f"0.501 {SERVED}", END),
        (f"0.1 {WRITE}", f"0.4 {WRITE}", f"0.5 {WRITTEN}", f"0.8 {WRITTEN}"),
        (f"0.1 {READ}", f"0.4 {READ}", f"0.5 {SERVED}", f"1.8 {OTHER}", f"1.9 {OTHER_SERVED}"),
        (f"0.1 {OTHER}", f"2.1 {READ}", f"2.2 {OTHER_SERVED}", f"2.3 {SERVED}"),
        (*BLOCK, *BURST, "1.6 < A2 02 7F", "1.7 > C1", "1.8 < A1"),
        (*BLOCK, *BURST, "1.9 > 80 10 20 00 00 00 04 05", f"2.0 {READ}", f"2.001 {SERVED}", END),
    ],
    ids=["save", "save-given-up", "save-repeated", "saved-twice", "eeprom", "eeprom-given-up",
         "given-up", "eeprom-repeated", "read-repeated", "in-order", "acknowledgement",
         "acknowledgement-given-up"],
)  # fmt: skip
def test_slow_answers_are_right(lines: tuple[str, ...]) -> None:
    assert found_in(IDLE, *lines) == []


@pytest.mark.parametrize(
    "lines",
    [
        (*BLOCK, "0.102 > 82 37 38 39 3A 3B 3C 3D", "0.152 < A2 00 7F"),
        (*BLOCK, *BURST, "1.1021 < 80 10 20 00 00 00 04 05"),
        (*BLOCK, "1.101 < 80 10 20 00 00 00 04 05"),
        ("0.1 > 21 10 20 00 14", "0.101 < 60 10 20 00", "1.101 < 80 10 20 00 00 00 04 05"),
        ("0.1 > 40 10 20 00", "0.101 < 41 10 20 00 14", "1.101 < 80 10 20 00 00 00 04 05"),
        ("0.1 > A0 10 20 00 10", "0.101 < C2 10 20 00 14", "1.101 < 80 10 20 00 00 00 04 05"),
    ],
    ids=["gap", "end-of-block", "sub-block", "download", "upload", "block-upload"],
)
def test_what_a_server_may_do_in_a_silence(lines: tuple[str, ...]) -> None:
    assert found_in(IDLE, *lines) == []


@pytest.mark.parametrize(
    "begun",
    [
        ("0.1 > 21 10 20 00 14", "0.101 < 60 10 20 00"),
        ("0.1 > 40 10 20 00", "0.101 < 41 10 20 00 14"),
        ("0.1 > A0 10 20 00 10", "0.101 < C2 10 20 00 14"),
        BLOCK,
        (*BLOCK, "0.102 > 01 30 31 32 33 34 35 36"),
    ],
    ids=["download", "upload", "block-upload", "block-download", "sub-block"],
)
@pytest.mark.parametrize("time", ["0.11", "0.14", "1.3"])
@pytest.mark.parametrize("code", ["22 00 00 08", "21 00 00 08", "00 00 00 08"])
def test_a_server_may_end_a_transfer_for_a_reason_of_its_own(
    begun: tuple[str, ...], time: str, code: str
) -> None:
    aborted = f"{time} < 80 10 20 00 {code}"
    assert found_in(IDLE, *begun, aborted, f"1.4 {READ}", f"1.401 {SERVED}") == []


def test_each_request_that_is_never_answered_is_found() -> None:
    asked = (f"0.1 {READ}", f"1.1 {OTHER}", f"2.1 {WRITE}")
    assert found_in(IDLE, *asked, "9.1 > 40 01 20 00", "9.101 < 4F 01 20 00", END) == [
        "2 response.answered", "3 response.answered", "4 response.answered",
    ]  # fmt: skip
    assert found_in(IDLE, *asked, END) == [
        "2 response.answered", "3 response.answered", "4 response.answered",
    ]  # fmt: skip
    assert found_in(IDLE, f"0.1 {READ}", f"1.1 {READ}", f"2.1 {READ}", END) == [
        "2 response.answered", "3 response.answered", "4 response.answered",
    ]  # fmt: skip


def test_requests_that_follow_soon_are_counted_too() -> None:
    missing = ["2 response.answered", "3 response.answered", "4 response.answered"]
    assert found_in(IDLE, f"0.1 {READ}", f"0.6 {OTHER}", f"1.1 {WRITE}", END) == missing
    assert found_in(IDLE, f"0.1 {READ}", f"0.6 {READ}", f"1.1 {READ}", END) == missing
    given_up = (f"0.1 {READ}", f"0.6 {TIMED_OUT}", f"0.7 {OTHER}", f"0.701 {OTHER_SERVED}", END)
    assert found_in(IDLE, *given_up) == []


def test_one_that_was_skipped_is_found() -> None:
    lines = (f"0.1 {READ}", f"1.1 {OTHER}", f"1.2 {OTHER_SERVED}", END)
    assert found_in(IDLE, *lines) == ["2 response.answered"]


def test_a_node_that_never_answers_has_no_endless_backlog() -> None:
    polls = [f"{1 + number * 1.5} > 40 {number % 250:02X} 20 00" for number in range(3000)]
    assert len(found_in(IDLE, *polls)) == 2999


@pytest.mark.parametrize(
    "lines",
    [
        ("0.1 605#40102000", f"0.2 {OTHER}", "0.201 < 41 10 20 00 07",
         "0.202 < 80 10 20 00 01 00 04 05"),
        ("0.1 605#40102000", f"0.2 {OTHER}", "0.201 < 80 00 00 00 01 00 04 05",
         f"0.202 {OTHER_SERVED}"),
        ("0.1 605#40102000", f"0.2 {OTHER}", f"0.202 {OTHER_SERVED}"),
    ],
    ids=["served", "refused", "ignored"],
)  # fmt: skip
def test_a_short_frame_may_be_served_refused_or_ignored(lines: tuple[str, ...]) -> None:
    assert found_in(IDLE, *lines) == []


def test_a_time_out_that_is_told_behind_the_abort_of_the_client_is_found() -> None:
    begun = ("0.1 > 40 10 20 00", "0.101 < 41 10 20 00 14")
    lines = (*begun, "0.2 > 80 10 20 00 00 00 00 08", "1.2 < 80 10 20 00 00 00 04 05")
    assert found_in(IDLE, *lines) == ["5 response.unsolicited"]


# A device that starts again


def test_a_boot_up_message_in_the_place_of_an_answer_is_found() -> None:
    served = (f"0.1 {READ}", f"0.11 {SERVED}")
    assert found_in(IDLE, *served, f"0.2 {OTHER}", "0.5 705#00") == ["4 server.no-reboot"]
    lines = (*served, f"0.2 {OTHER}", f"1.5 {READ}", "1.6 705#00")
    assert found_in(IDLE, *lines) == ["4 response.answered", "5 server.no-reboot"]


@pytest.mark.parametrize(
    "lines",
    [
        (f"0.1 {READ}", f"0.11 {SERVED}", "0.5 705#00"),
        (f"0.1 {READ}", f"0.11 {SERVED}", f"0.2 {OTHER}", "0.21 000#8105", "0.5 705#00"),
        (f"0.1 {READ}", f"0.11 {SERVED}", "0.15 000#8200", f"0.2 {OTHER}", "0.5 705#00"),
        (f"0.1 {READ}", f"1.1 {READ}", f"2.1 {READ}", "2.2 705#00", f"2.3 {READ}", f"2.4 {SERVED}"),
        (f"0.1 {READ}", "0.101 705#00", f"0.102 {SERVED}"),
        (f"0.1 {READ}", f"0.11 {SERVED}", "0.2 > 2F 51 1F 01 01", "0.9 705#00"),
    ],
    ids=[
        "asked-nothing",
        "told-to",
        "told-all",
        "not-there-before",
        "answered-behind-it",
        "program-started",
    ],
)
def test_boot_up_messages_that_are_right(lines: tuple[str, ...]) -> None:
    assert found_in(IDLE, *lines) == []


def test_behind_a_boot_up_message_the_server_is_idle() -> None:
    booted = ("0.1 000#8105", "0.5 705#00")
    assert found_in(*booted, "0.6 < 60 00 20 00") == ["3 response.unsolicited"]
    assert found_in(*booted, "0.6 > 60", "0.601 < 00 01 02 03 04 05 06 07") == [
        "4 segmented-upload.without-initiate"
    ]


# NMT: in Stopped nothing is answered


@pytest.mark.parametrize(
    "lines",
    [
        ("0.1 705#04", f"0.2 {READ}", f"0.201 {SERVED}"),
        ("0.1 000#0205", f"0.25 {READ}", f"0.251 {SERVED}"),
        ("0.1 000#0200", "0.15 705#04", f"0.25 {READ}", f"0.251 {SERVED}"),
        ("0.1 000#0205", "0.11 705#04", f"0.12 {READ}", f"0.121 {SERVED}"),
    ],
    ids=["by-its-word", "told", "all-and-by-its-word", "at-once-by-its-word"],
)
def test_answers_in_stopped_are_found(lines: tuple[str, ...]) -> None:
    assert found_in(IDLE, *lines) == [f"{len(lines) + 1} nmt.stopped"]


@pytest.mark.parametrize(
    "lines",
    [
        ("0.1 000#0200", f"0.25 {READ}", f"0.251 {SERVED}", f"0.3 {OTHER}",
         f"0.301 {OTHER_SERVED}"),
        ("0.1 000#0200", f"0.25 {READ}", f"1.25 {READ}", END),
        ("0.1 000#0205", f"0.15 {READ}", f"0.151 {SERVED}", f"0.25 {READ}", f"1.5 {READ}", END),
        ("0.1 705#04", "0.2 000#0105", "0.21 705#04", f"0.22 {READ}", f"0.221 {SERVED}"),
        ("0.1 705#04", "0.2 705#05", f"0.22 {READ}", f"0.221 {SERVED}"),
        (f"0.1 {READ}", "0.11 705#04", f"0.12 {SERVED}", f"0.2 {READ}", END),
        (f"0.1 {WRITE}", "0.11 000#0205", f"0.3 {READ}", f"0.4 {WRITTEN}", END),
        ("0.1 > 21 10 20 00 14", "0.101 < 60 10 20 00", "0.2 000#0205",
         "0.25 < 80 10 20 00 00 00 00 08", "0.4 000#0105", f"0.5 {READ}", f"0.501 {SERVED}"),
    ],
    ids=["the-master", "all-stopped", "needs-100-ms", "heartbeat-late", "runs-again", "under-way",
         "slow-write", "ends-its-transfer"],
)  # fmt: skip
def test_what_a_stopped_node_may_do(lines: tuple[str, ...]) -> None:
    assert found_in(IDLE, *lines) == []


def test_frames_with_the_other_length_of_identifier_are_not_nmt() -> None:
    seen = seen_in(IDLE, f"0.1 {READ}", f"0.101 {SERVED}", f"0.2 {OTHER}", f"0.9 {OTHER_SERVED}")
    for can_id, data in ((0x000, b"\x82\x00"), (0x705, b"\x00"), (0x705, b"\x04")):
        stray = Seen(9, 0.3, "can0", CanFrame(can_id, data, extended=True))
        judge = LogJudge()
        assert [each for one in (*seen[:4], stray, seen[4]) for each in judge.take(one)] == []
        (channel,) = judge.channels.values()
        assert channel.not_judged == []


# What needs no state, and what follows a finding


@pytest.mark.parametrize("answer", ["60 18 10 01", "20", "A1", "E0", "60", "30", "A0 18 10 01 7F"])
def test_the_first_exchange_of_a_node_is_judged(answer: str) -> None:
    assert found_in(f"0.1 {READ}", f"0.101 < {answer}") == ["2 response.specifier"]
    assert found_in(
        f"0.1 {READ}", f"0.101 < {answer}", f"0.2 {OTHER}", f"0.201 {OTHER_SERVED}"
    ) == ["2 response.specifier"]


@pytest.mark.parametrize(
    "lines",
    [
        ("0.1 < 60 00 20 00", f"0.2 {READ}", f"0.201 {SERVED}"),
        (f"0.1 {READ}", "0.101 < 20", f"0.102 {SERVED}", f"0.2 {OTHER}", f"0.201 {OTHER_SERVED}"),
        (f"0.1 {READ}", "0.101 < A2 03 7F"),
        ("0.1 > 60", "0.101 < 00 01 02 03 04 05 06 07"),
        ("0.1 > A1", f"0.2 {READ}", f"0.201 {SERVED}"),
        (f"0.1 {READ}", "0.101 < 80 10 20 00 00 00 00 08"),
    ],
    ids=["answer-first", "another-first", "in-a-sub-block", "in-a-transfer", "at-an-end", "abort"],
)
def test_a_log_may_begin_anywhere(lines: tuple[str, ...]) -> None:
    assert found_in(*lines) == []


def test_what_was_not_judged_is_told() -> None:
    told = told_of("0.1 > 60", "0.101 < 00 01 02 03 04 05 06 07")
    assert "can0, node 5: 1 requests, 1 responses, 1 not judged" in told
    assert "    not judged, as the state of the server was open: line 2" in told
    assert told[-1] == "all responses but the 1 not judged allowed"


def test_what_follows_a_finding_is_judged() -> None:
    wrong = (f"0.1 {READ}", "0.101 < 60 18 10 01")
    assert found_in(IDLE, *wrong, f"0.2 {OTHER}", "0.201 < A1") == [
        "3 response.specifier", "5 response.specifier",
    ]  # fmt: skip
    assert found_in(IDLE, *wrong, f"0.102 {SERVED}", f"0.2 {OTHER}", f"0.201 {OTHER_SERVED}") == [
        "3 response.specifier"
    ]
    assert found_in(IDLE, *wrong, f"0.2 {OTHER}", END) == [
        "3 response.specifier", "4 response.answered",
    ]  # fmt: skip


@pytest.mark.parametrize("code", ["78 56 34 12", "12 00 07 06"])
def test_an_answer_behind_an_abort_is_found(code: str) -> None:
    sent = (*BLOCK, *BURST, "0.103 < A2 02 7F", "0.104 > C1", f"0.105 < 80 10 20 00 {code}")
    assert found_in(IDLE, *sent, "0.106 < A1")[-1][:2] == "9 "


def test_each_frame_of_a_flood_is_counted() -> None:
    flood = [f"0.{200 + number} {SERVED}" for number in range(20)]
    asked = (f"0.1 {READ}", f"0.101 {SERVED}")
    told = told_of(IDLE, *asked, *flood, f"0.3 {OTHER}", f"0.301 {OTHER_SERVED}")
    findings = [line for line in told if "response.unsolicited" in line]
    assert [line.partition(",")[0] for line in findings] == ["line 4", "line 23"]
    assert findings[1].endswith("(19 times more up to here)")
    assert told[-1] == "20 not allowed"


# A server that takes segments for requests behind its own abort


SEGMENTS = (*BLOCK, "0.1020 > 21 30 31 32 33 34 35 36", "0.1021 > 22 30 31 32 33 34 35 36")


def test_a_segment_that_is_written_is_remarked() -> None:
    begun = ("0.1 > C2 10 20 00 FF", "0.101 < A0 10 20 00 7F")
    numbers = [f"0.1{20 + number} > {number:02X} 30 31 32 33 34 35 36" for number in range(1, 0x23)]
    abort = "0.16 < 80 10 20 00 20 00 00 08"
    written = ("0.161 > 23 00 20 00 31 32 33 34", "0.162 < 60 00 20 00")
    told = told_of(IDLE, *begun, *numbers, abort, *written)
    (remark,) = (line for line in told if "remark" in line)
    assert remark.startswith("line 40, 162.0 ms, can0, node 5: remark: a segment behind the abort")
    assert "download to 2000h:00" in remark
    assert told[-1].endswith("allowed")
    later = ("0.2 > 23 00 20 00 31 32 33 34", "0.201 < 60 00 20 00")
    told = told_of(IDLE, *begun, *numbers[:5], abort, *later)
    assert not [line for line in told if "remark" in line]
