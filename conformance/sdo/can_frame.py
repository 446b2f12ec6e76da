"""A CAN frame as a value, whatever bus it came from."""

from typing import NamedTuple


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
