"""From what happened in a case to its verdict, and what a run keeps from one case to the next."""

from collections.abc import Iterator

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    NODE_ID,
    NUMBER,
    READ,
    TEXT,
    Recording,
    Workbench,
    begin,
    discovered,
    recording,
    violation,
)

from conformance.bus.errors import BenchError, InterfaceLost, SecondClient, WriteNotPermitted
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.dialogue.dialogue import Dialogue
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.run.evidence import trace_texts
from conformance.run.session import MOST_INCIDENTS
from conformance.run.trace import ASIDE
from conformance.run.verdict import Afterwards, CaseResult, Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import Abort, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, FILLER, RESERVED, Level, Rule, Violation

SOFT = Rule("soft.rule", "7.2.4", Level.SHOULD, "What should be.")
ABORT = Abort(Multiplexer(0x1018, 1), AbortCode.GENERAL_ERROR).encode()
NOT_NAMED = Multiplexer(0x1017)


@pytest.fixture
def bench() -> Iterator[Workbench]:
    with discovered(recording()) as opened:
        yield opened


def concluded(bench: Workbench, error: BaseException | None, *minor: Violation) -> CaseResult:
    run = begin(bench.session())
    run.sdo.record.minor.extend(minor)
    return run.conclude(error)


# Verdicts


def test_pass(bench: Workbench) -> None:
    run = begin(bench.session())
    run.sdo.upload(NUMBER)
    result = run.conclude(None)
    assert (result.verdict, result.afterwards) == (Verdict.PASS, Afterwards.IDLE)
    assert (result.case_id, result.service, result.node_id) == ("a.case", "a service", NODE_ID)
    assert (result.level, result.clause, result.requirement) == (
        "MUST",
        "7.2.4",
        "What the case is about.",
    )
    assert (result.broken_rule, result.expected, result.actual) == ("", "", "")
    assert result.duration > result.latency > 0
    assert result.waited == 0


def test_info(bench: Workbench) -> None:
    run = begin(bench.session())
    run.sdo.info("first this")
    result = run.conclude(None)
    assert (result.verdict, result.notes) == (Verdict.INFO, ["first this"])


@pytest.mark.parametrize(
    ("error", "verdict", "actual"),
    [
        (violation(), Verdict.FAIL, "something"),
        (violation(SOFT), Verdict.NON_STRICT, "something"),
        (NotTestable("needs a string"), Verdict.NOT_TESTABLE, "needs a string"),
        (Unimplemented("abort 05040001h"), Verdict.UNIMPLEMENTED, "abort 05040001h"),
        (AssertionError("1 == 2"), Verdict.FAIL, "AssertionError: 1 == 2"),
        (BenchError("no bus"), Verdict.BENCH_ERROR, "no bus"),
        (InterfaceLost("can0 failed"), Verdict.BENCH_ERROR, "can0 failed"),
    ],
    ids=repr,
)
def test_what_ended_the_case_makes_the_verdict(
    bench: Workbench, error: Exception, verdict: Verdict, actual: str
) -> None:
    result = concluded(bench, error)
    assert (result.verdict, result.actual) == (verdict, actual)


