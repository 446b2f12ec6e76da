"""Our client against the Node of the PyPI package durand."""

from collections.abc import Iterator

import pytest
from durand_server import DurandDevice, durand_device
from foreign_objects import DEVICE_NAME, NODE_ID
from server_contract import ServerContract
from suite_client import SuiteClient

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    DownloadInitiate,
)
from conformance.sdo.layout import Multiplexer


@pytest.fixture(scope="module")
def device(virtual_channel: str) -> Iterator[DurandDevice]:
    """A node of durand on the virtual bus."""
    with durand_device(virtual_channel, NODE_ID) as running:
        yield running


class TestDurandNode(ServerContract):
    """What any server has to do, and what this one does in its own way."""

    def test_does_not_know_numbers_of_three_bytes(self, client: SuiteClient) -> None:
        upload = client.client.upload(Multiplexer(0x2003))
        assert client.refusal(upload) is AbortCode.OBJECT_MISSING

    def test_refuses_a_write_at_its_initiate(self, client: SuiteClient) -> None:
        answer = client.exchange(DownloadInitiate.with_size(DEVICE_NAME, 12))
        assert answer == b"\x80\x08\x10\x00\x02\x00\x01\x06"

    def test_serves_block_uploads(self, device: DurandDevice, client: SuiteClient) -> None:
        answer = client.exchange(BlockUploadInitiate(DEVICE_NAME, block_size=127))
        size = len(device.read(DEVICE_NAME))
        assert answer == BlockUploadInitiateResponse.with_size(DEVICE_NAME, size).encode()
        client.channel.abort(DEVICE_NAME, AbortCode.GENERAL_ERROR)
