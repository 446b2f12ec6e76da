"""Of which kind an answer is, or a request: what differs in numbers alone is of one kind."""

import pytest

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    RemoteFrame,
    Request,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.kinds import DOWNLOADS, kind_of_answer, kind_of_request
from conformance.sdo.layout import Multiplexer

MUX = Multiplexer(0x2010, 1)
READ = UploadInitiate(MUX)
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)


# The kind of answer


@pytest.mark.parametrize(
    ("frame", "kind"),
    [
        ("80 18 10 01 01 00 04 05", "abort 05040001h"),
        ("80 00 00 00 01 00 04 05", "abort 05040001h"),
        ("80 18 10 01 FF 00 00 00", "abort 000000FFh"),
        ("9F 18 10 01 00 00 00 08", "abort 08000000h"),
        ("60 10 20 00 00 00 00 00", "download initiate response"),
        ("60 10 20 00 01 02 03 04", "download initiate response"),
        ("43 00 10 00 91 01 0F 00", "upload initiate response"),
        ("41 10 20 00 15 00 00 00", "upload initiate response"),
        ("20 00 00 00 00 00 00 00", "download segment response"),
        ("30 00 00 00 00 00 00 00", "download segment response"),
        ("0D 41 00 00 00 00 00 00", "upload segment response"),
        ("A4 10 20 00 7F 00 00 00", "block download initiate response"),
        ("C6 10 20 00 15 00 00 00", "block upload initiate response"),
        ("A2 05 7F 00 00 00 00 00", "block acknowledgement"),
        ("A1 00 00 00 00 00 00 00", "block end response"),
        ("C9 34 12 00 00 00 00 00", "block end"),
        ("E0 00 00 00 00 00 00 00", "command specifier"),
        ("FF 18 10 01 00 00 00 00", "command specifier"),
        ("43 00 10", "… bytes instead of …: …"),
        ("", "frame without data"),
    ],
)
def test_the_kind_of_a_frame_has_no_numbers_but_the_code_of_an_abort(frame: str, kind: str) -> None:
    assert str(kind_of_answer(decode_response(bytes.fromhex(frame)))) == kind


# The kind of request


@pytest.mark.parametrize(
    ("request_", "kind"),
    [
        (READ, "upload initiate"),
        (UploadSegment(toggle=1), "upload segment request"),
        (DownloadInitiate.with_data(MUX, b"\1\2"), "download initiate, expedited"),
        (DownloadInitiate.with_size(MUX, 20), "download initiate, segmented"),
        (DownloadInitiate.with_size(MUX, None), "download initiate, size not indicated"),
        (DownloadSegment.with_data(b"ABC", toggle=1, last=True), "download segment"),
        (BlockUploadInitiate(MUX, 127), "block upload initiate"),
        (BlockUploadStart(), "block upload start"),
        (BlockDownloadInitiate.with_size(MUX, 20), "block download initiate"),
        (BlockSegment(7, b"ABCDEFG", last=True), "block segment …"),
        (BlockAck(5, 127), "block acknowledgement"),
        (BlockEnd(3, 0x1D0F), "block end"),
        (ABORT, "abort"),
        (
            Unknown(bytes.fromhex("E0 10 20 01 00 00 00 00")),
            "command specifier …",
        ),
        (Unknown(b"\x40\x10"), "… bytes instead of …"),
        (Unknown(b""), "frame without data"),
        (RemoteFrame(b"", 8), "remote frame"),
        (UploadInitiate(MUX, reserved_bits=1), "upload initiate"),
        (BlockAck(1, 2, reserved=b"\1\2\3\4\5"), "block acknowledgement"),
        (BlockDownloadInitiate.with_size(MUX, None), "download initiate, size not indicated"),
    ],
)
def test_a_request_has_neither_object_nor_numbers(request_: Request, kind: str) -> None:
    assert kind_of_request(request_) == kind


def test_each_kind_of_download_is_one() -> None:
    downloads = [
        DownloadInitiate.with_data(MUX, b"\1"),
        *(
            kind.with_size(MUX, size)
            for kind in (DownloadInitiate, BlockDownloadInitiate)
            for size in (None, 20)
        ),
    ]
    assert {kind_of_request(request) for request in downloads} == DOWNLOADS