def test_a_bus_that_goes_while_the_device_is_looked_at_is_told(
    bench: Workbench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The runner of the cases has to know the kind of the error: no other case need be tried."""
    run = begin(bench.session())

    def gone(frame: CanFrame) -> None:
        raise InterfaceLost("can0 failed")

    monkeypatch.setattr(run.sdo.channel.link, "send", gone)
    assert run.conclude(None).verdict is Verdict.BENCH_ERROR
    assert isinstance(run.bench_error, InterfaceLost)


@pytest.mark.parametrize(
    ("broken", "level"), [(Level.MUST, "MUST"), (Level.SHOULD, "SHOULD"), (Level.MAY, "MUST")]
)
def test_the_level_is_that_of_the_breach(bench: Workbench, broken: Level, level: str) -> None:
    """What a freedom does not allow is forbidden, whatever the level of the case."""
    rule = Rule("a.rule", "7.2.4", broken, "A sentence.")
    assert concluded(bench, violation(rule)).level == level


def test_the_rule_that_was_broken_is_named(bench: Workbench) -> None:
    """It need not be the rule that the case is about."""
    result = concluded(bench, violation(ANSWERED))
    assert result.broken == f"response.answered: {ANSWERED.sentence}"
    assert result.expected == "another thing"


def test_a_refusal_that_no_case_asked_for(bench: Workbench) -> None:
    abort = Abort(NUMBER.mux, AbortCode.LOCAL_CONTROL)
    result = concluded(bench, ServerAborted(abort))
    assert result.verdict is Verdict.FAIL
    assert result.broken_rule == "response.not-refused"
    assert result.actual.startswith("abort 2004h:00, 08000021h")


def test_a_should_does_not_hide_a_must(bench: Workbench) -> None:
    """Whatever the order in which they were seen."""
    for minor in ([violation(SOFT), violation()], [violation(), violation(SOFT)]):
        result = concluded(bench, None, *minor)
        assert (result.verdict, result.broken_rule) == (Verdict.FAIL, "test.rule")
    result = concluded(bench, violation(SOFT), violation(actual="worse"))
    assert (result.verdict, result.actual) == (Verdict.FAIL, "worse")


def test_what_was_seen_as_well_is_noted(bench: Workbench) -> None:
    result = concluded(bench, violation(actual="first"), violation(actual="second"))
    assert result.actual == "first"
    assert result.notes == ["also test.rule: expected another thing; got second"]


@pytest.mark.parametrize("rule", [RESERVED, FILLER])
def test_reserved_fields_and_filler_are_for_the_end_of_the_run(
    bench: Workbench, rule: Rule
) -> None:
    """They fail no case on the way, so that each of them can still be tested."""
    session = bench.session()
    run = begin(session)
    run.sdo.record.minor.append(violation(rule))
    result = run.conclude(None)
    assert (result.verdict, result.notes) == (Verdict.PASS, [])
    assert [(found.case_id, found.violation.rule) for found in session.whole_run.incidents] == [
        ("a.case", rule)
    ]


def test_incidents_do_not_pile_up(bench: Workbench) -> None:
    session = bench.session()
    for _ in range(3):
        run = begin(session)
        run.sdo.record.minor.extend([violation(RESERVED)] * (MOST_INCIDENTS - 50))
        run.conclude(None)
    assert len(session.whole_run.incidents) == MOST_INCIDENTS


# What comes by itself


def test_a_late_answer_is_charged_to_the_case_before(bench: Workbench) -> None:
    session = bench.session()
    begin(session, "first").conclude(None)
    bench.send_from_elsewhere(CanFrame(0x585, ABORT))
    second = begin(session, "second")
    second.sdo.info("shown")
    result = second.conclude(None)
    assert result.verdict is Verdict.INFO
    (late,) = session.whole_run.late
    assert late.case_id == "first"
    assert "585#8018100100000008" in late.violation.actual
    assert not any("1018h:01" in line.words for line in result.trace), "the next case begins anew"


def test_an_answer_that_comes_while_the_device_is_looked_at(bench: Workbench) -> None:
    session = bench.session()
    run = begin(session)
    run.sdo.upload(NUMBER)
    bench.send_from_elsewhere(CanFrame(0x585, ABORT))
    result = run.conclude(None)
    assert result.verdict is Verdict.FAIL
    assert result.broken_rule == "response.unsolicited"
    assert session.whole_run.late == []


class _Rebooting(Node):
    """Starts again whenever 1018h:01 is read."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        return self.start() + answers if frame.data[:4] == b"\x40\x18\x10\x01" else answers


def test_a_device_that_starts_again() -> None:
    server = recording()
    with discovered(_Rebooting(NODE_ID, server)) as bench:
        session = bench.session()
        run = begin(session)
        run.sdo.upload(Multiplexer(0x1018, 1))
        result = run.conclude(None)
        assert result.verdict is Verdict.FAIL
        assert result.broken_rule == "server.no-reboot"
        assert begin(session).conclude(None).verdict is Verdict.PASS


def test_another_node_that_starts_is_its_own_affair(bench: Workbench) -> None:
    run = begin(bench.session())
    bench.send_from_elsewhere(CanFrame(0x706, b"\0"), CanFrame(0x705, b"\0", extended=True))
    assert run.conclude(None).verdict is Verdict.PASS


def test_a_second_client_between_two_cases(bench: Workbench) -> None:
    session = bench.session()
    begin(session).conclude(None)
    bench.send_from_elsewhere(CanFrame(0x605, READ))
    with pytest.raises(SecondClient):
        begin(session)


# Afterwards


def written(sdo: Dialogue) -> None:
    sdo.download(NUMBER, b"\1\2\3\4")
    sdo.download(TEXT, b"written by a case")


@pytest.mark.parametrize(
    "error",
    [
        None,
        violation(),
        violation(SOFT),
        NotTestable("needs more"),
        Unimplemented("refused"),
        AssertionError("of the user's own"),
        WriteNotPermitted("of another object"),
        SecondClient("another client"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_values_are_put_back_however_the_case_ended(error: Exception | None) -> None:
    """Also when it was the bench: what the suite wrote is the suite's to put back."""
    server = recording()
    values = server.values()
    with discovered(server) as bench:
        run = begin(bench.session())
        written(run.sdo)
        assert server.values() != values
        run.conclude(error)
    assert server.values() == values


def test_an_open_transfer_does_not_reach_the_next_case() -> None:
    """Neither after a case that was about to write elsewhere."""
    server = recording()
    with discovered(server) as bench:
        session = bench.session()
        run = begin(session)
        run.sdo.initiate_download(TEXT, 14)
        with pytest.raises(WriteNotPermitted) as raised:
            run.sdo.initiate_download(NOT_NAMED, 14)
        result = run.conclude(raised.value)
        assert result.verdict is Verdict.BENCH_ERROR
        assert server.transfer is None


class _Halting(Recording):
    """Stops working when it is sent FFh."""

    halted = False

    def receive(self, frame: bytes) -> list[bytes]:
        self.halted |= frame[:1] == b"\xff"
        return [] if self.halted else super().receive(frame)


def test_a_device_that_is_lost() -> None:
    """What could not be put back is known, with its value."""
    server = _Halting(reference_entries(NODE_ID))
    with discovered(server) as bench:
        session = bench.session()
        run = begin(session)
        written(run.sdo)
        bench.channel.response_timeout = HASTY
        run.sdo.send(b"\xff" + bytes(7))
        result = run.conclude(violation())
        assert session.lost
        assert set(session.restorer.unrestored) == {NUMBER.mux, TEXT.mux}
        assert session.restorer.unrestored[NUMBER.mux].startswith("4 bytes: 11 22 33 44")
    assert (result.verdict, result.afterwards) == (Verdict.FAIL, Afterwards.LOST)
    assert result.waited >= 4 * HASTY


def test_a_server_that_is_not_idle_fails_a_case_that_passed(bench: Workbench) -> None:
    bench.device.baseline[0] = (READ, BASELINE[:4] + b"\xff\xff\xff\xff")
    bench.channel.response_timeout = HASTY
    session = bench.session()
    result = begin(session).conclude(None)
    assert result.verdict is Verdict.FAIL
    assert result.broken_rule == "server.idle-afterwards"
    assert result.afterwards is Afterwards.ANSWERS_WRONGLY
    assert not session.lost


# Evidence


def test_evidence(bench: Workbench) -> None:
    session = bench.session()
    run = begin(session)
    run.sdo.upload(Multiplexer(0x1018, 1))
    run.sdo.info("what merely passes is not shown")
    result = run.conclude(None)
    assert [text[13:] for text in trace_texts(result)] == [
        "> 605#4018100100000000 upload initiate 1018h:01",
        "< 585#4318100100000C5D upload initiate response 1018h:01, expedited, 4 bytes: 00 00 0C 5D",
    ]
    assert result.decisive is None
    assert result.reproduce == ["cansend can0 605#4018100100000000"]
    again = begin(session)
    again.sdo.send(UploadInitiate(NUMBER.mux))
    again.sdo.receive()
    again.sdo.info("shown")
    assert len(again.conclude(None).trace) == 2, "each case has its own frames"


def test_what_came_behind_a_case_is_shown_where_it_makes_the_verdict(bench: Workbench) -> None:
    session = bench.session()
    run = begin(session)
    run.sdo.upload(NUMBER)
    bench.send_from_elsewhere(CanFrame(0x585, ABORT))
    assert run.conclude(None).trace[2].words == ASIDE


def test_the_frame_that_decides_is_marked(bench: Workbench) -> None:
    run = begin(bench.session())
    run.sdo.send(UploadInitiate(NUMBER.mux))
    run.sdo.receive()
    assert run.conclude(violation()).decisive == 1
