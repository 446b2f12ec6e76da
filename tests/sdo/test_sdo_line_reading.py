"""Whole conversations in words: what each frame of worked exchanges reads as."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.sdo_strategies import REQUESTS, RESPONSES, SEGMENTS, UNHURRIED
from support.sdo_vectors import load

from conformance.sdo.describe import describe
from conformance.sdo.frames import (
    Abort,
    BlockEnd,
    BlockSegment,
    DownloadSegmentResponse,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Message
from conformance.sdo.line import Line

VECTORS = load()
SNAPSHOTS = {
    "V01": [
        "> download initiate 1017h:00, expedited, 2 bytes: A0 0F",
        "< download initiate response 1017h:00",
    ],
    "V03": [
        "> upload initiate 1008h:00",
        "< upload initiate response 1008h:00, segmented, 26 bytes",
        "> upload segment request, t=0",
        "< upload segment response, t=0, 7 bytes: 54 69 6E 79 20 4E 6F",
        "> upload segment request, t=1",
        "< upload segment response, t=1, 7 bytes: 64 65 20 2D 20 4D 65",
        "> upload segment request, t=0",
        "< upload segment response, t=0, 7 bytes: 67 61 20 44 6F 6D 61",
        "> upload segment request, t=1",
        "< upload segment response, t=1, last, 5 bytes: 69 6E 73 20 21",
    ],
    "V13": [
        "> upload initiate 1000h:01",
        "< abort 1000h:01, 06090011h (sub-index does not exist)",
    ],
    "V54": [
        "> download initiate 1009h:00, segmented, 14 bytes",
        "< download initiate response 1009h:00",
        "> download segment, t=0, 7 bytes: 6E 65 77 20 73 6C 61",
        "< download segment response, t=0",
        "> download segment, t=1, last, 7 bytes: 76 65 20 6E 61 6D 65",
        "< download segment response, t=1",
    ],
    "V60": [
        "> download initiate 2000h:00, segmented, 13 bytes",
        "< download initiate response 2000h:00",
        "> download segment, t=0, 7 bytes: 41 20 6C 6F 6E 67 20",
        "< download segment response, t=0; reserved bytes 1 to 7 are 00 20 00 00 00 00 00",
        "> download segment, t=1, last, 6 bytes: 73 74 72 69 6E 67",
        "< download segment response, t=1; reserved bytes 1 to 7 are 00 20 00 00 00 00 00",
    ],
    "V04": [
        "> block upload initiate 1008h:00, blksize 33, pst 0, with CRC",
        "< block upload initiate response 1008h:00, 26 bytes, without CRC",
        "> block upload start",
        "< block segment 1: 54 69 6E 79 20 4E 6F",
        "< block segment 2: 64 65 20 2D 20 4D 65",
        "< block segment 3: 67 61 20 44 6F 6D 61",
        "< block segment 4, last: 69 6E 73 20 21 00 00",
        "> block acknowledgement, ackseq 4, blksize 33",
        "< block end, n=2, CRC 0000h",
        "> block end response",
    ],
    "V61": [
        "> block download initiate 2000h:00, 30 bytes, with CRC",
        "< block download initiate response 2000h:00, blksize 127, with CRC",
        "> block segment 1: 41 20 72 65 61 6C 6C",
        "> block segment 2: 79 20 72 65 61 6C 6C",
        "> block segment 3: 79 20 6C 6F 6E 67 20",
        "> block segment 4: 73 74 72 69 6E 67 2E",
        "> block segment 5, last: 2E 2E 00 00 00 00 00",
        "< block acknowledgement, ackseq 5, blksize 127",
        "> block end, n=5, CRC 6945h",
        "< block end response",
    ],
    "V82": [
        "> block download initiate 2004h:00, 35 bytes, with CRC",
        "< block download initiate response 2004h:00, blksize 127, with CRC",
        "> block segment 1: 60 61 62 63 64 65 66",
        "> block segment 2: 67 68 69 6A 6B 6C 6D",
        "> block segment 4: 75 76 77 78 79 7A 7B",
        "> block segment 5, last: 7C 7D 7E 7F 80 81 82",
        "< block acknowledgement, ackseq 2, blksize 127",
        "> block segment 1: 6E 6F 70 71 72 73 74",
        "> block segment 2: 75 76 77 78 79 7A 7B",
        "> block segment 3, last: 7C 7D 7E 7F 80 81 82",
        "< block acknowledgement, ackseq 3, blksize 127",
        "> block end, n=0, CRC E627h",
        "< block end response",
    ],
    "V84": [
        "> block download initiate 2004h:00, 14 bytes, with CRC",
        "< block download initiate response 2004h:00, blksize 127, with CRC",
        "> block segment 1: 30 31 32 33 34 35 36",
        "> block segment 2, last: 37 38 39 3A 3B 3C 3D",
        "< block acknowledgement, ackseq 2, blksize 127",
        "> block end, n=0, CRC A8D3h",
        "< abort 2004h:00, 05040004h (CRC error)",
    ],
    "V89": [
        "> block upload initiate 1008h:00, blksize 127, pst 0, with CRC",
        "< block upload initiate response 1008h:00, 26 bytes, with CRC",
        "> block upload start",
        "< block segment 1: 54 69 6E 79 20 4E 6F",
        "< block segment 2: 64 65 20 2D 20 4D 65",
        "< block segment 3: 67 61 20 44 6F 6D 61",
        "< block segment 4, last: 69 6E 73 20 21 00 00",
        "> block acknowledgement, ackseq 3, blksize 127",
        "< block segment 1, last: 69 6E 73 20 21 00 00",
        "> block acknowledgement, ackseq 1, blksize 127",
        "< block end, n=2, CRC E140h",
        "> block end response",
    ],
    "V91": [
        "> block upload initiate 1008h:00, blksize 127, pst 26, with CRC",
        "< upload initiate response 1008h:00, segmented, 26 bytes",
        "> upload segment request, t=0",
        "< upload segment response, t=0, 7 bytes: 54 69 6E 79 20 4E 6F",
        "> upload segment request, t=1",
        "< upload segment response, t=1, 7 bytes: 64 65 20 2D 20 4D 65",
        "> upload segment request, t=0",
        "< upload segment response, t=0, 7 bytes: 67 61 20 44 6F 6D 61",
        "> upload segment request, t=1",
        "< upload segment response, t=1, last, 5 bytes: 69 6E 73 20 21",
    ],
    "V99": [
        "> block upload initiate 1008h:00, blksize 127, pst 0, with CRC",
        "< block upload initiate response 1008h:00, 26 bytes, with CRC",
        "> block acknowledgement, ackseq 0, blksize 127",
        "< abort 1008h:00, 05040001h (command specifier not valid or unknown)",
    ],
    "V101": [
        "> upload initiate 1008h:00",
        "< upload initiate response 1008h:00, segmented, 26 bytes",
        "> upload segment request, t=0",
        "< upload segment response, t=0, 7 bytes: 54 69 6E 79 20 4E 6F",
        "> abort 1008h:00, 08000000h (general error)",
        "> upload initiate 1018h:01",
        "< upload initiate response 1018h:01, expedited, 4 bytes: 04 00 00 00",
    ],
}


@pytest.mark.parametrize("vector_id", SNAPSHOTS)
def test_worked_exchange(vector_id: str) -> None:
    assert VECTORS[vector_id].decoded() == SNAPSHOTS[vector_id]


def state(line: Line) -> dict[str, object]:
    """Return all that a line knows, what its reader knows included."""
    return vars(line) | vars(line._reader) | {"_reader": None}


def bytes_of(text: str) -> bytes:
    return bytes.fromhex(text)


def in_block_download() -> Line:
    follower = Line()
    follower.request(bytes_of("C6 00 20 00 0E 00 00 00"))
    follower.response(bytes_of("A4 00 20 00 7F 00 00 00"))
    return follower


def in_block_upload() -> Line:
    follower = Line()
    follower.request(bytes_of("A4 08 10 00 7F 00 00 00"))
    follower.response(bytes_of("C6 08 10 00 0E 00 00 00"))
    follower.request(bytes_of("A3 00 00 00 00 00 00 00"))
    return follower


@UNHURRIED
@given(st.one_of(*REQUESTS.values(), *RESPONSES.values(), *SEGMENTS.values()))
def test_what_was_built_is_what_its_bytes_are_read_as(built: Message) -> None:
    data = built.encode()
    for begun in (Line, in_block_download):
        read, taken = begun(), begun()
        assert taken.request(data, built) == read.request(data)
        assert state(taken) == state(read)


def test_within_a_sub_block_40h_is_segment_64() -> None:
    follower = in_block_download()
    assert follower.request(bytes_of("40 00 10 00 00 00 00 00")) == BlockSegment(
        64, bytes_of("00 10 00 00 00 00 00")
    )


@pytest.mark.parametrize("abort", ["80 00 20 00 00 00 00 08"])
def test_an_abort_of_either_side_ends_a_sub_block(abort: str) -> None:
    downloading, uploading = in_block_download(), in_block_upload()
    assert isinstance(downloading.request(bytes_of(abort)), Abort)
    assert isinstance(uploading.response(bytes_of(abort)), Abort)
    for follower in (downloading, uploading):
        assert isinstance(follower.request(bytes_of("40 00 10 00 00 00 00 00")), UploadInitiate)
        response = follower.response(bytes_of("43 00 10 00 91 01 0F 00"))
        assert isinstance(response, UploadInitiateResponse)


def test_segments_continue_until_the_last_is_acknowledged() -> None:
    follower = in_block_upload()
    follower.response(bytes_of("01 30 31 32 33 34 35 36"))
    follower.response(bytes_of("82 37 38 39 3A 3B 3C 3D"))
    follower.request(bytes_of("A2 01 7F 00 00 00 00 00"))
    repeated = follower.response(bytes_of("81 37 38 39 3A 3B 3C 3D"))
    assert repeated == BlockSegment(1, b"789:;<=", last=True)
    follower.request(bytes_of("A2 01 7F 00 00 00 00 00"))
    assert isinstance(follower.response(bytes_of("C1 D2 A8 00 00 00 00 00")), BlockEnd)


def test_an_acknowledgement_outside_a_block_transfer_starts_none() -> None:
    """A faulty server or a probing client sends A2h; what follows is no segment."""
    follower = Line()
    follower.response(bytes_of("A2 00 7F 00 00 00 00 00"))
    assert isinstance(follower.request(bytes_of("40 00 10 00 00 00 00 00")), UploadInitiate)
    follower = Line()
    follower.request(bytes_of("A2 00 7F 00 00 00 00 00"))
    stray = follower.response(bytes_of("20 00 00 00 00 00 00 00"))
    assert stray == DownloadSegmentResponse(toggle=0)


START = ["> A4 08 10 00 7F 00 00 00", "< C6 08 10 00 0E 00 00 00"]
ABORT = "> 80 08 10 00 00 00 00 08"
READ = "> 40 00 10 00 00 00 00 00"
RUNNING = [*START, "> A3 00 00 00 00 00 00 00", "< 01 30 31 32 33 34 35 36"]
SENT = [*RUNNING, "< 82 37 38 39 3A 3B 3C 3D", "> A2 02 7F 00 00 00 00 00"]


@pytest.mark.parametrize(
    ("conversation", "frame", "sequence"),
    [
        ([*START, READ], "< 81 30 31 32 33 34 35 36", 1),
        (START, "< 01 30 31 32 33 34 35 36", 1),
        ([*RUNNING, ABORT], "< 02 37 38 39 3A 3B 3C 3D", 2),
        ([*RUNNING, ABORT, READ], "< 82 37 38 39 3A 3B 3C 3D", 2),
        ([*RUNNING, ABORT, READ, "< 02 37 38 39 3A 3B 3C 3D"], "< 83 00 10 00 0 0 0 0", 3),
        (SENT, "< 81 30 31 32 33 34 35 36", 1),
        (SENT, "< 03 30 31 32 33 34 35 36", 3),
        (SENT, "< E9 30 31 32 33 34 35 36", 105),
    ],
)
def test_segments_come_unasked_where_a_block_upload_may_be_running(
    conversation: list[str], frame: str, sequence: int
) -> None:
    """81h is segment 1 there, marked as the last, unless object and code of an abort follow."""
    follower = following(conversation)
    data = bytes(int(each, 16) for each in frame[1:].split())
    message = follower.response(data)
    assert isinstance(message, BlockSegment)
    assert message.sequence == sequence


@pytest.mark.parametrize(
    ("conversation", "frame", "kind"),
    [
        ([*RUNNING, ABORT, READ], "43 00 10 00 91 01 0F 00", UploadInitiateResponse),
        ([*RUNNING, ABORT], "80 08 10 00 00 00 00 08", Abort),
        ([*RUNNING, ABORT], "81 08 10 00 00 00 00 08", Abort),
        ([*RUNNING, ABORT], "81 00 00 00 01 00 04 05", Abort),
        (RUNNING, "81 08 10 00 01 00 04 05", Abort),
        (RUNNING, "81 00 00 00 01 00 04 05", BlockSegment),
        (SENT, "C1 D2 A8 00 00 00 00 00", BlockEnd),
        ([*START, "> 60 00 00 00 00 00 00 00"], "01 0 0 0 0 0 0 0", UploadSegmentResponse),
        ([READ], "81 00 10 00 00 00 00 08", Abort),
        (
            [*RUNNING, ABORT, READ, "< 43 00 10 00 91 01 0F 00", READ],
            "81 00 10 00 00 00 00 08",
            Abort,
        ),
    ],
)
def test_what_is_no_segment_though(conversation: list[str], frame: str, kind: type) -> None:
    data = bytes(int(each, 16) for each in frame.split())
    follower = following(conversation)
    assert isinstance(follower.response(data), kind)


def following(conversation: list[str]) -> Line:
    follower = Line()
    for line in conversation:
        read = follower.request if line[0] == ">" else follower.response
        read(bytes.fromhex(line[1:]))
    return follower


DOWNLOAD = "> C6 10 20 00 07 \n < A4 10 20 00 7F \n > 81 00 00 00 00 30 09 06"
UPLOAD = "> A4 10 20 00 7F \n < C6 10 20 00 07 \n > A3 \n < 81 00 00 00 00 30 09 06"


@pytest.mark.parametrize(
    ("conversation", "words"),
    [
        (f"{DOWNLOAD} \n < A2 01 7F \n > 81 00 00 00 00 30 09 06",
         "block segment 1, last: 00 00 00 00 30 09 06"),
        (f"{DOWNLOAD} \n > C1 0A 3A", "block end, n=0, CRC 3A0Ah"),
        (f"{DOWNLOAD} \n > 81 00 00 00 00 30 09 06 \n > C1 0A 3A", "block end, n=0, CRC 3A0Ah"),
        (f"{DOWNLOAD} \n > DD 00", "block end, n=7, CRC 0000h"),
        (f"{DOWNLOAD} \n > C1 0A 3A \n < A2 00 7F \n > 81 00 00 00 00 30 09 06",
         "block segment 1, last: 00 00 00 00 30 09 06"),
        (f"{UPLOAD} \n < DD 00", "block end, n=7, CRC 0000h"),
        (f"{UPLOAD} \n < C1 0A 3A", "block end, n=0, CRC 3A0Ah"),
        (f"{UPLOAD} \n > A2 00 7F \n < C1 0A 3A", "block end, n=0, CRC 3A0Ah"),
        (f"{UPLOAD} \n > A2 01 7F \n < 81 00 00 00 00 30 09 06",
         "block segment 1, last: 00 00 00 00 30 09 06"),
        (f"{UPLOAD} \n > A2 00 7F \n < 81 00 00 00 00 30 09 06",
         "block segment 1, last: 00 00 00 00 30 09 06"),
    ],
)  # fmt: skip
def test_what_follows_the_last_segment_is_read_by_the_state(conversation: str, words: str) -> None:
    follower = Line()
    message = None
    for line in map(str.strip, conversation.split("\n")):
        frame = bytes.fromhex(line[1:]).ljust(8, b"\0")
        message = follower.request(frame) if line[0] == ">" else follower.response(frame)
    assert message is not None
    assert describe(message) == words
