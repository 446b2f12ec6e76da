"""A device that has a program or a command to recover it: awaited at the start, brought back."""

from conformance.bus.channel import Channel
from conformance.bus.errors import ProcessFailed
from conformance.device.device import DEVICE_TYPE
from conformance.device.process import DeviceProcess, ProcessSettings
from conformance.sdo.frames import UploadInitiate
from conformance.sdo.nmt import NmtState, error_control

# The program may end while it is awaited: seconds between two looks.
LOOK = 0.1


class Revival:
    """Starts a device, and starts it again whenever it was lost; ``is_active`` while it does.

    ``has_booted``: it has sent its boot-up message the last time, and what was asked before that
    it has not answered.
    """

    def __init__(self, settings: ProcessSettings, process: DeviceProcess, channel: Channel) -> None:
        """Take the program, which is not running yet, and the channel on which it will answer."""
        self.process = process
        self.is_active = False
        self.has_booted = False
        self._channel = channel
        self._start_limit = settings.start_limit
        self._attempts = settings.attempts

    def start(self) -> None:
        """Start the program and await the device; raises ProcessFailed with its output."""
        self.process.start()
        self._await()

    def attempt(self) -> str:
        """Bring a lost device back; return an empty text, or why it cannot be done.

        What does not come back at once is tried again, a few times.
        """
        self.is_active = True
        try:
            return self._attempt()
        finally:
            self.is_active = False

    def _attempt(self) -> str:
        why = "no attempt was allowed"
        for _ in range(self._attempts):
            try:
                self.process.stop()
                self.process.recover()
                self.start()
            except ProcessFailed as error:
                why = str(error)
            else:
                return ""
            if self._channel.link.stop.requests:
                break
        return why

    def _await(self) -> None:
        """Wait for the boot-up message or an answer to a read of 1000h, whichever comes first."""
        channel = self._channel
        channel.overheard.clear()
        self.has_booted = False
        limit = channel.link.deadline(self._start_limit)
        ask_at, asked = channel.link.deadline(channel.response_timeout), False
        while not limit.has_passed:
            self.process.check()
            if ask_at.has_passed:
                channel.send(UploadInitiate(DEVICE_TYPE))
                ask_at, asked = channel.link.deadline(channel.response_timeout), True
            if channel.receive(LOOK) is not None:
                return
            if self._booted():
                # What was asked before may be answered still: the run must not meet it.
                self.has_booted = not asked or channel.receive() is None
                return
        self.process.check()
        raise ProcessFailed(
            f"Node {channel.node_id} was started, but neither booted nor answered within "
            f"{self._start_limit:g} s. Is it on the same bus, with that node-ID?"
            f"{self.process.last_words()}"
        )

    def _booted(self) -> bool:
        return error_control(self._channel.node_id, NmtState.INITIALISING) in (
            self._channel.overheard
        )
