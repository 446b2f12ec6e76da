"""What leads to the point of a case: strictly checked, and a breach of its own when it fails."""

from collections.abc import Callable, Iterator

import pytest
from support.run_bench import (
    DOMAIN,
    HASTY,
    NODE_ID,
    NUMBER,
    RULE,
    TEXT,
    VENDOR_ID,
    Recording,
    Scripted,
    Workbench,
    discovered,
    recording,
    undiscovered,
)

from conformance.device.not_testable import NotTestable
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.values import same_value
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_device import reference_entries
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import shown
from conformance.sdo.frames import Abort, DownloadInitiate, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, Refusal
from conformance.sdo.rules import (
    MISSING_REFUSED,
    MULTIPLEXER,
    NOT_REFUSED,
    SPECIFIER,
    TOGGLE,
    Rule,
    Violation,
    rule_of,
)

NAME = Multiplexer(0x1008)
MISSING = Multiplexer(0x0F00)
VENDOR = Multiplexer(0x1018, 1)


@pytest.fixture
def bench() -> Iterator[Workbench]:
    with discovered(recording()) as opened:
        yield opened


def test_a_download_step_by_step(bench: Workbench) -> None:
    sdo = bench.dialogue()
    sdo.initiate_download(TEXT, 9)
    sdo.download_segment(b"ABCDEFG", toggle=0)
    sdo.download_segment(b"HI", toggle=1, last=True)
    assert sdo.upload(TEXT) == b"ABCDEFGHI"
    assert sdo.record.written == {TEXT.mux}


def test_an_upload_step_by_step(bench: Workbench) -> None:
    sdo = bench.dialogue()
    response = sdo.start_segmented_upload(NAME)
    assert response.size == 28
    assert sdo.upload_segment(toggle=0).data == b"Conform"
    assert sdo.upload_segment(toggle=1).data == b"ance re"
    assert sdo.line.open == NAME
    assert sdo.record.written == set()


def test_the_rest_of_an_upload(bench: Workbench) -> None:
    sdo = bench.dialogue()
    for target in (NAME, NUMBER):
        response = sdo.initiate_upload(target)
        assert sdo.finish_upload(target, response) == sdo.upload(target)


def test_a_segment_needs_a_transfer(bench: Workbench) -> None:
    """A case that is wrong itself is no failure of the device."""
    sdo = bench.dialogue()
    with pytest.raises(RuntimeError):
        sdo.upload_segment(toggle=0)
    with pytest.raises(RuntimeError):
        sdo.download_segment(b"", toggle=0)


REFUSED: dict[str, Callable[[Dialogue], object]] = {
    "upload": lambda sdo: sdo.upload(MISSING),
    "initiate-upload": lambda sdo: sdo.initiate_upload(MISSING),
    "download": lambda sdo: sdo.download(NUMBER, b"\1\2"),
    "initiate-download": lambda sdo: sdo.initiate_download(NUMBER, 5),
}


@pytest.mark.parametrize("step", REFUSED.values(), ids=REFUSED)
def test_a_step_that_is_refused(bench: Workbench, step: Callable[[Dialogue], object]) -> None:
    """That is not what the case is about: it is another rule that is broken."""
    sdo = bench.dialogue()
    with pytest.raises(Violation) as raised:
        step(sdo)
    assert raised.value.rule is NOT_REFUSED
    assert raised.value.expected.startswith("an answer to: ")
    assert raised.value.actual.startswith("abort ")


def test_a_refusal_that_is_asked_for(bench: Workbench) -> None:
    sdo = bench.dialogue()
    assert sdo.try_download(NUMBER, b"\1\2\3\4") is None
    abort = sdo.try_download(NUMBER, b"\1\2")
    assert abort == Abort(NUMBER.mux, AbortCode.LENGTH_TOO_LOW)
    with pytest.raises(ServerAborted):
        sdo.read(MISSING)
    assert sdo.read(VENDOR) == VENDOR_ID


@pytest.mark.parametrize(
    ("answer", "rule"),
    [
        ("60 00 10 00 00 00 00 00", SPECIFIER),
        ("43 18 10 02 00 00 00 00", MULTIPLEXER),
        ("43 19 10 01 00 00 00 00", MULTIPLEXER),
        ("E0 18 10 01 00 00 00 00", SPECIFIER),
    ],
)
def test_a_step_that_is_answered_wrongly(answer: str, rule: Rule) -> None:
    with (
        undiscovered(Scripted(lambda data: [bytes.fromhex(answer)])) as opened,
        pytest.raises(Violation) as raised,
    ):
        opened.dialogue().upload(VENDOR)
    assert raised.value.rule is rule


