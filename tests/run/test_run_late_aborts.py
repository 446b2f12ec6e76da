"""An abort for a transfer that the client has aborted before: it counts wherever it is heard."""

from collections.abc import Iterator

import pytest
from support.run_bench import NODE_ID, TEXT, Workbench, begin, discovered

from conformance.dialogue.dialogue import Dialogue
from conformance.faults.catalogue import build_node
from conformance.reference.node import Node
from conformance.run.case_run import CaseRun
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import Abort, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

VENDOR = Multiplexer(0x1018, 1)
LATE = Abort(TEXT.mux, AbortCode.TIMED_OUT)
OF_A_FENCE, OF_THE_CASE = (UploadInitiate(mux).encode() for mux in (Multiplexer(0x1000), VENDOR))


class GivesUpLate(Node):
    """Says that it is timed out what the client has aborted, when it gets a certain request."""

    until = b""
    owes = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        running = self.server.transfer is not None
        answers = super().receive(frame)
        if frame.data[:1] == b"\x80":
            self.owes |= running
        elif self.owes and frame.data == self.until:
            self.owes = False
            return [self.respond(LATE.encode()), *answers]
        return answers


@pytest.fixture
def node() -> GivesUpLate:
    return GivesUpLate(NODE_ID, build_node(None, NODE_ID).server)


@pytest.fixture
def bench(node: GivesUpLate) -> Iterator[Workbench]:
    with discovered(node) as opened:
        yield opened


def give_up(sdo: Dialogue) -> None:
    sdo.initiate_download(TEXT, 14)
    sdo.send(Abort(TEXT.mux, AbortCode.GENERAL_ERROR))


def reading(run: CaseRun) -> Exception | None:
    """Read 1018h:01 as the step of a case; return what ended it."""
    try:
        run.sdo.upload(VENDOR)
    except (Violation, ServerAborted) as error:
        return error
    return None


@pytest.mark.parametrize("until", [OF_A_FENCE, OF_THE_CASE], ids=["fence", "answer"])
def test_in_the_case_that_aborted(bench: Workbench, node: GivesUpLate, until: bytes) -> None:
    run = begin(bench.session())
    node.until = until
    give_up(run.sdo)
    result = run.conclude(reading(run) if until is OF_THE_CASE else None)
    assert result.verdict is Verdict.FAIL
    assert LATE.encode().hex(" ").upper() in result.actual


@pytest.mark.parametrize("until", [OF_A_FENCE, OF_THE_CASE], ids=["fence", "answer"])
def test_in_the_next_case(bench: Workbench, node: GivesUpLate, until: bytes) -> None:
    session = bench.session()
    aborting(session)
    node.until = until
    run = begin(session, "second")
    result = run.conclude(reading(run))
    assert result.verdict is Verdict.FAIL
    assert LATE.encode().hex(" ").upper() in result.actual


def test_between_two_cases(bench: Workbench) -> None:
    session = bench.session()
    aborting(session)
    bench.send_from_elsewhere(CanFrame(0x580 + NODE_ID, LATE.encode()))
    assert begin(session, "second").conclude(None).verdict is Verdict.PASS
    (late,) = session.whole_run.late
    assert late.case_id == "first"
    assert LATE.encode().hex(" ").upper() in late.violation.actual


def aborting(session: DeviceSession) -> None:
    run = begin(session, "first")
    give_up(run.sdo)
    assert run.conclude(None).verdict is Verdict.PASS
