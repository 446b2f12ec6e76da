"""Whether a transfer is open, by what went over the wire."""

import pytest

from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Unknown,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.line import Line

TEXT, NAME = Multiplexer(0x2010), Multiplexer(0x1008)
DOWNLOAD = [">21 10 20 00 0E 00 00 00", "<60 10 20 00 00 00 00 00"]
UPLOAD = [">40 08 10 00 00 00 00 00", "<41 08 10 00 0E 00 00 00"]
BLOCK_DOWNLOAD = [">C6 10 20 00 0E 00 00 00", "<A4 10 20 00 7F 00 00 00"]
BLOCK_UPLOAD = [">A4 08 10 00 7F 00 00 00", "<C6 08 10 00 0E 00 00 00"]
SEGMENT, SEGMENT_CONFIRMED = ">00 41 42 43 44 45 46 47", "<20 00 00 00 00 00 00 00"
LAST, LAST_CONFIRMED = ">11 41 42 43 44 45 46 47", "<30 00 00 00 00 00 00 00"
ABORT, ABORTED = ">80 10 20 00 00 00 00 08", "<80 10 20 00 00 00 00 08"

OPEN = {
    "download": (DOWNLOAD, TEXT),
    "download-in-the-middle": ([*DOWNLOAD, SEGMENT, SEGMENT_CONFIRMED], TEXT),
    "download-last-not-confirmed": ([*DOWNLOAD, LAST], TEXT),
    "download-confirmed-without-size": ([">20 10 20 00 00 00 00 00", DOWNLOAD[1]], TEXT),
    "upload": (UPLOAD, NAME),
    "upload-in-the-middle": ([*UPLOAD, ">60" + " 00" * 7, "<00 41 42 43 44 45 46 47"], NAME),
    "upload-without-size": ([UPLOAD[0], "<40 08 10 00 00 00 00 00"], NAME),
    "block-download": (BLOCK_DOWNLOAD, TEXT),
    "block-download-answered-by-what-was-late": (
        [BLOCK_DOWNLOAD[0], "<01 41 42 43 44 45 46 47"],
        TEXT,
    ),
    "block-upload": (BLOCK_UPLOAD, NAME),
    "upload-within-download": ([*DOWNLOAD, *UPLOAD], NAME),
    "download-within-upload": ([*UPLOAD, *DOWNLOAD], TEXT),
    "nothing-answered-yet": ([*UPLOAD, DOWNLOAD[0]], NAME),
    "unknown-answer": ([*UPLOAD, "<E0" + " 00" * 7], NAME),
    "short-answer": ([*UPLOAD, "<43 08 10"], NAME),
}
CLOSED = {
    "nothing": [],
    "initiate-only": DOWNLOAD[:1],
    "expedited-download": [">23 10 20 00 41 42 43 44", DOWNLOAD[1]],
    "expedited-upload": [UPLOAD[0], "<43 08 10 00 41 42 43 44"],
    "expedited-upload-within-download": [*DOWNLOAD, UPLOAD[0], "<43 08 10 00 41 42 43 44"],
    "download-at-its-end": [*DOWNLOAD, SEGMENT, SEGMENT_CONFIRMED, LAST, LAST_CONFIRMED],
    "upload-at-its-end": [*UPLOAD, ">60" + " 00" * 7, "<01 41 42 43 44 45 46 47"],
    "download-aborted-by-client": [*DOWNLOAD, ABORT],
    "download-aborted-by-server": [*DOWNLOAD, SEGMENT, ABORTED],
    "upload-aborted-by-server": [*UPLOAD, ABORTED],
    "block-upload-ended-by-client": [*BLOCK_UPLOAD, ">A1" + " 00" * 7],
    "block-download-at-its-end": [*BLOCK_DOWNLOAD, ">C1" + " 00" * 7, "<A1" + " 00" * 7],
    "refused": [DOWNLOAD[0], ABORTED],
    "block-download-refused": [BLOCK_DOWNLOAD[0], ABORTED],
    "answer-without-request": [DOWNLOAD[1]],
    "upload-answered-as-download": [">60" + " 00" * 7, DOWNLOAD[1]],
}


