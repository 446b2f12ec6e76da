"""Our client against the LocalNode of the PyPI package canopen."""

from collections.abc import Iterator

import pytest
from canopen_server import CanopenDevice, canopen_device
from foreign_objects import DEVICE_NAME, NODE_ID
from server_contract import ServerContract
from suite_client import SuiteClient

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadInitiateResponse,
    UploadInitiateResponse,
)


@pytest.fixture(scope="module")
def device(virtual_channel: str) -> Iterator[CanopenDevice]:
    """A LocalNode on the virtual bus."""
    with canopen_device(virtual_channel, NODE_ID) as running:
        yield running


class TestLocalNode(ServerContract):
    """What any server has to do, and what this one does in its own way."""

    def test_accepts_the_initiate_of_a_write_that_it_will_refuse(self, client: SuiteClient) -> None:
        answer = client.exchange(DownloadInitiate.with_size(DEVICE_NAME, 12))
        assert answer == DownloadInitiateResponse(DEVICE_NAME).encode()
        client.channel.abort(DEVICE_NAME, AbortCode.GENERAL_ERROR)

    def test_answers_a_block_upload_with_an_ordinary_one(
        self, device: CanopenDevice, client: SuiteClient
    ) -> None:
        answer = client.exchange(BlockUploadInitiate(DEVICE_NAME, block_size=127, threshold=0))
        size = len(device.read(DEVICE_NAME))
        assert answer == UploadInitiateResponse.with_size(DEVICE_NAME, size).encode()
        client.channel.abort(DEVICE_NAME, AbortCode.GENERAL_ERROR)

    def test_refuses_a_block_download(self, client: SuiteClient) -> None:
        answer = client.exchange(BlockDownloadInitiate.with_size(DEVICE_NAME, 12))
        assert decode_response(answer) == Abort(DEVICE_NAME, AbortCode.COMMAND_NOT_VALID)
