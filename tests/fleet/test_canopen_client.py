"""The client of the PyPI package canopen against our reference server."""

from collections.abc import Iterator
from typing import IO, Any

import can
import canopen
import pytest
from canopen.objectdictionary import ObjectDictionary
from canopen.sdo.client import SdoClient
from foreign_objects import (
    DEVICE_NAME,
    DOMAIN,
    IDENTITY,
    MISSING,
    NODE_ID,
    NUMBER,
    SIZES,
    TEXT,
    WRITE_ONLY,
    payload,
)

from conformance.reference.built_in_device import reference_entries
from conformance.reference.dictionary import reference_device
from conformance.reference.host import NodeHost
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry
from conformance.sdo.objects import ObjectDictionary as ReferenceObjects


@pytest.fixture(scope="module")
def served(virtual_channel: str) -> Iterator[ReferenceObjects]:
    """The object dictionary of the reference server, which serves on the virtual bus."""
    objects = reference_device(NODE_ID)
    bus = can.Bus(interface="virtual", channel=virtual_channel)
    with NodeHost(bus, Node(NODE_ID, Server(objects))):
        yield objects


@pytest.fixture
def text(served: ReferenceObjects) -> Entry:
    """The writable string of the reference server."""
    return served.find(TEXT)


@pytest.fixture
def domain(served: ReferenceObjects) -> Entry:
    """The writable domain of the reference server."""
    return served.find(DOMAIN)


@pytest.fixture(scope="module")
def sdo(virtual_channel: str, served: ReferenceObjects) -> Iterator[SdoClient]:
    """The SDO client of canopen; it knows nothing of the objects, so it changes no data."""
    with canopen.Network(can.Bus(interface="virtual", channel=virtual_channel)) as network:
        network.NOTIFIER_CYCLE = 0.05
        node = canopen.RemoteNode(NODE_ID, ObjectDictionary())  # type: ignore[no-untyped-call]
        network.add_node(node)
        network.connect()
        node.sdo.RESPONSE_TIMEOUT = 5
        yield node.sdo


def refusal(sdo: SdoClient, mux: Multiplexer, data: bytes | None = None) -> int:
    """Write ``data``, or read for None, and return the code of the abort that has to come."""
    try:
        if data is None:
            sdo.upload(mux.index, mux.sub_index)
        else:
            sdo.download(mux.index, mux.sub_index, data)
    except canopen.SdoAbortedError as aborted:
        return aborted.code
    raise AssertionError(f"{mux} was not refused")


def stream(sdo: SdoClient, mux: Multiplexer, mode: str, **options: int) -> IO[Any]:
    """Open an object as a file: canopen's own way to move data piece by piece."""
    opened: IO[Any] = sdo.open(mux.index, mux.sub_index, mode, **options)  # type: ignore[no-untyped-call]
    return opened


def test_every_readable_entry_reads_as_it_is(sdo: SdoClient) -> None:
    entries = reference_entries(NODE_ID)
    known = {mux: entry.value for mux, entry in entries.items() if entry.access.readable}
    assert {mux: sdo.upload(mux.index, mux.sub_index) for mux in known} == known


@pytest.mark.parametrize("size", SIZES)
def test_upload(sdo: SdoClient, domain: Entry, size: int) -> None:
    domain.value = payload(size)
    assert sdo.upload(DOMAIN.index, 0) == payload(size)


def test_upload_of_nothing(sdo: SdoClient, text: Entry) -> None:
    text.value = b""
    assert sdo.upload(TEXT.index, 0) == b""


@pytest.mark.parametrize("size", SIZES)
def test_upload_as_a_stream(sdo: SdoClient, domain: Entry, size: int) -> None:
    domain.value = payload(size)
    with stream(sdo, DOMAIN, "rb") as opened:
        assert opened.read() == payload(size)


@pytest.mark.parametrize("size", SIZES)
def test_download(sdo: SdoClient, domain: Entry, size: int) -> None:
    sdo.download(DOMAIN.index, 0, payload(size))
    assert domain.value == payload(size)


@pytest.mark.parametrize("size", range(1, 5))
def test_segmented_download_of_little(sdo: SdoClient, domain: Entry, size: int) -> None:
    sdo.download(DOMAIN.index, 0, payload(size), force_segment=True)
    assert domain.value == payload(size)


@pytest.mark.parametrize("length", [1, 2, 3, 4, 8])
@pytest.mark.parametrize("force_segment", [False, True])
def test_number(sdo: SdoClient, served: ReferenceObjects, length: int, force_segment: bool) -> None:
    mux = Multiplexer(0x2000 + length)
    sdo.download(mux.index, 0, payload(length), force_segment)
    assert served.find(mux).value == payload(length)
    assert sdo.upload(mux.index, 0) == payload(length)