def follow(frames: list[str]) -> Line:
    """Return a line that has seen the frames; > is a request and < a response."""
    line = Line()
    for frame in frames:
        data = bytes.fromhex(frame[1:])
        if frame[0] == ">":
            line.request(data)
        else:
            line.response(data)
    return line


@pytest.mark.parametrize(("frames", "mux"), OPEN.values(), ids=OPEN)
def test_open(frames: list[str], mux: Multiplexer) -> None:
    line = follow(frames)
    assert line.open == mux
    assert line.latest == mux


@pytest.mark.parametrize("frames", CLOSED.values(), ids=CLOSED)
def test_closed(frames: list[str]) -> None:
    assert follow(frames).open is None


def test_the_latest_transfer_is_remembered() -> None:
    assert follow(CLOSED["download-at-its-end"]).latest == TEXT
    assert follow([*UPLOAD, ABORTED]).latest == NAME
    assert follow([*UPLOAD, *DOWNLOAD, ABORT]).latest == TEXT
    assert follow(CLOSED["expedited-upload"]).latest is None


READ = [">40 00 10 00 00 00 00 00", "<43 00 10 00 91 01 0F 00"]
STARTED = [*BLOCK_UPLOAD, ">A3" + " 00" * 7]
READ_AS = {
    "abort": ([], "80 08 10 00 00 00 00 08", Abort),
    "abort-with-reserved-bits": ([], "81 08 10 00 00 00 00 08", Abort),
    "segment-response": (UPLOAD, "01 41 42 43 44 45 46 47", UploadSegmentResponse),
    "unknown": (UPLOAD, "E0 00 00 00 00 00 00 00", Unknown),
    "begun": (BLOCK_UPLOAD[:1], "C6 08 10 00 0E 00 00 00", BlockUploadInitiateResponse),
    "segment": (STARTED, "01 41 42 43 44 45 46 47", BlockSegment),
    "segment-like-an-initiate": (STARTED, "43 08 10 00 45 46 47 48", BlockSegment),
    "last-segment-like-an-abort": (STARTED, "81 41 42 43 44 45 46 47", BlockSegment),
    "abort-of-block-upload": (STARTED, "80 08 10 00 00 00 00 08", Abort),
    "segment-behind-the-end": ([*STARTED, ABORT], "81 41 42 43 44 45 46 47", BlockSegment),
    "another-transfer": ([*STARTED, ABORT, UPLOAD[0]], UPLOAD[1][1:], UploadInitiateResponse),
    "abort-of-a-later-upload": ([*STARTED, ABORT, *UPLOAD], "81 08 10 00 00 00 00 08", Abort),
    "abort-of-a-later-download": ([*STARTED, ABORT, *DOWNLOAD], "81 10 20 00 00 00 00 08", Abort),
    "segment-behind-a-read": ([*STARTED, ABORT, *READ], "81 41 42 43 44 45 46 47", BlockSegment),
}


@pytest.mark.parametrize(("frames", "frame", "kind"), READ_AS.values(), ids=READ_AS)
def test_a_response_is_read_by_the_state_in_which_it_comes(
    frames: list[str], frame: str, kind: type
) -> None:
    data = bytes.fromhex(frame)
    response = follow(frames).response(data)
    assert type(response) is kind
    assert response.encode() == data


IN_SUB_BLOCK = [*BLOCK_UPLOAD, ">A3" + " 00" * 7, "<81 41 42 43 44 45 46 47"]
END = [*IN_SUB_BLOCK, ">A2 01 7F 00 00 00 00 00", "<C1 12 34 00 00 00 00 00"]
READ_SEGMENT, START, CONFIRM_END = ">60" + " 00" * 7, ">A3" + " 00" * 7, ">A1" + " 00" * 7


