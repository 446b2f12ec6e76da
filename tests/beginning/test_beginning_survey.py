"""What hides everything else is found before the first case, and is told as what it is."""

from collections.abc import Iterable
from contextlib import suppress

import pytest
from support.run_bench import (
    BASELINE,
    DOMAIN,
    HASTY,
    NODE_ID,
    NUMBER,
    READ,
    RULE,
    TEXT,
    Recording,
    Scripted,
    discovered,
    recording,
    undiscovered,
)

from conformance.beginning.survey import FIRST_SEEN, LONGER, survey
from conformance.device.effort import SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.faults.catalogue import build_node
from conformance.faults.faulty.block_download_aborts import DeafWhenAborted
from conformance.plugin.findings import Findings
from conformance.run.case_run import begin_case
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, same_data
from conformance.sdo.rules import FRAME_SHAPE, UNSOLICITED, Cause, Level, Rule, Violation, rule_of
from conformance.sdo.rules.defects import DEAF

END_MISSING = "segmented-upload.segments: the end of a value is left out"
ANSWERED = "abort.not-answered: an answer"


def aside(session: DeviceSession) -> list[str]:
    return [str(cause) for cause, _ in session.causes.aside()]


def test_nothing_is_found_at_a_server_that_is_right() -> None:
    """And what is written there is what was there."""
    server = recording()
    before = server.values()
    with discovered(server) as bench:
        session = bench.session()
        session.survey()
        assert list(session.causes) == []
        assert server.transfer is None
        assert begin_and_abort(session) is Verdict.PASS
    written = {str(mux) for mux, _ in server.writes}
    assert written == {"2001h:00", "2010h:00", "2011h:00"}, "a number, a string and a domain"
    assert server.values() == before


def begin_and_abort(session: DeviceSession) -> Verdict:
    """Conclude a case that ends by aborting what it has begun."""
    run = begin_case(session, "a.case", "a service", RULE)
    run.sdo.initiate_download(TEXT, 14)
    run.sdo.end_transfer()
    run.sdo.upload(NUMBER)
    return run.conclude(None).verdict


@pytest.mark.parametrize(
    ("fault", "causes"),
    [
        ("every-abort-answered", [ANSWERED]),
        ("upload-toggle-ignored", []),
        ("no-block-transfer", []),
        ("upload-drops-last-byte", [END_MISSING]),
        ("block-read-of-other-bytes", ["block-upload.first-sub-block: other data"]),
        (
            "numbers-confirmed-and-not-stored",
            ["response.not-refused: a download to a number that is confirmed and not stored"],
        ),
        (
            "expedited-confirmed-and-not-stored",
            ["response.not-refused: an expedited download that is confirmed and not stored"],
        ),
        ("block-upload-marked-one-early", ["block-upload.end: block segment"]),
    ],
)
def test_a_habit_is_found_and_other_defects_are_left_to_the_cases(
    fault: str, causes: list[str]
) -> None:
    with discovered(build_node(fault, NODE_ID)) as bench:
        session = bench.session()
        session.survey()
        assert aside(session) == causes
        assert {known.first_case for _, known in session.causes} <= {FIRST_SEEN}


def test_a_case_steps_round_a_habit_that_was_found() -> None:
    """Its own aborts are answered, and that is none of its business."""
    with discovered(build_node("every-abort-answered", NODE_ID)) as bench:
        session = bench.session()
        session.survey()
        assert begin_and_abort(session) is Verdict.PASS
        assert aside(session) == [ANSWERED], "no case has failed for it"


def test_the_case_about_a_habit_fails_for_it() -> None:
    with discovered(build_node("every-abort-answered", NODE_ID)) as bench:
        session = bench.session()
        session.survey()
        for _ in range(2):
            rule = rule_of("abort.not-answered")
            run = begin_case(session, "abort.frame", "abort", rule)
            run.sdo.initiate_download(TEXT, 14)
            run.sdo.end_transfer()
            result = run.conclude(None)
            assert (result.verdict, str(result.cause)) == (Verdict.FAIL, ANSWERED)
        assert aside(session) == []


