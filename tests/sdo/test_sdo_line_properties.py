"""A line knows the state of the reference server from the frames alone, whatever a client sends."""

from hypothesis import given
from hypothesis import strategies as st
from sdo_server_bench import Bench
from support.sdo_strategies import FRAMES, REQUESTS, UNHURRIED
from support.sdo_vectors import load, mux

from conformance.reference.segmented_server import Download, Upload
from conformance.reference.server import BlockDownload, BlockUpload
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.crc import crc16
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    Request,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import FRAME_LENGTH, Message
from conformance.sdo.line import Line

ABORT = Abort(mux("1000"), AbortCode.GENERAL_ERROR)
MUX = st.sampled_from([mux(name) for name in ("1000", "1008", "2000", "2001", "2004", "3000")])
SIZE = st.none() | st.integers(1, 40)
DATA = st.binary(min_size=7, max_size=7)
INITIATE = st.one_of(
    st.builds(UploadInitiate, MUX),
    st.builds(DownloadInitiate.with_size, MUX, SIZE),
    st.builds(DownloadInitiate.with_data, MUX, st.binary(min_size=1, max_size=4)),
    st.builds(BlockUploadInitiate, MUX, st.integers(0, 127), st.integers(0, 40)),
    st.builds(BlockDownloadInitiate.with_size, MUX, SIZE),
).map(Message.encode)
ODD = st.one_of(FRAMES, st.binary(max_size=7), st.one_of(*REQUESTS.values()).map(Message.encode))
BEGINNING = (
    UploadInitiate(mux("1008")),
    DownloadInitiate.with_size(mux("2001"), None),
    BlockUploadInitiate(mux("1008"), 3),
    BlockDownloadInitiate.with_size(mux("2001"), None),
)
# An initiate, a frame of any kind, or None for the request that is due, with the data for it.
STEPS = st.lists(
    st.tuples(st.one_of(*[st.none()] * 6, INITIATE, ODD), DATA, st.booleans()), max_size=40
)


class Client:
    """Asks a reference server, and shows each frame to a line."""

    def __init__(self) -> None:
        self.server = Bench().server
        self.line = Line()

    def send(self, frame: bytes) -> None:
        assert self.line.request(frame).encode() == frame
        for answer in self.server.receive(frame):
            assert self.line.surplus(answer, expected=False) is None
            assert self.line.response(answer).encode() == answer

    def due(self, data: bytes, *, last: bool) -> Request:
        """Return a request that continues the transfer of the server, or begins one."""
        match self.server.transfer:
            case Upload(toggle=toggle):
                return UploadSegment(toggle)
            case Download(toggle=toggle):
                return DownloadSegment.with_data(data, toggle=toggle, last=last)
            case BlockUpload(ended=True):
                return BlockEndResponse()
            case BlockUpload(sent=0):
                return BlockUploadStart()
            case BlockUpload(sent=sent):
                return BlockAck(sent - (last and sent > 1), 3)
            case BlockDownload(ended=True, data=received, crc=crc):
                return BlockEnd(0, crc16(bytes(received)) if crc else 0)
            case BlockDownload(due=due):
                return BlockSegment.with_data(due, data, last=last)
            case _:
                return BEGINNING[data[0] % len(BEGINNING)]

    def expect_agreement(self) -> None:
        """Expect the line to have the state of the server."""
        transfer = self.server.transfer
        assert self.line.open == (None if transfer is None else transfer.mux)
        if isinstance(transfer, Download | BlockDownload):
            assert self.line.in_flight == transfer.data


def is_cut(frame: bytes) -> bool:
    """Say whether a frame is a download segment that brings less than 7 bytes."""
    return len(frame) == FRAME_LENGTH and DownloadSegment.matches(frame[0]) and frame[0] & 14 > 0


@UNHURRIED
@given(STEPS)
def test_a_line_knows_what_the_server_is_doing(
    steps: list[tuple[bytes | None, bytes, bool]],
) -> None:
    client = Client()
    for chosen, data, last in steps:
        frame = client.due(data, last=last).encode() if chosen is None else chosen
        if isinstance(client.server.transfer, Download) and is_cut(frame):
            continue  # the filler may be taken as well
        client.send(frame)
        client.expect_agreement()
    client.send(ABORT.encode())
    client.expect_agreement()
    assert client.line.open is None
    assert not client.line.owed


def test_a_worked_exchange_leaves_nothing_open() -> None:
    left = []
    for vector in load().values():
        line = Line()
        for step in vector.steps:
            if step.direction == "request":
                line.request(step.frame)
            elif step.direction == "response":
                line.response(step.frame)
        if line.open is not None or line.owed:
            left.append(vector.id)
    assert left == []
