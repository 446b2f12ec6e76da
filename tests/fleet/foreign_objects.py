"""What the foreign devices hold: the objects of the built-in device, under a name of their own."""

import random
from typing import Protocol

from conformance.device.known_objects import KnownObject
from conformance.reference.built_in_device import REFERENCE_OBJECTS, reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry

NODE_ID = 5
DEVICE_NAME = Multiplexer(0x1008)
SOFTWARE_VERSION = Multiplexer(0x100A)
IDENTITY = Multiplexer(0x1018)
NUMBER = Multiplexer(0x2004)
TEXT = Multiplexer(0x2010)
DOMAIN = Multiplexer(0x2011)
WRITE_ONLY = Multiplexer(0x2020)
MISSING = Multiplexer(0x2FFF)

# Every remainder of 7 and of 4, one byte of length exhausted, one sub-block of 127 segments and
# one byte more, and something long.
SIZES = (*range(1, 23), 255, 256, 889, 890, 4096)


class ForeignDevice(Protocol):
    """A foreign device seen from its application."""

    @property
    def unknown_types(self) -> frozenset[DataType]:
        """The types that its implementation does not have, and so neither their objects."""

    def read(self, mux: Multiplexer) -> bytes:
        """Return what an entry holds."""

    def write(self, mux: Multiplexer, data: bytes) -> None:
        """Let an entry hold something else."""


def foreign_entries(node_id: int, name: str, version: str) -> dict[Multiplexer, Entry]:
    """Return the entries of the built-in device, with the name and version of the foreign one."""
    entries = reference_entries(node_id)
    entries[DEVICE_NAME].value = name.encode()
    entries[SOFTWARE_VERSION].value = version.encode()
    return entries


def readable(device: ForeignDevice) -> list[Multiplexer]:
    """Return the entries of the built-in device that this one has too and lets clients read."""
    return [
        mux
        for mux, entry in reference_entries(NODE_ID).items()
        if entry.access.readable and entry.data_type not in device.unknown_types
    ]


def named_objects(device: ForeignDevice) -> list[KnownObject]:
    """Return what a user would name with --sdo-object."""
    return [known for known in REFERENCE_OBJECTS if known.data_type not in device.unknown_types]


def writable_numbers(device: ForeignDevice) -> list[Multiplexer]:
    """Return the numbers that clients may read and write."""
    return [
        known.mux
        for known in named_objects(device)
        if known.length is not None and known.access.readable
    ]


def payload(size: int) -> bytes:
    """Return bytes that do not repeat themselves, the same for a size in every run."""
    return random.Random(size).randbytes(size)