def test_what_the_survey_has_found_and_no_case_has_told_is_told_at_the_end() -> None:
    with discovered(build_node("every-abort-answered", NODE_ID)) as bench:
        session = bench.session()
        session.survey()
        findings = Findings()
        findings.close(session, judged=0)
    (line,) = findings.beside
    assert line.startswith(f"{FIRST_SEEN}: ")
    assert "80 00 00 00 01 00 04 05" in line
    other = Findings()
    other.add(findings.as_dict())
    assert other.beside == findings.beside, "also where another process has found it"


# Values that are filled up


STORED = Rule("test.stored", "7.2.4", Level.MUST, "A value is stored.")
LENGTH = 300


class _Filling(Recording):
    """Fills up what is stored to one length, by 00h."""

    def store(self, entry: Entry, data: bytes) -> None:
        varies = entry.data_type.length is None
        super().store(entry, data.ljust(LENGTH, b"\0") if varies else data)


@pytest.mark.parametrize("known", [TEXT, DOMAIN])
def test_values_that_are_filled_up_are_known_from_then_on(known: KnownObject) -> None:
    """A string may be filled up; of a domain it is told once, and expected in every case."""
    with discovered(recording(_Filling)) as bench:
        session = bench.session()
        session.survey()
        found = [str(cause) for cause, _ in session.causes.aside()]
        run = begin_case(session, "a.case", "a service", STORED)
        filled = bench.device.known[known.mux]
        assert (filled.habits.filled, bench.device.learned.lengths[known.mux].fit(14)) == (
            LENGTH,
            LENGTH,
        )
        run.tools.room.store(filled, b"short")
        run.sdo.expect_value(filled, b"short")
        assert run.conclude(None).verdict is Verdict.PASS
    assert found == [
        "data.variable-length: shorter values are filled up with …, … bytes in all"
    ] * any(one.data_type is DataType.DOMAIN for one in bench.device.known.values())


@pytest.mark.parametrize(
    "fault", ["shorter-value-keeps-tail", "shorter-value-over-longer-one-in-buffer"]
)
def test_what_is_left_of_longer_values_is_known_from_then_on(fault: str) -> None:
    """It is told once, and is a part of what later cases prepare."""
    with discovered(build_node(fault, NODE_ID)) as bench:
        session = bench.session()
        session.survey()
        found = [str(cause) for cause, _ in session.causes.aside()]
        run = begin_case(session, "a.case", "a service", STORED)
        known = bench.device.known[DOMAIN.mux]
        run.tools.room.store(known, b"a longer value.")
        stored = run.tools.room.prepare(known, 9)
        assert stored[9:].startswith(b"value."), "read as it is"
        run.sdo.expect_value(known, stored[:9])
        assert not same_data(known.data_type, stored[:10], stored[:9]), "of itself it is other data"
        assert run.conclude(None).verdict is Verdict.PASS
    assert found == ["data.variable-length: the end of a longer value is left behind a shorter one"]


@pytest.mark.parametrize(
    ("fault", "alike"),
    [("shorter-value-over-longer-one-in-buffer", True), ("strings-padded", True), (None, None)],
)
def test_whether_long_values_come_in_blocks_is_known_before_the_first_case(
    fault: str | None, alike: bool | None
) -> None:
    """On that hangs which cases there are with them, and no case may be the one to find out."""
    with discovered(build_node(fault, NODE_ID)) as bench:
        bench.session().survey()
        assert bench.device.learned.reads_alike is alike


class _Keeping(Recording):
    """Leaves the end of a longer value behind a shorter one."""

    def store(self, entry: Entry, data: bytes) -> None:
        varies = entry.data_type.length is None
        super().store(entry, data + entry.value[len(data) :] if varies else data)


