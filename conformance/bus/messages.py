"""CAN frames to and from the messages of python-can."""

from typing import Any

import can

from conformance.sdo.can_frame import CanFrame


class _Outgoing(can.Message):
    """A message that is sent once and never changed: all receivers may share it.

    python-can's virtual bus makes a copy for each of them, and its general way to copy takes longer
    than sending and receiving together.
    """

    __slots__ = ()

    def __deepcopy__(self, memo: dict[int, Any] | None) -> can.Message:
        return self


def to_message(frame: CanFrame) -> can.Message:
    """Return a frame as python-can sends it."""
    if frame.length is None and not (frame.remote or frame.fd):
        return _Outgoing(
            arbitration_id=frame.can_id, is_extended_id=frame.extended, data=frame.data
        )
    return _Outgoing(
        arbitration_id=frame.can_id,
        data=None if frame.remote else frame.data,
        dlc=frame.length,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
        is_fd=frame.fd,
    )


def to_frame(message: can.Message) -> CanFrame:
    """Return what python-can received, or read from a log."""
    return CanFrame(
        message.arbitration_id,
        bytes(message.data),
        message.is_extended_id,
        message.is_remote_frame,
        message.dlc if message.is_remote_frame else None,
        message.is_fd,
    )
