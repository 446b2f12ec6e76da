"""Names for a user's own tests, as in ``from conformance import Multiplexer``.

These names stay where they are. Whatever else there is may move between two versions.
"""

from conformance.device.device import Device
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.channels import Channels
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.storage import Storage
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType
from conformance.sdo.rules import Level, Rule, Violation

__all__ = [
    "Abort",
    "AbortCode",
    "BlockDownloadInitiate",
    "BlockUploadInitiate",
    "Blocks",
    "Channels",
    "DataType",
    "Device",
    "Dialogue",
    "DownloadInitiate",
    "DownloadSegment",
    "KnownObject",
    "Level",
    "Multiplexer",
    "Network",
    "Parameters",
    "Roles",
    "Room",
    "Rule",
    "ServerAborted",
    "Storage",
    "UploadInitiate",
    "UploadSegment",
    "Violation",
]