def test_a_segment_with_a_wrong_toggle_bit() -> None:
    answers = iter([bytes.fromhex("4108100008000000"), bytes.fromhex("1041424344454647")])
    with (
        undiscovered(Scripted(lambda data: [next(answers)])) as opened,
        pytest.raises(Violation) as raised,
    ):
        opened.dialogue().upload(NAME)
    assert raised.value.rule is TOGGLE


def test_a_short_answer_where_segments_are_due(bench: Workbench) -> None:
    with pytest.raises(Violation) as raised:
        bench.dialogue().start_segmented_upload(NUMBER)
    assert raised.value.rule is NOT_REFUSED
    assert "2004h:00 is longer than 4 bytes" in raised.value.expected


def test_the_type_says_how_many_bytes_count() -> None:
    with discovered(build_node("expedited-upload-not-counted", NODE_ID)) as opened:
        sdo = opened.dialogue()
        for known in opened.device.objects:
            if known.length is not None and known.access.readable:
                assert len(sdo.upload(known)) == known.length


# Values that cases write


def test_payload_differs_by_call_and_not_by_run(bench: Workbench) -> None:
    first, again = bench.dialogue(), bench.dialogue()
    drawn = [first.payload(20) for _ in range(3)]
    assert [again.payload(20) for _ in range(3)] == drawn
    assert len(set(drawn)) == 3
    assert all(0x21 <= byte < 0x7F for byte in b"".join(drawn))
    other_seed = Dialogue(bench.channel, bench.device, CaseRecord(RULE), seed=2)
    assert other_seed.payload(20) not in drawn


def test_another_number(bench: Workbench) -> None:
    sdo = bench.dialogue()
    before = sdo.upload(NUMBER)
    value = sdo.write_number(NUMBER)
    assert value != before
    assert sdo.upload(NUMBER) == value


def number(low: int | None = None, high: int | None = None) -> dict[Multiplexer, Entry]:
    """Return the built-in device with limits on its number, which holds 44332211h."""
    entries = reference_entries(NODE_ID)
    entries[NUMBER.mux].low, entries[NUMBER.mux].high = low, high
    return entries


def test_a_number_with_limits() -> None:
    """Where not every byte may change, the lowest bit does."""
    with discovered(recording(entries=number(0x44332200, 0x44332212))) as opened:
        assert opened.dialogue().write_number(NUMBER) == bytes.fromhex("10223344")


def test_a_number_that_takes_one_value_only() -> None:
    with (
        discovered(recording(entries=number(0x44332211, 0x44332211))) as opened,
        pytest.raises(NotTestable, match="2004h:00 takes no value near its present one"),
    ):
        opened.dialogue().write_number(NUMBER)


def test_a_number_that_is_refused_for_another_reason() -> None:
    entries = reference_entries(NODE_ID)
    entries[NUMBER.mux].access = Access.CONST
    with discovered(recording(entries=entries)) as opened, pytest.raises(Violation) as raised:
        opened.dialogue().write_number(NUMBER)
    assert raised.value.rule is NOT_REFUSED


def test_a_string_that_is_too_small() -> None:
    with discovered(build_node("strings-of-20-bytes", NODE_ID)) as opened:
        sdo = opened.dialogue()
        Room(sdo).store(TEXT, b"x" * 20)
        with pytest.raises(NotTestable, match=r"2010h:00 takes values of 20 bytes .*06070012h"):
            Room(sdo).store(TEXT, b"x" * 21)


def test_a_string_that_refuses_one_length_and_takes_a_longer_one() -> None:
    with (
        discovered(build_node("segmented-short-object-refused", NODE_ID)) as opened,
        pytest.raises(Violation) as raised,
    ):
        Room(opened.dialogue()).store(TEXT, b"abc", segmented=True, exactly=True)
    assert raised.value.rule is NOT_REFUSED


def test_a_value_that_one_way_refuses_is_stored_by_another() -> None:
    """It is told, and the case goes on to its point; the next value goes that way at once."""
    server = recording(_Unsegmented)
    with discovered(server) as opened:
        sdo = opened.dialogue()
        Room(sdo).store(TEXT, b"x" * 20)
        assert server.values()[TEXT.mux] == b"x" * 20
        assert [found.rule for found in sdo.record.minor] == [NOT_REFUSED]
        server.requests.clear()
        Room(sdo).store(TEXT, b"y" * 20)
        assert server.requests[0] == bytes.fromhex("C6 10 20 00 14 00 00 00")
    assert server.values()[TEXT.mux] == b"y" * 20


