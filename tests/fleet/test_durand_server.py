"""Our client against the Node of the PyPI package durand."""

from collections.abc import Iterator

import pytest
from durand_server import DurandDevice, durand_device
from foreign_objects import DEVICE_NAME, DOMAIN, NODE_ID, payload
from server_contract import ServerContract
from suite_client import SuiteClient

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.client import Uploaded
from conformance.sdo.frames import (
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
    DownloadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

# Around what one segment, a few sub-blocks of several sizes, and one of 127 segments hold.
BLOCK_SIZES = (*range(1, 23), 48, 49, 50, 139, 141, 888, 889, 890, 5000)


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

    @pytest.mark.parametrize("crc", [True, False], ids=["crc", "no crc"])
    @pytest.mark.parametrize("sized", [True, False], ids=["sized", "unsized"])
    @pytest.mark.parametrize("size", BLOCK_SIZES)
    def test_block_download(
        self, device: DurandDevice, client: SuiteClient, size: int, sized: bool, crc: bool
    ) -> None:
        client.block_download(DOMAIN, payload(size), sized=sized, crc=crc)
        assert device.read(DOMAIN) == payload(size)

    @pytest.mark.parametrize("crc", [True, False], ids=["crc", "no crc"])
    @pytest.mark.parametrize("block_size", [1, 7, 20, 127])
    @pytest.mark.parametrize("size", [size for size in BLOCK_SIZES if size % 7])
    def test_block_upload(
        self, device: DurandDevice, client: SuiteClient, size: int, block_size: int, crc: bool
    ) -> None:
        device.write(DOMAIN, payload(size))
        uploaded = client.block_upload(DOMAIN, block_size=block_size, crc=crc)
        assert uploaded == Uploaded(payload(size), True, size, -(-size // 7))

    # It counts the bytes of a full last segment that do not matter as 7 instead of 0.
    @pytest.mark.parametrize("size", [size for size in BLOCK_SIZES if not size % 7])
    def test_block_upload_of_whole_segments_is_cut(
        self, device: DurandDevice, client: SuiteClient, size: int
    ) -> None:
        device.write(DOMAIN, payload(size))
        with pytest.raises(Violation, match=r"\[DD [0-9A-F ]+\]"):
            client.block_upload(DOMAIN)
        client.channel.abort(DOMAIN, AbortCode.GENERAL_ERROR)
