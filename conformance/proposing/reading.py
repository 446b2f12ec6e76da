"""Reads a device, for a draft of its device.toml; nothing but reads is sent."""

from collections.abc import Callable, Iterator

from conformance.beginning.discovery import READING, Reading, discover
from conformance.bus.channel import Channel
from conformance.device.device import DEVICE_TYPE, TEXTS, Device
from conformance.device.eds_listing import Listing, mandatory_and
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.learned import Reason
from conformance.device.permits import known_objects
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.proposing.finding import Found, ObjectSearch
from conformance.sdo.emergency import is_error_place
from conformance.sdo.layout import Multiplexer

FIRST_SEARCHED, LAST_SEARCHED = 0x1000, 0x9FFF
# Takes the next object, the number of reads before it, and the number of all.
Progress = Callable[[object, int, int], None]


def read_device(channel: Channel, listing: Listing | None, progress: Progress) -> Device:
    """Get to know a device, and read the objects that its EDS lists.

    Raises SilentNode, TwoDevices and DeviceLost.
    """
    device = Device(
        channel.node_id,
        by_multiplexer(known_objects((), listing or Listing())),
        listing=listing or mandatory_and(()),
    )

    def told(entry: KnownObject, number: int, count: int) -> None:
        progress(entry, number, count)

    discover(channel, device, progress=told)
    return device


def search(channel: Channel, device: Device, progress: Progress) -> Found:
    """Read each index of a device without an EDS; raises DeviceLost."""
    count = LAST_SEARCHED + 1 - FIRST_SEARCHED
    reading = Reading(Dialogue(channel, device, CaseRecord(READING), 0))
    return ObjectSearch(reading).through(
        range(FIRST_SEARCHED, LAST_SEARCHED + 1),
        lambda index: progress(f"{index:04X}h", index - FIRST_SEARCHED, count),
    )


def about(device: Device) -> Iterator[str]:
    """Yield the identity of a device, in sentences."""
    identity = ", ".join(f"{name} {number}" for name, number in device.identity.items())
    yield f"Identity (1018h): {identity or 'could not be read'}"
    texts = [
        f"{mux.index:04X}h {device.values[mux].decode('latin-1')!r}"
        for mux in TEXTS
        if mux in device.values
    ]
    if texts:
        yield f"Name and versions: {', '.join(texts)}"
    kind = int.from_bytes(device.values.get(DEVICE_TYPE, b""), "little")
    profile = f"profile CiA {kind & 0xFFFF}" if kind & 0xFFFF else "no profile"
    yield f"Device type (1000h): {kind:08X}h, {profile}"


def differences(device: Device) -> list[str]:
    """Return a sentence for each thing that a device and its EDS do not agree in."""
    said = []
    for sub_index, number in device.listing.identity.items():
        value = device.values.get(Multiplexer(0x1018, sub_index))
        if value is not None and int.from_bytes(value, "little") != number:
            read = int.from_bytes(value, "little")
            said.append(f"1018h:{sub_index:02X} reads {read:08X}h, the EDS says {number:08X}h")
    for mux, why in device.learned.unreadable.items():
        known = device.known.get(mux)
        if known is None or is_error_place(mux) or device.learned.is_unread(mux, Reason.TOO_LONG):
            continue  # a place of the error list may be empty
        came = device.learned.unread[mux].came or why
        said.append(f"{known.title} is in the EDS, but could not be read: {came}")
    return said