class _Unsegmented(Recording):
    """Takes values in one frame and in blocks only."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if not request.expedited:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        return super().on_download_initiate(request)


def test_a_long_object(bench: Workbench) -> None:
    known, data = Room(bench.dialogue()).long_object(5)
    assert known.varies
    assert bench.dialogue().upload(known) == data
    assert len(data) == 34


def test_a_long_object_without_leave_to_write() -> None:
    with discovered(recording(), objects=[]) as opened:
        known, data = Room(opened.dialogue()).long_object()
        assert (known.mux, data) == (NAME, b"Conformance reference server")
        with pytest.raises(NotTestable, match="needs an object of 29 bytes or more"):
            Room(opened.dialogue()).long_object(5)


# What does not exist


def test_missing_entries_may_be_probed(bench: Workbench) -> None:
    sdo = bench.dialogue()
    missing = missing_object(sdo)
    assert not bench.device.policy.permits(Multiplexer(0x5FF7))
    assert bench.device.policy.permits(missing)
    sub_index = missing_sub_index(sdo, 0x2004)
    assert (missing, sub_index) == (MISSING, Multiplexer(0x2004, 0xFE))
    assert bench.device.policy.permits(sub_index)


@pytest.mark.parametrize("access", [Access.RW, Access.RO, Access.WO])
def test_what_exists_is_not_missing(access: Access) -> None:
    """Neither is what may only be written: a probe would write to it."""
    entries = reference_entries(NODE_ID)
    entries[MISSING] = Entry(b"\1", DataType.UNSIGNED8, access)
    entries[Multiplexer(0x2004, 0xFE)] = Entry(b"\1", DataType.UNSIGNED8, access)
    with discovered(recording(entries=entries)) as opened:
        sdo = opened.dialogue()
        assert missing_object(sdo) == Multiplexer(0x5FF7)
        assert missing_sub_index(sdo, 0x2004) == Multiplexer(0x2004, 0xFD)
        assert not opened.device.policy.permits(MISSING)
        assert not opened.device.policy.permits(Multiplexer(0x2004, 0xFE))


def test_a_device_that_serves_everything() -> None:
    """What may be a record of the user's may do so; 1018h, or every index, may not.

    And a variable has no sub-indices.
    """
    answer = bytes.fromhex("43 0000 00 00000000")
    node = Scripted(lambda data: [answer[:1] + data[1:4] + answer[4:]])
    with undiscovered(node) as opened:
        sdo = opened.dialogue()
        with pytest.raises(NotTestable, match="2001h serves the sub-indices FEh, FDh, 7Fh"):
            missing_sub_index(sdo, 0x2001)
        with pytest.raises(Violation, match="2004h is a variable") as variable:
            missing_sub_index(sdo, 0x2004)
        with pytest.raises(Violation) as identity:
            missing_sub_index(sdo, 0x1018)
        with pytest.raises(Violation) as everything:
            missing_object(sdo)
    assert variable.value.rule is identity.value.rule is rule_of("object.sub-index-missing")
    assert everything.value.rule is MISSING_REFUSED


def test_silence_is_no_refusal() -> None:
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=HASTY) as opened, pytest.raises(Violation):
        missing_object(opened.dialogue())
    assert not opened.device.policy.permits(MISSING)


# Values as text


def test_a_value_is_shown_with_its_length() -> None:
    assert shown(b"") == "0 bytes: no data"
    assert shown(b"\x01\xff") == "2 bytes: 01 FF"
    assert shown(bytes(range(32))).endswith("1F")
    long = "00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F … 19 1A 1B 1C 1D 1E 1F 20"
    assert shown(bytes(range(33))) == f"33 bytes: {long}"


def test_the_zero_at_the_end_of_a_string_is_optional() -> None:
    assert same_value(TEXT, b"abc\0", b"abc")
    assert same_value(TEXT, b"abc", b"abc\0")
    assert not same_value(TEXT, b"abc", b"ab")
    assert not same_value(DOMAIN, b"abc\0", b"abc")
    assert not same_value(NUMBER, b"\1\2\3\0", b"\1\2\3")
