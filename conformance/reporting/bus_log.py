"""bus.log: every frame of a run as ``candump -L`` writes it, with its direction."""

from pathlib import Path

import can

from conformance.bus.link import Captured, Direction


class BusLog:
    """Writes frames as they come."""

    def __init__(self, path: Path, channel: str) -> None:
        """``channel`` is the name that stands in each line."""
        self._writer = can.CanutilsLogWriter(path, channel=channel)

    def write(self, captured: Captured) -> None:
        """Append one frame."""
        frame = captured.frame
        self._writer.on_message_received(
            can.Message(
                timestamp=captured.timestamp,
                arbitration_id=frame.can_id,
                data=None if frame.remote else frame.data,
                dlc=frame.dlc,
                is_extended_id=frame.extended,
                is_remote_frame=frame.remote,
                is_rx=captured.direction is Direction.RECEIVED,
            )
        )

    def close(self) -> None:
        """Finish the file."""
        self._writer.stop()
