"""The SDO channel on which a client talks to the device, out of the client's own EDS or DCF.

Such a client, a PLC for example, keeps each of its channels in an SDO client parameter record,
1280h to 12FFh: the COB-IDs of requests and responses, and the node-ID of the server (CiA 301,
7.5.2.34). That of the device itself tells nothing of it: its 1280h leads to yet another node.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from conformance.device.eds import parse_eds
from conformance.device.eds_text import (
    Section,
    commissioned_node_id,
    read_eds_text,
    sections_of,
)
from conformance.device.files import FileError, shortened
from conformance.device.known_objects import KnownObject
from conformance.sdo.cob_id import ChannelError, ChannelIds, ClientParameter
from conformance.sdo.objects import DataType

RECORDS = range(0x1280, 0x1300)
TYPES = {1: DataType.UNSIGNED32, 2: DataType.UNSIGNED32, 3: DataType.UNSIGNED8}
_INDEX = re.compile(r"(?:0x)?([0-9a-f]{4})h?", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class ClientRecord:
    """An SDO client parameter record, and the EDS or DCF of the client that has it."""

    path: Path
    index: int


def parse_channel(text: str) -> ChannelIds | ClientRecord:
    """Read ``REQUEST:RESPONSE``, two CAN-IDs, or ``FILE:RECORD``; whatever has a dot is a file.

    >>> f"{parse_channel('plc.dcf:1280').index:X}h"
    '1280h'

    Raises ChannelError.
    """
    if "." not in text:
        return ChannelIds.parse(text)
    name, colon, record = text.rpartition(":")
    if "." in record or not colon:
        raise ChannelError(f"{text!r} does not say which record of the file: write {text}:1280")
    match = _INDEX.fullmatch(record.strip())
    index = int(match[1], 16) if match else 0
    if index not in RECORDS:
        raise ChannelError(
            f"{record!r} is no SDO client parameter record: write 1280 to 12FF, as in plc.dcf:1280"
        )
    return ClientRecord(Path(name), index)


def read_client_channel(path: Path, index: int, node_id: int) -> ChannelIds:
    """Return the channel to the server of a node that a record in a client's EDS or DCF holds.

    ``$NODEID`` stands for the node-ID of the client, which its DCF says. Raises FileError.
    """
    text = read_eds_text(path)
    sections = sections_of(path, text)
    client = commissioned_node_id(sections)
    objects = parse_eds(path, text, client or 0).objects
    if index not in objects:
        there = [f"{known:04X}h" for known in sorted(objects) if known in RECORDS]
        raise FileError(
            path,
            None,
            f"there is no SDO client parameter record {index:04X}h; "
            + (f"there are {', '.join(there)}." if there else "there is none at all."),
        )
    head = sections[f"{index:04X}"]
    values = {}
    for sub_index, data_type in TYPES.items():
        known = objects[index].entries.get(sub_index)
        if known is None:
            raise head.error(
                f"{index:04X}h has no sub-index {sub_index}: an SDO client parameter has the "
                "COB-IDs of requests (1) and responses (2) and the node-ID of the server (3)."
            )
        section = sections.get(f"{index:04X}sub{sub_index:X}", head)
        values[sub_index] = _value(section, known, data_type, client)
    try:
        return ClientParameter.from_values(values).channel_to(node_id)
    except ChannelError as error:
        raise head.error(f"{index:04X}h is no channel to node {node_id}: {error}.") from None


def _value(section: Section, known: KnownObject, data_type: DataType, client: int | None) -> bytes:
    """Return the value of an entry; a formula is none as long as the client is any node."""
    if known.data_type is not data_type:
        raise section.error(f"[{section.name}] is no {data_type.name}.", "DataType")
    key = "DefaultValue" if known.configured is None else "ParameterValue"
    if known.stated is None:
        raise section.error(f"[{section.name}] has neither a ParameterValue nor a DefaultValue.")
    if client is None and "$NODEID" in section.text(key).upper():
        raise section.error(
            f"{key}={shortened(section.text(key))} depends on the node-ID of the client: say it "
            "in the section [DeviceComissioning], as NodeID=1.",
            key,
        )
    return known.stated
