"""How a case left the server: idle, in need of an abort, answering wrongly, or lost."""

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    NODE_ID,
    READ,
    TEXT,
    Recording,
    Scripted,
    discovered,
    recording,
    undiscovered,
)

from conformance.dialogue.blocks import Blocks
from conformance.dialogue.silence import Silence
from conformance.faults.catalogue import build_node
from conformance.faults.own_clock import AnswersLater
from conformance.reference.node import Node
from conformance.run.leaving import Proof, leave
from conformance.run.verdict import Afterwards
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockUploadStart,
    DownloadSegment,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import IDLE_AFTERWARDS, UNSOLICITED
from conformance.sdo.rules.defects import STREAMS

ABORTED_1000H = Abort(Multiplexer(0x1000), AbortCode.GENERAL_ERROR).encode()
STREAMING = "block-upload-start-streams-segments"
OTHER_VALUE = BASELINE[:4] + b"\xff\xff\xff\xff"


def is_abort(data: bytes) -> bool:
    return data[0] == 0x80


def test_idle() -> None:
    with discovered(recording()) as bench:
        leaving = leave(bench.dialogue(), failed=False)
    assert (leaving.afterwards, leaving.violation) == (Afterwards.IDLE, None)


def test_the_open_transfer_is_ended() -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.initiate_download(TEXT, 14)
        sdo.download_segment(b"ABCDEFG", toggle=0)
        server.requests.clear()
        assert leave(sdo, failed=False).afterwards is Afterwards.IDLE
        abort = Abort(TEXT.mux, AbortCode.GENERAL_ERROR).encode()
        assert server.requests == [abort, READ]
        assert server.transfer is None


@pytest.mark.parametrize("failed", [False, True])
def test_a_server_that_failed_is_told_to_end_what_it_may_think_is_open(failed: bool) -> None:
    """Such a server may have a transfer that it should not have; an idle one is left alone."""
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.upload(Multiplexer(0x1008))
        server.requests.clear()
        assert leave(sdo, failed=failed).afterwards is Afterwards.IDLE
        assert sdo.fence() == []
    abort = Abort(Multiplexer(0x1008), AbortCode.GENERAL_ERROR).encode()
    assert server.requests == ([READ, abort, READ, READ] if failed else [READ, READ])


UPLOADED_WITH = [(Proof.UPLOAD, []), (Proof.FENCE, [READ]), (Proof.ANEW, [READ])]


@pytest.mark.parametrize(("proof", "sent"), UPLOADED_WITH)
def test_an_upload_at_the_end_is_proof_enough_where_it_is_one(
    proof: Proof, sent: list[bytes]
) -> None:
    """Not behind anything else, nor where it was refused."""
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.upload(Multiplexer(0x1008))
        server.requests.clear()
        assert leave(sdo, failed=False, proof=proof).afterwards is Afterwards.IDLE
        assert server.requests == sent
        sdo.download(TEXT, b"ABC")
        sdo.upload(TEXT)
        server.requests.clear()
        leave(sdo, failed=False, proof=proof)
        assert server.requests == sent
        with pytest.raises(ServerAborted):
            sdo.read(Multiplexer(0x5FFF))
        server.requests.clear()
        leave(sdo, failed=False, proof=proof)
        sdo.initiate_upload(Multiplexer(0x1008))
        leave(sdo, failed=False, proof=proof)
        assert server.requests.count(READ) == 2
        assert server.requests[0] == server.requests[-1] == READ


def test_what_comes_behind_an_upload_is_told_of_the_case() -> None:
    """It would be taken for the answer to what the next case asks."""
    node = Scripted(lambda data: [BASELINE, OTHER_VALUE] if data == READ else [])
    with undiscovered(node) as bench:
        sdo = bench.dialogue()
        sdo.upload(Multiplexer(0x1000))
        leaving = leave(sdo, failed=False, proof=Proof.UPLOAD)
    assert leaving.violation is not None
    assert leaving.violation.rule is UNSOLICITED


@pytest.mark.parametrize("request_", [BlockUploadStart(), BlockAck(1, 127)])
def test_segments_that_come_one_by_one_are_waited_for_behind_a_failure(request_: Request) -> None:
    """Between two of them a fence is answered as by an idle server; the next case is not."""
    with discovered(build_node(STREAMING, NODE_ID)) as bench:
        sdo = bench.dialogue()
        sdo.initiate_download(TEXT, 14)
        sdo.send(BlockUploadStart())
        sdo.receive()
        sdo.wire.last_sent = request_
        assert leave(sdo, failed=True).afterwards is Afterwards.IDLE
        assert bench.channel.receive(0.1) is None


def test_segments_that_come_one_by_one_are_told_of_a_case_that_has_not_waited_for_them() -> None:
    """Each of its cases is told of, though its fence was answered before the first came."""
    with discovered(build_node(STREAMING, NODE_ID)) as bench:
        for _ in range(2):
            sdo = bench.dialogue()
            sdo.send(BlockUploadStart())
            sdo.fence()
            leaving = leave(sdo, failed=False, proof=Proof.FENCE)
            assert leaving.violation is not None
            assert leaving.violation.told_as == STREAMS
            assert len(leaving.stray) > 20
            assert bench.channel.receive(0.1) is None


