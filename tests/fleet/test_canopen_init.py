"""conformance init reads the LocalNode of the PyPI package canopen."""

import re
from pathlib import Path

import pytest
from canopen_server import canopen_device
from foreign_objects import NODE_ID

from conformance.__main__ import main
from conformance.device import options as table
from conformance.device.description import read_description
from conformance.reference.built_in_device import REFERENCE_OBJECTS
from conformance.sdo.objects import Access, DataType

# The domain holds letters, and is taken for a string.
NAMED = {
    known.mux: known.data_type
    for known in REFERENCE_OBJECTS
    if known.access is Access.RW and known.data_type is not DataType.DOMAIN
}


def test_a_draft_of_a_local_node(
    virtual_channel: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is read as it is and with every proposal, and nothing has changed."""
    monkeypatch.setattr("conformance.proposing.reading.LAST_SEARCHED", 0x20FF)
    path = tmp_path / "device.toml"
    bus = ("--can-interface", "virtual", "--can-channel", virtual_channel)
    with canopen_device(virtual_channel, NODE_ID) as device:
        named = {mux: device.read(mux) for mux in NAMED}
        assert main(["init", "--node-id", str(NODE_ID), *bus, "-o", str(path)]) == 0
        assert {mux: device.read(mux) for mux in NAMED} == named
    as_it_is = read_description(path)
    assert (as_it_is[table.NODE_ID], as_it_is[table.WRITABLE]) == ([NODE_ID], ())
    path.write_text(re.sub(r"(?m)^#(?=\S)", "", path.read_text("utf-8")), encoding="utf-8")
    described = [one.known for one in read_description(path)[table.WRITABLE]]
    writable = {known.mux: known.data_type for known in described}
    assert writable.items() >= NAMED.items()
