"""What our client and any foreign server have to agree on; the values are looked up in the server.

Each foreign server has a subclass, and beside it the fixture ``device``.
"""

import pytest
from foreign_objects import (
    DEVICE_NAME,
    DOMAIN,
    IDENTITY,
    MISSING,
    NUMBER,
    SIZES,
    TEXT,
    WRITE_ONLY,
    ForeignDevice,
    payload,
    readable,
    writable_numbers,
)
from suite_client import SuiteClient

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.client import Uploaded
from conformance.sdo.layout import Multiplexer


class ServerContract:
    """Transfers of all lengths in both directions, and refusals."""

    def test_every_readable_entry_reads_as_it_is(
        self, device: ForeignDevice, client: SuiteClient
    ) -> None:
        held = {mux: device.read(mux) for mux in readable(device)}
        assert len(held) > 15
        assert {mux: client.upload(mux).data for mux in held} == held

    @pytest.mark.parametrize("mux", [TEXT, DOMAIN], ids=str)
    @pytest.mark.parametrize("size", SIZES)
    def test_upload(
        self, device: ForeignDevice, client: SuiteClient, mux: Multiplexer, size: int
    ) -> None:
        device.write(mux, payload(size))
        announced, segments = (None, 0) if size <= 4 else (size, -(-size // 7))
        assert client.upload(mux) == Uploaded(payload(size), True, announced, segments)

    @pytest.mark.parametrize("sized", [True, False], ids=["sized", "unsized"])
    @pytest.mark.parametrize("mux", [TEXT, DOMAIN], ids=str)
    @pytest.mark.parametrize("size", SIZES)
    def test_segmented_download(
        self,
        device: ForeignDevice,
        client: SuiteClient,
        mux: Multiplexer,
        size: int,
        sized: bool,
    ) -> None:
        client.download(mux, payload(size), segmented=True, sized=sized)
        assert device.read(mux) == payload(size)
        assert client.upload(mux).data == payload(size)

    @pytest.mark.parametrize("size", range(1, 5))
    def test_expedited_download_of_text(
        self, device: ForeignDevice, client: SuiteClient, size: int
    ) -> None:
        client.download(TEXT, payload(size))
        assert device.read(TEXT) == payload(size)

    @pytest.mark.parametrize("segmented", [None, True], ids=["as it fits", "segmented"])
    def test_numbers(
        self, device: ForeignDevice, client: SuiteClient, segmented: bool | None
    ) -> None:
        for mux in writable_numbers(device):
            value = payload(len(device.read(mux)))
            client.download(mux, value, segmented=segmented)
            assert device.read(mux) == value
            assert client.upload(mux).data == value

    def test_expedited_download_without_size(
        self, device: ForeignDevice, client: SuiteClient
    ) -> None:
        client.download(NUMBER, b"\x01\x02\x03\x04", sized=False)
        assert device.read(NUMBER) == b"\x01\x02\x03\x04"

    def test_write_only_number(self, device: ForeignDevice, client: SuiteClient) -> None:
        client.download(WRITE_ONLY, b"\x01\x02\x03\x04")
        assert device.read(WRITE_ONLY) == b"\x01\x02\x03\x04"

    @pytest.mark.parametrize(
        ("mux", "code"),
        [
            (MISSING, AbortCode.OBJECT_MISSING),
            (Multiplexer(IDENTITY.index, 5), AbortCode.SUB_INDEX_MISSING),
            (WRITE_ONLY, AbortCode.READ_OF_WRITE_ONLY),
        ],
        ids=str,
    )
    def test_refused_upload(self, client: SuiteClient, mux: Multiplexer, code: AbortCode) -> None:
        assert client.refusal(client.client.upload(mux)) == code
        assert client.upload(IDENTITY).data == b"\x04"

    @pytest.mark.parametrize(
        ("mux", "data", "code"),
        [
            (MISSING, b"\x01", AbortCode.OBJECT_MISSING),
            (Multiplexer(IDENTITY.index, 5), b"\x01", AbortCode.SUB_INDEX_MISSING),
            (IDENTITY, b"\x01", AbortCode.WRITE_OF_READ_ONLY),
            (DEVICE_NAME, b"another name", AbortCode.WRITE_OF_READ_ONLY),
            (NUMBER, bytes(3), AbortCode.LENGTH_MISMATCH),
            (NUMBER, bytes(20), AbortCode.LENGTH_MISMATCH),
        ],
        ids=str,
    )
    def test_refused_download(
        self, client: SuiteClient, mux: Multiplexer, data: bytes, code: AbortCode
    ) -> None:
        assert client.refusal(client.client.download(mux, data)) == code
        assert client.upload(IDENTITY).data == b"\x04"

    def test_refused_download_changes_nothing(
        self, device: ForeignDevice, client: SuiteClient
    ) -> None:
        device.write(NUMBER, b"\x04\x03\x02\x01")
        client.refusal(client.client.download(NUMBER, bytes(20)))
        assert device.read(NUMBER) == b"\x04\x03\x02\x01"
