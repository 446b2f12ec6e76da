"""COB-IDs as the communication objects hold them, and the pair of them that is an SDO channel.

Bit 31 says that the channel does not exist, bit 30 that it was assigned dynamically, bit 29 that
the CAN-ID has 29 bits instead of 11 (CiA 301, 7.5.2.33).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

from conformance.sdo.can_frame import CanFrame

REQUEST_BASE = 0x600
RESPONSE_BASE = 0x580
NOT_VALID = 1 << 31
DYNAMIC = 1 << 30
EXTENDED = 1 << 29
LARGEST_STANDARD_ID = 0x7FF
LARGEST_EXTENDED_ID = 0x1FFF_FFFF
HIGHEST_NODE_ID = 127
SHORT_DIGITS = 3

# CAN-IDs that no object may be configured to use, first and last (CiA 301, 7.3.5).
RESTRICTED = (
    (0x000, 0x000),  # NMT
    (0x001, 0x07F),
    (0x101, 0x180),
    (0x581, 0x5FF),  # responses of the default SDO channels
    (0x601, 0x67F),  # requests on them
    (0x6E0, 0x6FF),
    (0x701, 0x77F),  # error control
    (0x780, 0x7FF),
)


class ChannelError(ValueError):
    """COB-IDs that cannot make an SDO channel; the text says why."""


@dataclass(frozen=True, slots=True)
class CobId:
    """A CAN-ID and whether it is in use.

    Of a value without bit 29, ``can_id`` keeps bits 28 to 11 as well, which have to be 0 there.
    """

    can_id: int
    extended: bool = False
    valid: bool = True
    dynamic: bool = False

    @classmethod
    def from_bytes(cls, value: bytes) -> Self:
        """Read an UNSIGNED32, low byte first."""
        number = int.from_bytes(value, "little")
        return cls(
            number & LARGEST_EXTENDED_ID,
            bool(number & EXTENDED),
            not number & NOT_VALID,
            bool(number & DYNAMIC),
        )

    def __bytes__(self) -> bytes:
        number = self.can_id | EXTENDED * self.extended | DYNAMIC * self.dynamic
        return (number | NOT_VALID * (not self.valid)).to_bytes(4, "little")

    @property
    def identifier(self) -> int:
        """The CAN-ID, with bit 29 where it has 29 bits: one of 11 with this number is another."""
        return self.can_id | EXTENDED * self.extended

    @property
    def is_restricted(self) -> bool:
        """Whether the CAN-ID belongs to another service for good."""
        return not self.extended and any(first <= self.can_id <= last for first, last in RESTRICTED)

    @property
    def has_stray_bits(self) -> bool:
        """Whether an 11-bit CAN-ID has bits behind its 11th."""
        return not self.extended and self.can_id > LARGEST_STANDARD_ID

    def disabled(self) -> "CobId":
        """Return the same CAN-ID, not in use."""
        return replace(self, valid=False)

    def matches(self, frame: CanFrame) -> bool:
        """Say whether a classic data frame has this identifier, in its format."""
        same = frame.can_id == self.can_id and frame.extended == self.extended
        return same and not frame.remote and not frame.fd

    def frame(self, data: bytes) -> CanFrame:
        """Return a data frame with this identifier."""
        return CanFrame(self.can_id, data, self.extended)

    def __str__(self) -> str:
        return f"{self.can_id:08X}h" if self.extended else f"{self.can_id:03X}h"


@dataclass(frozen=True, slots=True)
class ChannelIds:
    """The identifiers of an SDO channel: of its requests (client to server) and its responses."""

    request: CobId
    response: CobId

    @classmethod
    def default(cls, node_id: int) -> Self:
        """Return those of the default channel of a node (CiA 301, 7.3.3)."""
        return cls(CobId(REQUEST_BASE + node_id), CobId(RESPONSE_BASE + node_id))

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``REQUEST:RESPONSE`` in hexadecimal; more than 3 digits are a 29-bit CAN-ID.

        >>> str(ChannelIds.parse("640:5C0"))
        '640h and 5C0h'

        Raises ChannelError.
        """
        request, colon, response = text.strip().partition(":")
        if not colon:
            raise ChannelError(
                f"{text!r} is no SDO channel: write REQUEST:RESPONSE in hexadecimal, as in "
                "640:5C0, or FILE:RECORD of the client, as in plc.dcf:1280"
            )
        ids = cls(_parse_can_id(request), _parse_can_id(response))
        ids.check()
        return ids

    def check(self) -> None:
        """Raise ChannelError for what no SDO channel can be."""
        for cob_id in (self.request, self.response):
            if not cob_id.valid:
                raise ChannelError(f"{cob_id} has bit 31 set: this SDO channel does not exist")
            if not cob_id.extended and cob_id.can_id == 0:
                raise ChannelError("000h is the identifier of NMT commands, not of an SDO channel")
            if cob_id.has_stray_bits:
                raise ChannelError(f"{cob_id.can_id:X}h has more than the 11 bits of its format")
        if self.request == self.response:
            raise ChannelError(f"{self.request} cannot carry both requests and responses")

    def translated(self, frame: CanFrame, to: "ChannelIds") -> CanFrame:
        """Return a frame with an identifier of this channel as one of another, any other as it is.

        One that is in the wrong format is so there too; no frame of 11 bits has an identifier that
        is longer.
        """
        for own, other in ((self.request, to.request), (self.response, to.response)):
            if frame.can_id == own.can_id:
                odd = frame.extended != own.extended
                return frame._replace(can_id=other.can_id, extended=other.extended != odd)
        return frame

    @property
    def in_digits(self) -> str:
        """The form that ``parse`` reads."""
        return ":".join(
            f"{cob_id.can_id:08X}" if cob_id.extended else f"{cob_id.can_id:03X}"
            for cob_id in (self.request, self.response)
        )

    def __str__(self) -> str:
        return f"{self.request} and {self.response}"


@dataclass(frozen=True, slots=True)
class ClientParameter:
    """An SDO client parameter record, 1280h to 12FFh: the channel of a client and its server."""

    request: CobId
    response: CobId
    server: int

    @classmethod
    def from_values(cls, values: Mapping[int, bytes]) -> Self:
        """Take the values of the record by sub-index: 01h request, 02h response, 03h node-ID."""
        return cls(CobId.from_bytes(values[1]), CobId.from_bytes(values[2]), values[3][0])

    def channel_to(self, node_id: int) -> ChannelIds:
        """Return the channel to the server of a node.

        Raises ChannelError where the record is not valid, or leads to another node.
        """
        ids = ChannelIds(self.request, self.response)
        ids.check()
        if not 1 <= self.server <= HIGHEST_NODE_ID:
            raise ChannelError(f"{self.server} is no node-ID: they go from 1 to {HIGHEST_NODE_ID}")
        if self.server != node_id:
            raise ChannelError(f"its server is node {self.server}, not node {node_id}")
        return ids


def _parse_can_id(text: str) -> CobId:
    digits = re.fullmatch(r"(?:0x)?([0-9a-f]+)h?", text.strip(), re.IGNORECASE)
    if digits is None:
        raise ChannelError(f"{text!r} is no CAN-ID: write it in hexadecimal, as in 640")
    extended = len(digits[1]) > SHORT_DIGITS
    can_id = int(digits[1], 16)
    if can_id > (LARGEST_EXTENDED_ID if extended else LARGEST_STANDARD_ID):
        limit = "29 bits (1FFFFFFFh)" if extended else "11 bits (7FFh); more digits mean 29 bits"
        raise ChannelError(f"{text!r} is no CAN-ID: it has more than {limit}")
    return CobId(can_id, extended)