def test_text_as_a_stream(sdo: SdoClient, text: Entry) -> None:
    with stream(sdo, TEXT, "w", size=14) as opened:
        opened.write("fourteen bytes")
    assert text.value == b"fourteen bytes"
    with stream(sdo, TEXT, "r") as opened:
        assert opened.read() == "fourteen bytes"


def test_write_only_number(sdo: SdoClient, served: ReferenceObjects) -> None:
    sdo.download(WRITE_ONLY.index, 0, b"\x01\x02\x03\x04")
    assert served.find(WRITE_ONLY).value == b"\x01\x02\x03\x04"
    assert refusal(sdo, WRITE_ONLY) == AbortCode.READ_OF_WRITE_ONLY


@pytest.mark.parametrize(
    ("mux", "data", "code"),
    [
        (MISSING, None, AbortCode.OBJECT_MISSING),
        (MISSING, b"\x01", AbortCode.OBJECT_MISSING),
        (MISSING, bytes(20), AbortCode.OBJECT_MISSING),
        (Multiplexer(IDENTITY.index, 5), None, AbortCode.SUB_INDEX_MISSING),
        (Multiplexer(NUMBER.index, 1), b"\x01", AbortCode.SUB_INDEX_MISSING),
        (IDENTITY, b"\x01", AbortCode.WRITE_OF_READ_ONLY),
        (DEVICE_NAME, b"another name", AbortCode.WRITE_OF_READ_ONLY),
        (NUMBER, bytes(3), AbortCode.LENGTH_TOO_LOW),
        (NUMBER, bytes(5), AbortCode.LENGTH_TOO_HIGH),
        (Multiplexer(0x2001), bytes(2), AbortCode.LENGTH_TOO_HIGH),
    ],
)
def test_refusal(
    sdo: SdoClient,
    served: ReferenceObjects,
    mux: Multiplexer,
    data: bytes | None,
    code: AbortCode,
) -> None:
    assert refusal(sdo, mux, data) == code
    # The abort is all that came: the next transfer goes as if nothing had been.
    device_type = reference_entries(NODE_ID)[Multiplexer(0x1000)].value
    assert sdo.upload(0x1000, 0) == device_type


def test_refused_write_changes_nothing(sdo: SdoClient, served: ReferenceObjects) -> None:
    served.find(NUMBER).value = b"\x04\x03\x02\x01"
    refusal(sdo, NUMBER, bytes(20))
    assert served.find(NUMBER).value == b"\x04\x03\x02\x01"


@pytest.mark.parametrize("crc", [True, False])
@pytest.mark.parametrize("size", SIZES)
def test_block_download(sdo: SdoClient, domain: Entry, size: int, crc: bool) -> None:
    data = payload(size)
    with stream(
        sdo, DOMAIN, "wb", size=size, block_transfer=True, request_crc_support=crc
    ) as opened:
        opened.write(data)
    assert domain.value == data


# Without asking for a CRC, canopen's client checks one all the same when the server offers it.
@pytest.mark.parametrize("size", SIZES)
def test_block_upload(sdo: SdoClient, domain: Entry, size: int) -> None:
    domain.value = payload(size)
    with stream(sdo, DOMAIN, "rb", block_transfer=True) as opened:
        assert opened.read() == domain.value


# The most that 16 bits count, in a last segment of one byte; and more, in a full one.
BEYOND_16_BITS = (65_535, 70_000)


@pytest.mark.parametrize("size", BEYOND_16_BITS)
def test_long_values_in_segments(sdo: SdoClient, domain: Entry, size: int) -> None:
    sdo.download(DOMAIN.index, 0, payload(size))
    assert domain.value == payload(size)
    assert sdo.upload(DOMAIN.index, 0) == payload(size)


@pytest.mark.parametrize("size", BEYOND_16_BITS)
def test_long_values_in_blocks(sdo: SdoClient, domain: Entry, size: int) -> None:
    with stream(sdo, DOMAIN, "wb", size=size, block_transfer=True) as opened:
        opened.write(payload(size))
    assert domain.value == payload(size)
    with stream(sdo, DOMAIN, "rb", block_transfer=True) as opened:
        assert opened.read() == payload(size)


def test_client_abort_ends_a_download(sdo: SdoClient, text: Entry) -> None:
    text.value = b"as before"
    stream(sdo, TEXT, "wb", buffering=0, size=20).write(b"1234567")
    sdo.abort(AbortCode.GENERAL_ERROR)  # type: ignore[no-untyped-call]
    assert sdo.upload(TEXT.index, 0) == b"as before"