def test_what_could_never_be_short_again_is_written_no_longer_than_it_was() -> None:
    """That holds for each object that takes the place of one."""
    server = recording(_Keeping)
    before = {mux: len(value) for mux, value in server.values().items()}
    with discovered(server) as bench:
        session = bench.session()
        session.survey()
        run = begin_case(session, "a.case", "a service", STORED)
        room, roles = run.tools.room, Roles(bench.device)
        for size in (3, 20, 30, 257):
            known = roles.variable(min(size, SHORT_VALUE))
            with suppress(NotTestable):
                room.prepare(known, size)
            with suppress(NotTestable):
                room.need(known, size)
        with pytest.raises(NotTestable, match="257 bytes would never be the"):
            roles.variable(257)
    varying = {mux for mux, _ in server.writes} - {Multiplexer(0x2001)}
    assert varying >= {TEXT.mux, DOMAIN.mux}
    for mux in varying:
        assert len(server.entries[mux].value) <= max(before[mux], LONGER)


@pytest.mark.parametrize("upload", ["upload-size-8-bit", "upload-last-segment-n-off-by-one"])
def test_what_is_left_is_seen_in_blocks_where_ordinary_uploads_are_wrong(upload: str) -> None:
    with discovered(
        build_node(f"shorter-value-over-longer-one-in-buffer+{upload}", NODE_ID)
    ) as bench:
        bench.session().survey()
        assert bench.device.known[DOMAIN.mux].habits.keeps_tails


def test_a_device_that_keeps_lengths_fills_nothing_up() -> None:
    with discovered(recording()) as bench:
        session = bench.session()
        session.survey()
        assert session.causes.aside() == []
        assert not any(known.habits.filled for known in bench.device.known.values())
        assert session.restorer.unrestored == {}


def test_an_answer_of_another_shape_is_what_a_case_fails_for() -> None:
    """What it holds is no answer either."""

    def answers(frame: bytes) -> Iterable[bytes]:
        return [BASELINE[: len(frame)]]

    with undiscovered(Scripted(answers)) as bench:
        bench.device.baseline[:] = [(READ, BASELINE)]
        session = bench.session()
        run = begin_case(session, "a.case", "a service", STORED)
        run.sdo.send(READ[:3])
        with pytest.raises(Violation) as caught:
            run.sdo.checks.abort(run.sdo.receive(), None)
        result = run.conclude(caught.value)
    assert result.broken_rule == FRAME_SHAPE.id
    assert str(result.cause) == "response.frame: another length than 8"


class _Coming:
    """What brings a deaf server back; counts how often."""

    def __init__(self, server: Recording) -> None:
        self.server = server
        self.count = 0

    def __call__(self) -> bool:
        self.count += 1
        self.server.transfer = None
        return True


class _Deaf(DeafWhenAborted, Recording):
    """Keeps what it was sent."""


def test_a_device_that_is_deaf_behind_an_aborted_block_download_is_told_once() -> None:
    server = recording(_Deaf)
    with discovered(server, timeout=HASTY) as bench:
        sdo = bench.dialogue()
        coming = _Coming(server)
        survey(sdo, coming)
    assert coming.count == 1
    assert [str(cause) for cause, _ in sdo.record.causes.aside()] == [
        "server.idle-afterwards: deaf behind a block download that was aborted"
    ]


def test_what_nothing_brings_back_is_not_made_deaf() -> None:
    server = recording(_Deaf)
    with discovered(server, timeout=HASTY) as bench:
        session = bench.session()
        session.survey()
        assert (list(session.causes), session.lost) == ([], False)


def test_a_case_that_leaves_a_device_deaf_fails_for_that() -> None:
    server = recording(_Deaf)
    with discovered(server, timeout=HASTY) as bench:
        run = begin_case(bench.session(), "a.case", "a service", RULE)
        run.tools.blocks.initiate_download(TEXT, 14)
        result = run.conclude(None)
    assert str(result.cause) == str(DEAF)


def test_a_noisy_device_that_is_deaf_as_well_is_judged_in_good_order() -> None:
    server = recording(_Deaf)
    with discovered(server, timeout=HASTY) as bench:
        session = bench.session()
        unasked = Violation(UNSOLICITED, expected="nothing", actual="abort")
        session.causes.add(Cause(UNSOLICITED.id, "abort"), "before", unasked, aside=True)
        assert session.causes.noisy
        run = begin_case(session, "a.case", "a service", RULE)
        run.tools.blocks.initiate_download(TEXT, 14)
        result = run.conclude(None)
    assert result.verdict is Verdict.FAIL
    assert str(result.cause) == str(DEAF)