def test_who_sends_no_segments_by_itself_is_waited_for_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """For each request that asks for segments, with a transfer open and without."""
    waited: list[list[Response]] = []
    outlast = Silence.outlast

    def counted(silence: Silence) -> list[Response]:
        waited.append(outlast(silence))
        return waited[-1]

    monkeypatch.setattr(Silence, "outlast", counted)
    with discovered(recording()) as bench:
        for opens in (False, False, True, True):
            for request_ in (BlockUploadStart(), BlockAck(1, 127)):
                sdo = bench.dialogue()
                if opens:
                    sdo.initiate_download(TEXT, 14)
                sdo.send(request_)
                sdo.receive()
                assert leave(sdo, failed=False).violation is None
    assert waited == [[]] * 4


def test_no_wait_behind_a_block_upload() -> None:
    with discovered(recording()) as bench:
        sdo = bench.dialogue()
        Blocks(sdo).upload(Multiplexer(0x1008))
        assert not sdo.line.misplaced
        leave(sdo, failed=False)
        assert not bench.device.learned.says_all


def test_an_abort_that_comes_late_is_no_stream() -> None:
    class Late(AnswersLater):
        delay = late = 0.0

        def receive(self, frame: CanFrame) -> list[CanFrame]:
            if frame.data[:1] != b"\xa3":
                return Node.receive(self, frame)
            self.held.append((self.now + self.late, self.respond(ABORTED_1000H)))
            return []

    node = Late(NODE_ID, recording())
    with discovered(node) as bench:
        # Behind the fence, which the suite sends when the device had the time to serve the start.
        node.late = bench.channel.pace.room(bench.channel.response_timeout) + 0.005
        sdo = bench.dialogue()
        sdo.send(BlockUploadStart())
        sdo.fence()
        leaving = leave(sdo, failed=False)
        assert leaving.violation is not None
        assert (leaving.violation.rule, leaving.violation.told_as) == (UNSOLICITED, None)
        assert not bench.device.learned.streams


def test_an_unsolicited_answer() -> None:
    """The server is idle all the same, and the case has failed."""
    node = Scripted(lambda data: [OTHER_VALUE, BASELINE] if data == READ else [])
    with undiscovered(node) as bench:
        leaving = leave(bench.dialogue(), failed=False)
    assert leaving.afterwards is Afterwards.IDLE
    assert leaving.violation is not None
    assert leaving.violation.rule is UNSOLICITED
    assert "FF FF FF FF" in leaving.violation.actual


class _Stuck(Recording):
    """Answers nothing after a segment without a transfer, until it is told to abort."""

    stuck = False

    def receive(self, frame: bytes) -> list[bytes]:
        answers = super().receive(frame)
        if is_abort(frame):
            self.stuck = False
        elif frame == DownloadSegment.with_data(b"", toggle=0).encode():
            self.stuck = True
        return [] if self.stuck else answers


def test_needed_an_abort() -> None:
    server = recording(_Stuck)
    with discovered(server) as bench:
        sdo = bench.dialogue()
        bench.channel.response_timeout = HASTY
        sdo.send(DownloadSegment.with_data(b"", toggle=0))
        server.requests.clear()
        leaving = leave(sdo, failed=False)
    assert leaving.afterwards is Afterwards.NEEDED_ABORT
    assert leaving.violation is not None
    assert leaving.violation.rule is IDLE_AFTERWARDS
    assert leaving.violation.actual == "no answer"


def test_a_server_that_refuses_once_needed_an_abort() -> None:
    """It answers, so it is not lost; the read is served only after an abort."""
    aborted: list[bytes] = []

    def answers(data: bytes) -> list[bytes]:
        if is_abort(data):
            aborted.append(data)
            return []
        return [BASELINE if aborted else ABORTED_1000H]

    with undiscovered(Scripted(answers), timeout=HASTY) as bench:
        leaving = leave(bench.dialogue(), failed=False)
    assert leaving.afterwards is Afterwards.NEEDED_ABORT
    assert leaving.violation is not None
    assert "abort 1000h:00" in leaving.violation.actual


@pytest.mark.parametrize("answer", [OTHER_VALUE, ABORTED_1000H, BASELINE[:3]], ids=bytes.hex)
def test_answers_wrongly(answer: bytes) -> None:
    """A device that answers, whatever it says, is not lost: the run goes on."""
    node = Scripted(lambda data: [] if is_abort(data) else [answer])
    with undiscovered(node, timeout=HASTY) as bench:
        leaving = leave(bench.dialogue(), failed=False)
    assert leaving.afterwards is Afterwards.ANSWERS_WRONGLY
    assert leaving.violation is not None
    assert leaving.violation.rule is IDLE_AFTERWARDS


def test_lost() -> None:
    """An abort and two more reads were tried before the device is given up."""
    node = Scripted(lambda data: [])
    with undiscovered(node, timeout=HASTY) as bench:
        sdo = bench.dialogue()
        leaving = leave(sdo, failed=False)
    assert leaving.afterwards is Afterwards.LOST
    assert leaving.violation is not None
    assert leaving.violation.rule is IDLE_AFTERWARDS
    assert node.requests == [READ, READ, ABORTED_1000H, READ, READ]
    assert sdo.wire.timing.waited >= 4 * HASTY


def test_an_upload_that_a_case_leaves_open_is_ended_also_when_another_was_refused() -> None:
    server = recording()
    with discovered(server) as bench:
        sdo = bench.dialogue()
        sdo.initiate_upload(Multiplexer(0x1008))
        sdo.send(UploadInitiate(Multiplexer(0x1FFF)))
        sdo.receive()
        assert leave(sdo, failed=False).afterwards is Afterwards.IDLE
        assert server.transfer is None
