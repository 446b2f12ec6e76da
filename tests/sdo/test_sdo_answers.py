"""Which response may answer which request, by specifier and multiplexer."""

import pytest

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import is_answer
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegment,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Multiplexer

MUX, OTHER = Multiplexer(0x2010), Multiplexer(0x1018, 1)
READ = UploadInitiate(MUX)
ABORT = Abort(MUX, AbortCode.GENERAL_ERROR)


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        (READ, UploadInitiateResponse.with_data(MUX, b"\1")),
        (READ, UploadInitiateResponse.with_size(MUX, 20)),
        (UploadSegment(), UploadSegmentResponse.with_data(b"ABC", toggle=1)),
        (DownloadInitiate.with_size(MUX, 20), DownloadInitiateResponse(MUX)),
        (DownloadSegment.with_data(b"ABC", toggle=0), DownloadSegmentResponse(toggle=1)),
        (BlockUploadInitiate(MUX, 127), BlockUploadInitiateResponse.with_size(MUX, 20)),
        (BlockUploadInitiate(MUX, 127, 20), UploadInitiateResponse.with_size(MUX, 20)),
        (BlockDownloadInitiate.with_size(MUX, 20), BlockDownloadInitiateResponse(MUX, 127)),
        (BlockSegment(1, b"ABCDEFG"), BlockAck(1, 127)),
        (BlockAck(5, 127), BlockEnd(0)),
        (BlockEnd(0), BlockEndResponse()),
    ],
)
def test_an_answer_has_the_specifier_that_belongs_to_its_request(
    request_: Request, answer: Response
) -> None:
    assert is_answer(answer, request_)
    assert not is_answer(ABORT, request_)


@pytest.mark.parametrize(
    ("request_", "response"),
    [
        (READ, UploadInitiateResponse.with_data(OTHER, b"\1")),
        (DownloadInitiate.with_size(MUX, 20), DownloadInitiateResponse(OTHER)),
        (DownloadInitiate.with_size(MUX, 20), DownloadSegmentResponse()),
        (ABORT, UploadInitiateResponse.with_data(MUX, b"\1")),
        (BlockAck(5, 127), BlockEndResponse()),
    ],
)
def test_another_object_or_specifier_is_no_answer(request_: Request, response: Response) -> None:
    assert not is_answer(response, request_)
