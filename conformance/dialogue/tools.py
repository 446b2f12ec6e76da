"""All that a case may be given of its conversation with a device."""

from dataclasses import dataclass

from conformance.dialogue.blocks import Blocks
from conformance.dialogue.channels import Channels
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.storage import Storage


@dataclass(frozen=True, slots=True)
class CaseTools:
    """The conversation of a case, and what works by means of it, by the names of arguments."""

    sdo: Dialogue
    room: Room
    blocks: Blocks
    network: Network
    parameters: Parameters
    channels: Channels
    storage: Storage

    @classmethod
    def of(cls, sdo: Dialogue) -> "CaseTools":
        """Return what works by means of a conversation."""
        network = Network(sdo)
        return cls(
            sdo,
            Room(sdo),
            Blocks(sdo),
            network,
            Parameters(sdo),
            Channels(sdo),
            Storage(sdo, network),
        )
