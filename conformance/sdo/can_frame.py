"""A CAN frame as a value, whatever bus it came from."""

import re
from typing import NamedTuple, Self

_WRITTEN = re.compile(
    r"(?:([0-9A-F]{8})|([0-9A-F]{3}))#(?:(#0)?((?:[0-9A-F]{2})*)|R([0-8]?))", re.IGNORECASE
)


class CanFrame(NamedTuple):
    """One CAN frame.

    ``can_id`` has 11 bits, or 29 when ``extended``. ``length`` is the data length code; a remote
    frame has one too but carries no data. ``None`` stands for the length of the data. An ``fd``
    frame is one of CAN FD, which no service of CiA 301 uses.
    """

    can_id: int
    data: bytes = b""
    extended: bool = False
    remote: bool = False
    length: int | None = None
    fd: bool = False

    @property
    def dlc(self) -> int:
        """The data length code."""
        return len(self.data) if self.length is None else self.length

    def __str__(self) -> str:
        """Write the frame as ``cansend`` takes it, for example ``605#4000100000000000``."""
        can_id = f"{self.can_id:08X}" if self.extended else f"{self.can_id:03X}"
        body = f"R{self.dlc or ''}" if self.remote else self.data.hex().upper()
        return f"{can_id}##0{body}" if self.fd else f"{can_id}#{body}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read what ``str`` writes; raises ValueError."""
        found = _WRITTEN.fullmatch(text)
        if found is None:
            raise ValueError(f"{text!r} is no frame as cansend takes it")
        long_id, short_id, fd, data, remote = found.groups()
        can_id, extended = int(long_id or short_id, 16), bool(long_id)
        if remote is not None:
            return cls(can_id, b"", extended, remote=True, length=int(remote or 0))
        return cls(can_id, bytes.fromhex(data), extended, fd=bool(fd))
