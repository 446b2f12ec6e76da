"""Transfers of the reference client, taken from step to step."""

from collections.abc import Generator

import pytest
from support.sdo_vectors import mux

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import Burst, Step
from conformance.sdo.checks import ServerAborted
from conformance.sdo.client import Client, Uploaded
from conformance.sdo.frames import (
    Abort,
    BlockUploadStart,
    Response,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.stepping import Ended, advance


def test_a_transfer_goes_from_its_first_step_to_its_result() -> None:
    transfer = Client().upload(mux("1000"))
    assert advance(transfer) == UploadInitiate(mux("1000"))
    ended = advance(transfer, UploadInitiateResponse.with_data(mux("1000"), b"\x91\x01\x0f\0"))
    assert ended == Ended(Uploaded(b"\x91\x01\x0f\0"))


def test_a_step_that_awaits_nothing_is_left_without_a_response() -> None:
    def silent() -> Generator[Step, Response, str]:
        sent: object = yield Burst((BlockUploadStart(),), awaited=False)
        return f"sent back {sent}"

    transfer = silent()
    advance(transfer)
    assert advance(transfer) == Ended("sent back None")


def test_a_refusal_is_passed_on() -> None:
    transfer = Client().upload(mux("1000"))
    advance(transfer)
    with pytest.raises(ServerAborted):
        advance(transfer, Abort(mux("1000"), AbortCode.OBJECT_MISSING))
