"""What an EDS or a DCF lists of a device; the three files are as vendors write them."""

from pathlib import Path

import pytest

from conformance.device.eds_listing import Listing, ObjectType
from conformance.device.known_objects import KnownObject
from conformance.eds.reading import parse_eds, read_eds
from conformance.faults.catalogue import build_node
from conformance.reference.built_in_eds import listing_of
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

FILES = Path(__file__).parent / "files"
NODE_ID = 5


def listed(name: str) -> Listing:
    return read_eds(FILES / name, NODE_ID)


def entry(listing: Listing, index: int, sub_index: int = 0) -> KnownObject:
    found = listing.find(Multiplexer(index, sub_index))
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("name", "objects", "entries"),
    [("io_module.eds", 21, 50), ("drive.eds", 19, 29), ("encoder.dcf", 7, 8)],
)
def test_everything_is_listed(name: str, objects: int, entries: int) -> None:
    listing = listed(name)
    assert listing.is_complete
    assert (len(listing.objects), len(listing.entries)) == (objects, entries)


def test_the_identity() -> None:
    assert listed("io_module.eds").identity == {1: 0x2F1, 2: 0x401016, 3: 0x20001}
    assert listed("drive.eds").identity == {1: 0x19A, 2: 1026, 3: 0x10003}
    assert listed("drive.eds").revision == "1.4"


@pytest.mark.parametrize(
    ("index", "sub_index", "value"),
    [(0x1014, 0, 0x80), (0x1200, 1, 0x600), (0x1200, 2, 0x580), (0x1800, 1, 0x180)],
)
def test_formulas_of_the_node_id(index: int, sub_index: int, value: int) -> None:
    for node_id in (1, 127):
        found = entry(read_eds(FILES / "io_module.eds", node_id), index, sub_index)
        assert found.default == (value + node_id).to_bytes(4, "little")


def test_compact_arrays() -> None:
    listing = listed("io_module.eds")
    deltas = listing.objects[0x6426]
    assert deltas.object_type is ObjectType.ARRAY
    assert sorted(deltas.entries) == [0, 1, 2, 3, 4]
    assert entry(listing, 0x6426) == KnownObject(
        Multiplexer(0x6426), DataType.UNSIGNED8, Access.RO, default=b"\x04"
    )
    for sub_index in (1, 4):
        found = entry(listing, 0x6426, sub_index)
        assert (found.low, found.high) == (0, 0x7FFF)
        assert found.default == bytes.fromhex("64000000")
    assert [entry(listing, 0x6000, sub).name for sub in (1, 2)] == [
        "Inputs 1 to 8",
        "Inputs 9 to 16",
    ]


def test_the_count_of_errors_may_be_written_though_it_is_compact() -> None:
    assert entry(listed("io_module.eds"), 0x1003).access is Access.RW


def test_a_compact_number_of_0_is_none() -> None:
    """Editors write CompactSubObj=0 beside SubNumber; canopen's importer fails there."""
    limits = listed("drive.eds").objects[0x607D]
    assert [limits.entries[sub].default for sub in (1, 2)] == [
        bytes.fromhex("00000080"),
        bytes.fromhex("FFFFFF7F"),
    ]


def test_gaps() -> None:
    listing = listed("io_module.eds")
    assert listing.objects[0x1800].gaps == [3, 4]
    assert listing.objects[0x1800].highest == 5
    assert listed("drive.eds").objects[0x2000].gaps == [4, 6]
    assert listing.objects[0x1200].gaps == []


@pytest.mark.parametrize(
    ("name", "index", "sub_index", "limits"),
    [
        ("io_module.eds", 0x2000, 0, (1, 1000)),
        ("drive.eds", 0x6060, 0, (-4, 10)),
        ("drive.eds", 0x607A, 0, (-(2**31), 2**31 - 1)),
        ("drive.eds", 0x6081, 0, (None, 3_000_000)),
        ("drive.eds", 0x2000, 1, (0.5, 12.5)),
        ("drive.eds", 0x2000, 5, (-(2**23), 2**23 - 1)),
    ],
)
def test_limits(
    name: str, index: int, sub_index: int, limits: tuple[float | None, float | None]
) -> None:
    found = entry(listed(name), index, sub_index)
    assert (found.low, found.high) == limits


@pytest.mark.parametrize(
    ("index", "sub_index", "data_type", "default"),
    [
        (0x6081, 0, DataType.UNSIGNED32, "08000000"),  # 010 is octal
        (0x2000, 1, DataType.REAL32, "00002040"),
        (0x2000, 3, DataType.VISIBLE_STRING, "424C2D3630"),
        (0x2000, 5, DataType.INTEGER24, "FFFFFF"),
        (0x2010, 0, DataType.DOMAIN, None),
        (0x2040, 0, None, None),  # a type of the vendor's own
    ],
)
def test_types_and_defaults(
    index: int, sub_index: int, data_type: DataType | None, default: str | None
) -> None:
    found = entry(listed("drive.eds"), index, sub_index)
    assert found.data_type is data_type
    assert found.default == (None if default is None else bytes.fromhex(default))


def test_access_and_flags() -> None:
    drive, encoder = listed("drive.eds"), listed("encoder.dcf")
    assert entry(drive, 0x1001).access is Access.RO
    assert entry(drive, 0x2011).access is Access.WO
    assert entry(drive, 0x1008).access is Access.CONST
    word = entry(drive, 0x6040)
    assert word.access is Access.RW
    assert word.refuses_download
    assert not word.refuses_scan
    position = entry(encoder, 0x6004)
    assert position.access is Access.RW
    assert not position.is_steady


def test_what_a_dcf_configures() -> None:
    """It is in Windows-1252 with CR LF, and its sub-indices stand before their object."""
    encoder = listed("encoder.dcf")
    assert entry(encoder, 0x6001).configured == (3600).to_bytes(4, "little")
    assert entry(encoder, 0x6001).default == (65536).to_bytes(4, "little")
    assert entry(encoder, 0x1018, 1).configured is None


def test_what_pdos_may_map() -> None:
    assert entry(listed("io_module.eds"), 0x1000).mappable is False
    assert entry(listed("io_module.eds"), 0x1001).mappable is True


@pytest.mark.parametrize(
    ("said", "mappable"),
    [
        ("", None),
        ("AccessType=rw\nPDOMapping=0", False),
        ("AccessType=rw\nPDOMapping=1", True),
        ("AccessType=rww\nPDOMapping=0", None),
        ("AccessType=rwr\nPDOMapping=0", None),
        ("AccessType=rww\nPDOMapping=1", True),
    ],
)
def test_a_pdo_mapping_that_is_left_out_or_contradicts_the_access(
    said: str, mappable: bool | None
) -> None:
    text = (FILES / "drive.eds").read_text(encoding="utf-8")
    text += f"\n[2FFF]\nParameterName=x\nDataType=0x5\n{said or 'AccessType=rw'}\n"
    assert entry(parse_eds(Path("x.eds"), text, NODE_ID).listing, 0x2FFF).mappable is mappable


def test_the_eds_of_the_built_in_device_lists_what_it_has() -> None:
    listing = listing_of(build_node(None, NODE_ID))
    entries = dict(build_node(None, NODE_ID).objects.items())
    assert {known.mux for known in listing.entries} == set(entries)
    for known in listing.entries:
        there = entries[known.mux]
        assert known.data_type is there.data_type
        assert known.access is there.access
        assert (known.low, known.high) == (there.low, there.high)
        if there.data_type.length is not None:
            assert known.default == there.value
