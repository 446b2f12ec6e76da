"""The SDO channel on which a client talks to the device, out of the client's own EDS or DCF.

Such a client, a PLC for example, keeps each of its channels in an SDO client parameter record,
1280h to 12FFh: the COB-IDs of requests and responses, and the node-ID of the server (CiA 301,
7.5.2.34). That of the device itself tells nothing of it: its 1280h leads to yet another node.
"""

from pathlib import Path

from conformance.device.files import FileError, shortened
from conformance.device.known_objects import KnownObject
from conformance.device.option_kinds import CLIENT_RECORDS
from conformance.eds.reading import commissioned_node_id, read_file
from conformance.eds.text import COMMISSIONING, NODE_ID_KEY, Section
from conformance.sdo.cob_id import ChannelError, ChannelIds, ClientParameter

SUB_INDICES = (1, 2, 3)


def read_client_channel(path: Path, index: int, node_id: int) -> ChannelIds:
    """Return the channel to the server of a node that a record in a client's EDS or DCF holds.

    ``$NODEID`` stands for the node-ID of the client, which its DCF says. Raises FileError.
    """
    # The node-ID of the client stands in the file, and has to be known to read the rest.
    file = read_file(path, 0)
    client = commissioned_node_id(file.sections)
    commissioning = file.sections.get(COMMISSIONING)
    if client is not None:
        file = read_file(path, client)
    elif commissioning is not None and commissioning.text(NODE_ID_KEY):
        text = commissioning.text(NODE_ID_KEY)
        wrong = f"{NODE_ID_KEY}={shortened(text)} is no number: write 10 or 0x0A."
        raise _error(path, commissioning, wrong, NODE_ID_KEY)
    listed = file.listing.objects.get(index)
    if listed is None:
        there = [f"{known:04X}h" for known in file.listing.objects if known in CLIENT_RECORDS]
        raise FileError(
            path,
            None,
            f"there is no SDO client parameter record {index:04X}h; "
            + (f"there are {', '.join(there)}." if there else "there is none at all."),
        )
    head = file.sections.get(f"{index:04X}", Section(f"{index:04X}", 0))
    values = {}
    for sub_index in SUB_INDICES:
        known = listed.entries.get(sub_index)
        if known is None:
            raise _error(
                path,
                head,
                f"{index:04X}h has no sub-index {sub_index}: an SDO client parameter has the "
                "COB-IDs of requests (1) and responses (2) and the node-ID of the server (3).",
            )
        section = file.sections.get(f"{index:04X}sub{sub_index:X}", head)
        values[sub_index] = _value(path, section, known, client)
    try:
        return ClientParameter.from_values(values).channel_to(node_id)
    except ChannelError as error:
        raise _error(
            path, head, f"{index:04X}h is no channel to node {node_id}: {error}."
        ) from None


def _error(path: Path, section: Section, sentence: str, key: str = "") -> FileError:
    return FileError(path, section.at(key).line, sentence)


def _value(path: Path, section: Section, known: KnownObject, client: int | None) -> bytes:
    """Return the value of an entry; a formula is none as long as the client is any node."""
    key = "DefaultValue" if known.configured is None else "ParameterValue"
    if known.stated is None:
        raise _error(
            path, section, f"[{section.name}] has neither a ParameterValue nor a DefaultValue."
        )
    if client is None and "$NODEID" in section.text(key).upper():
        raise _error(
            path,
            section,
            f"{key}={shortened(section.text(key))} depends on the node-ID of the client: say it "
            "in the section [DeviceComissioning], as NodeID=1.",
            key,
        )
    return known.stated
