"""The risky frames of cases, which a server may not survive.

Servers stop at frames that their authors never met: of another length than 8 bytes, remote ones,
with a 29-bit identifier, segments that are lost, specifiers that mean nothing. A case states its
risk above its function (``must(..., risk=LOST_SEGMENT)``, or a function from its argument). Cases
run in the order of their risks, so that a device that nothing brings back has been tested before it
is stopped; and by its risk it is known what has stopped a device before (see ``losses``).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import FRAME_LENGTH, Message


class Kind(IntEnum):
    """Kinds of stimuli; the higher the number, the more likely a server is to stop at it."""

    ORDINARY = 0
    UNKNOWN_SPECIFIER = 1
    LOST_SEGMENT = 2
    ANYTHING = 3
    EXTENDED = 4
    REMOTE = 5
    LENGTH = 6


@dataclass(frozen=True, slots=True)
class Risk:
    """A kind of stimulus, with its words.

    An ordinary one is a risk where it is sent and nowhere else; the others are the same for a
    server in whatever state it gets them.
    """

    kind: Kind
    text: str

    @property
    def is_everywhere(self) -> bool:
        """Whether it is the same risk in other cases."""
        return self.kind is not Kind.ORDINARY

    def was_met(self, sent: Iterable[CanFrame]) -> bool:
        """Say whether it was among the frames that were sent.

        A single frame does not show whether a segment was lost, or a conversation was random.
        """
        if self.kind in (Kind.LOST_SEGMENT, Kind.ANYTHING):
            return True
        return any(risk_of_frame(frame) == self for frame in sent)


LOST_SEGMENT = Risk(Kind.LOST_SEGMENT, "a segment of a block out of sequence")
ANYTHING = Risk(Kind.ANYTHING, "a random conversation")
EXTENDED = Risk(Kind.EXTENDED, "a frame with a 29-bit identifier")
REMOTE = Risk(Kind.REMOTE, "a remote frame")
UNKNOWN_SPECIFIER = Risk(Kind.UNKNOWN_SPECIFIER, "an unknown command specifier")
RiskOf = Callable[[Any], Risk | None]

_SERVICES: dict[type[Request], str] = {
    DownloadInitiate: "a download initiate",
    DownloadSegment: "a download segment",
    UploadInitiate: "an upload initiate",
    UploadSegment: "a request for a segment",
    Abort: "an abort",
    BlockDownloadInitiate: "a block download initiate",
    BlockEnd: "the end of a block download",
    BlockUploadInitiate: "a block upload initiate",
    BlockUploadStart: "the start of a block upload",
    BlockAck: "an acknowledgement of segments",
    BlockEndResponse: "a confirmation of the end of a block upload",
}


def of_length(length: int) -> Risk | None:
    """Return the risk of a frame with ``length`` data bytes; none for the length that is due."""
    if length == FRAME_LENGTH:
        return None
    return Risk(Kind.LENGTH, "a frame of 1 byte" if length == 1 else f"a frame of {length} bytes")


def risk_of_frame(frame: CanFrame) -> Risk:
    """Return the oddity of a frame, or else its service."""
    if frame.remote:
        return REMOTE
    if frame.extended:
        return EXTENDED
    return of_length(len(frame.data)) or risk_of_request(frame.data)


def risk_of_request(request: Message | bytes) -> Risk:
    """Return the risk of a request of 8 bytes, by its specifier."""
    decoded = decode_request(request if isinstance(request, bytes) else request.encode())
    if isinstance(decoded, Unknown):
        return UNKNOWN_SPECIFIER
    return Risk(Kind.ORDINARY, _SERVICES[type(decoded)])
