"""A transfer that is begun and not ended, of an object that suits the state."""

from dataclasses import dataclass
from typing import Generic, TypeVar

from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.model_cases.server_states import SIZE, State
from conformance.sdo.frames import Request

Due_co = TypeVar("Due_co", bound=Request, covariant=True)


@dataclass(frozen=True, slots=True)
class OpenTransfer(Generic[Due_co]):
    """A transfer that waits for its client, and the frame with which the client would go on.

    ``value`` is what the object held before a download, None for an upload.
    """

    known: KnownObject
    due: Due_co
    value: bytes | None = None


def begin(sdo: Dialogue, state: State[Due_co]) -> OpenTransfer[Due_co]:
    """Lead the server into a state: by a download to a string, or an upload of what is long."""
    if not state.downloads:
        known, data = Room(sdo).long_object()
        return OpenTransfer(known, state.reach(sdo, known, len(data)))
    text = Roles(sdo.device).text()
    value = Room(sdo).prepare(text, SIZE, state.least)
    return OpenTransfer(text, state.reach(sdo, text, len(value)), value)
