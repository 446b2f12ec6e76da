"""Answers that come late, in a run of several devices in turn: whose they are, and what they do."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import can
import pytest
from support.run_bench import PATIENT, RULE, VENDOR_ID

from conformance.bus.opening import BusSettings, open_bus
from conformance.faults.catalogue import build_node
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.run.bench import Bench, RunSettings, private_channel
from conformance.run.case_run import begin_case
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

FIRST, SECOND = 5, 9
VENDOR = Multiplexer(0x1018, 1)
LATE = CanFrame(0x585, bytes.fromhex("4318100100000000"))
# An abort has no answer: this one only says that an answer is kept from now on.
KEEP = Multiplexer(0x5FF7)


class Late(Node):
    """Answers an abort of 5FF7h with the next request to a node: to itself, or to another one."""

    keeps = False

    def __init__(self, until: int) -> None:
        super().__init__(FIRST, build_node(None, FIRST).server)
        self.until = 0x600 + until

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        if frame.can_id == 0x605 and frame.data[:4] == b"\x80\xf7\x5f\x00":
            self.keeps = True
            return []
        # Not before the fence behind the case has passed.
        due = frame.can_id == self.until and frame.data[1:3] != b"\x00\x10"
        if not self.keeps or not due or frame.data[0] == 0x80:
            return answers
        self.keeps = False
        return [LATE, *answers]


@contextmanager
def in_turn(until: int, folder: Path) -> Iterator[tuple[Bench, can.BusABC]]:
    """Open a bench with two devices; the first sends its late answer with a request to a node.

    Hands out another place on their bus as well.
    """
    name = private_channel()
    settings = BusSettings("virtual", name)
    nodes = (Late(until), build_node(None, SECOND))
    hosts = [NodeHost(open_bus(settings), node) for node in nodes]
    run = RunSettings([FIRST, SECOND], settings, response_timeout=PATIENT)
    bench = Bench(run, list(hosts), lambda captured: None, folder)
    try:
        with open_bus(settings) as heard:
            bench.open()
            yield bench, heard
    finally:
        bench.close()


def wait_for_late(heard: can.BusABC) -> None:
    """The devices answer at their own pace: the other one may be done before."""
    while (message := heard.recv(PATIENT)) is not None and message.data != LATE.data:
        pass
    assert message is not None


def asked_too_little_time(session: DeviceSession) -> None:
    run = begin_case(session, "first", "a service", RULE)
    run.sdo.channel.abort(KEEP, AbortCode.GENERAL_ERROR)
    assert run.conclude(None).verdict is Verdict.PASS


def test_a_late_answer_of_the_device_before(tmp_path: Path) -> None:
    """It is that device's own, and nothing to the one that is tested meanwhile."""
    with in_turn(SECOND, tmp_path) as (bench, heard):
        before, session = bench.sessions[FIRST], bench.sessions[SECOND]
        asked_too_little_time(before)
        for case_id in ("second", "third"):
            run = begin_case(session, case_id, "a service", RULE)
            assert run.sdo.upload(VENDOR) == VENDOR_ID
            if case_id == "second":
                wait_for_late(heard)
            assert run.sdo.fence() == []
            result = run.conclude(None)
            assert (result.verdict, result.notes, result.waited) == (Verdict.PASS, [], 0)
            assert run.bench_error is None
    assert session.whole_run.late == []
    (late,) = before.whole_run.late
    assert late.case_id == "first"
    assert str(LATE) in late.violation.actual


@pytest.mark.parametrize("mux", [VENDOR, Multiplexer(0x1018, 4)], ids=["alike", "other"])
def test_a_late_answer_in_the_next_case_of_the_device(tmp_path: Path, mux: Multiplexer) -> None:
    """It is found, also where it looks like the answer that is due."""
    with in_turn(FIRST, tmp_path) as (bench, _):
        session = bench.sessions[FIRST]
        asked_too_little_time(session)
        run = begin_case(session, "second", "a service", RULE)
        error = None
        try:
            run.sdo.upload(mux)
        except Violation as caught:
            error = caught
        assert run.conclude(error).verdict is Verdict.FAIL