@pytest.mark.parametrize(
    ("conversation", "out_of_place"),
    [
        ([*DOWNLOAD, SEGMENT], False),
        ([*DOWNLOAD, SEGMENT, SEGMENT_CONFIRMED, LAST], False),
        ([*UPLOAD, READ_SEGMENT], False),
        ([*BLOCK_UPLOAD, START], False),
        ([*END, CONFIRM_END], False),
        ([*DOWNLOAD, *UPLOAD[:1]], False),
        ([ABORT], False),
        ([">E0 10 20"], False),
        ([">E0" + " 00" * 7], True),
        ([SEGMENT], True),
        ([*DOWNLOAD, LAST, LAST_CONFIRMED, SEGMENT], True),
        ([*DOWNLOAD, ABORTED, SEGMENT], True),
        ([*DOWNLOAD, READ_SEGMENT], True),
        ([*UPLOAD, START], True),
        ([*BLOCK_UPLOAD, CONFIRM_END], True),
        ([*IN_SUB_BLOCK, READ_SEGMENT], True),
        ([*IN_SUB_BLOCK, READ_SEGMENT, *UPLOAD[:1]], False),
    ],
)
def test_a_request_that_continues_nothing_is_out_of_place(
    conversation: list[str], out_of_place: bool
) -> None:
    assert follow(conversation).is_out_of_place is out_of_place


# The data of a download


def downloading(*segments: DownloadSegment) -> Line:
    line = follow(DOWNLOAD)
    for segment in segments:
        line.request(segment.encode())
    return line


def segment(data: bytes, toggle: int, *, last: bool = False) -> DownloadSegment:
    return DownloadSegment.with_data(data, toggle=toggle, last=last)


def test_segments_in_sequence_are_in_flight() -> None:
    line = downloading(segment(b"ABCDEFG", 0), segment(b"#######", 0), segment(b"HIJKLMN", 1))
    assert line.in_flight == b"ABCDEFGHIJKLMN"


@pytest.mark.parametrize("abort", [ABORT, ABORTED])
def test_nothing_is_in_flight_behind_an_abort(abort: str) -> None:
    line = follow([*DOWNLOAD, SEGMENT, abort, LAST, LAST_CONFIRMED])
    assert line.in_flight == b"ABCDEFG"
    assert line.completed is None


def test_what_lies_behind_a_gap_is_not_in_flight() -> None:
    line = follow(BLOCK_DOWNLOAD)
    for number, data in ((1, b"ABCDEFG"), (3, b"#######")):
        line.request(BlockSegment(number, data).encode())
    assert line.unacknowledged == 2
    line.response(BlockAck(1, 127).encode())
    line.request(BlockSegment(1, b"HIJKLMN").encode())
    assert line.in_flight == b"ABCDEFGHIJKLMN"
    line.response(BlockEndResponse().encode())
    assert line.completed == TEXT


def test_a_download_is_completed_by_the_answer_to_its_last_segment() -> None:
    line = downloading(segment(b"ABCDEFG", 0))
    line.response(DownloadSegmentResponse(0).encode())
    assert line.completed is None
    line.request(segment(b"HIJ", 1, last=True).encode())
    line.response(DownloadSegmentResponse(1).encode())
    assert line.completed == TEXT
    line.request(bytes.fromhex(UPLOAD[0][1:]))
    line.response(bytes.fromhex(UPLOAD[1][1:]))
    assert line.completed is None


def test_an_expedited_download_is_completed_by_its_answer() -> None:
    assert follow([">23 10 20 00 41 42 43 44", DOWNLOAD[1]]).completed == TEXT


# What is owed


@pytest.mark.parametrize(
    ("conversation", "owed"),
    [
        ([], False),
        (DOWNLOAD[:1], True),
        (DOWNLOAD, False),
        ([*DOWNLOAD, SEGMENT], True),
        ([*DOWNLOAD, ABORT], False),
        ([">E0 10 20"], True),
        (END, False),
        ([*END, CONFIRM_END], False),
        ([CONFIRM_END], True),  # out of place: it confirms nothing
    ],
)
def test_an_answer_is_owed_to_all_that_ends_no_transfer(
    conversation: list[str], owed: bool
) -> None:
    assert follow(conversation).owed is owed


@pytest.mark.parametrize(
    ("conversation", "abandoned"),
    [
        (BLOCK_DOWNLOAD, False),
        ([*BLOCK_DOWNLOAD, ABORT], True),
        ([*BLOCK_DOWNLOAD, ABORT, *UPLOAD[:1]], True),
        ([*BLOCK_DOWNLOAD, ABORT, *UPLOAD], False),
        ([*DOWNLOAD, ABORT], False),
        ([*BLOCK_UPLOAD, ABORT], False),
    ],
)
def test_a_block_download_is_abandoned_until_the_server_says_anything(
    conversation: list[str], abandoned: bool
) -> None:
    assert follow(conversation).is_abandoned is abandoned
