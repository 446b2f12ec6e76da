"""Reads the files of the tests, and what was found in them."""

import re
from pathlib import Path

import pytest

from conformance.device.eds_listing import Listing
from conformance.device.files import FileError
from conformance.device.known_objects import KnownObject
from conformance.eds.reading import DeviceFile, parse_eds
from conformance.sdo.layout import Multiplexer

FILES = Path(__file__).parent / "files"
PATH = Path("bad.eds")
DRIVE = (FILES / "drive.eds").read_text(encoding="utf-8")


def parse(text: str) -> DeviceFile:
    return parse_eds(PATH, text, 5)


def sentence(text: str) -> str:
    with pytest.raises(FileError) as caught:
        parse(text)
    return str(caught.value)


# What is wrong with the files of the tests before they are spoiled.
BESIDE = ("bit-rate", "device-info", "error-control", "pdo-count", "process-data", "standard-name")


def ids(file: DeviceFile) -> list[str]:
    """Return the rules of all findings but those that the files have anyway."""
    found = [one.rule.id.removeprefix("eds.") for one in file.findings]
    return [name for name in found if name not in BESIDE]


def found(file: DeviceFile) -> list[str]:
    """Return rule and text of the same findings, without the numbers of lines."""
    texts = [
        f"{one.rule.id.removeprefix('eds.')}: " + re.sub(r"line \d+", "line N", one.text)
        for one in file.findings
    ]
    return [text for text in texts if not text.startswith(BESIDE)]


def entry(listing: Listing, index: int, sub_index: int = 0) -> KnownObject:
    known = listing.find(Multiplexer(index, sub_index))
    assert known is not None
    return known
