"""CAN frames to and from the messages of python-can."""

import can

from conformance.sdo.can_frame import CanFrame


def to_message(frame: CanFrame) -> can.Message:
    """Return a frame as python-can sends it."""
    return can.Message(
        arbitration_id=frame.can_id,
        data=None if frame.remote else frame.data,
        dlc=frame.dlc,
        is_extended_id=frame.extended,
        is_remote_frame=frame.remote,
    )


def to_frame(message: can.Message) -> CanFrame:
    """Return what python-can received, or read from a log."""
    return CanFrame(
        message.arbitration_id,
        bytes(message.data),
        message.is_extended_id,
        message.is_remote_frame,
        message.dlc if message.is_remote_frame else None,
    )
