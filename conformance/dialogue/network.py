"""What a case does beside SDO: NMT commands, boot-up and heartbeat, communication parameters.

All of it needs a permission of the user. What was done is undone: the device ends Pre-operational,
and the parameters get back what they held.
"""

import time

from conformance.bus.channel import Channel
from conformance.device.deny import LOAD_DEFAULTS, NMT, SDO_PARAMETERS, STORE_PARAMETERS
from conformance.device.device import Device
from conformance.device.lacking import NotTestable
from conformance.dialogue.blocks import BlockSteps
from conformance.dialogue.causes import BOOTED_AS_HEARTBEAT, Causes
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ServerAborted
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import (
    COMMUNICATION_AREA,
    TRANSITIONS,
    NmtCommand,
    NmtMessage,
    NmtState,
)
from conformance.sdo.rules import Rule, Violation
from conformance.sdo.rules.channels import NMT_INITIALISING

HEARTBEAT_TIME = Multiplexer(0x1017)
# What is asked for, in seconds; the second where the first is refused as too short.
HEARTBEAT_PERIODS = (0.02, 0.1)
# A device that has a time of its own is watched by it, unless that takes longer than this.
LONGEST_PERIOD = 0.25
# A bit beside the state in what a device sends for error control.
TOGGLED = 0x7F
# How many heartbeats a device may have in its queue when it stops to send them.
MOST_QUEUED = 8
# Within how many seconds a device boots.
BOOT_TIME = 5.0
# How long a device without heartbeats gets to enter a state that nobody can see.
SETTLING_TIME = 0.1
TOO_SHORT = (AbortCode.VALUE_TOO_LOW, AbortCode.VALUE_INVALID)
PURPOSES = {
    NMT: "to send NMT commands to the device",
    SDO_PARAMETERS: "to write the SDO parameters of the device (1200h to 12FFh)",
    STORE_PARAMETERS: "to let the device store its parameters (1010h)",
    LOAD_DEFAULTS: "to let the device load its defaults (1011h)",
}


class NetworkSteps(BlockSteps):
    """NMT and communication parameters of one device."""

    def __init__(
        self,
        channel: Channel,
        device: Device,
        rule: Rule,
        seed: int,
        causes: Causes | None = None,
    ) -> None:
        """Nothing was asked of the device yet: its NMT state is what it was."""
        super().__init__(channel, device, rule, seed, causes)
        self.nmt_state: NmtState | None = None
        self.expected_boot_ups = 0
        self._booting = False
        # The time between heartbeats in seconds, 0 where there are none, or too few.
        self._period = 0.0

    def require(self, permission: str) -> None:
        """Raise NotTestable without a permission."""
        if permission not in self.device.permissions:
            raise NotTestable(
                f"needs permission {PURPOSES[permission]}: add --sdo-allow={permission}"
            )

    @property
    def on_default_channel(self) -> bool:
        """Whether the case talks on the default channel of the device, which is always there."""
        return self.channel.ids == ChannelIds.default(self.device.node_id)

    # Network management

    def nmt(self, command: NmtCommand) -> None:
        """Send a command to the device."""
        self.require(NMT)
        state = TRANSITIONS[command]
        if state is NmtState.INITIALISING:
            if not self.on_default_channel:
                raise NotTestable("a reset may end this channel: needs the default SDO channel")
            self.expected_boot_ups += 1
            self._booting = True
            self._period = 0.0
            self._expect_reset(command)
        if not state.serves_sdo:
            self.tracker.open = None
        self.calms_down = state.serves_sdo
        self.nmt_state = state
        self.seen.clear()
        self.channel.send_nmt(NmtMessage(command, self.device.node_id))

    def _expect_reset(self, command: NmtCommand) -> None:
        """Count as written what a reset may change: it is put back after the case."""
        everything = command is NmtCommand.RESET_NODE
        reset = {
            known.mux
            for known in self.device.resettable()
            if everything or known.mux.index in COMMUNICATION_AREA
        }
        for mux in reset:
            self.device.will_change(mux)
        self.written |= reset

    def expect_boot_up(self) -> None:
        """Expect the boot-up message that follows a reset; a wrong one is noted, if it is all."""
        self._booting = False
        odd: CanFrame | None = None
        while (frame := self.channel.receive_error_control(BOOT_TIME)) is not None:
            if frame.data[0] == NmtState.INITIALISING:
                self.nmt_state = NmtState.PRE_OPERATIONAL
                return
            if frame.data[0] & TOGGLED == NmtState.PRE_OPERATIONAL:
                odd = frame
                if self.causes.boots_up_as_heartbeat:
                    break
        if odd is None:
            raise self.breach("a boot-up message", f"none within {BOOT_TIME:g} s")
        self.nmt_state = NmtState.PRE_OPERATIONAL
        wrong = Violation(NMT_INITIALISING, expected="a boot-up message: 00h", actual=f"{odd}")
        wrong.habit = BOOTED_AS_HEARTBEAT
        self.note(wrong)

    def reset(self, command: NmtCommand) -> None:
        """Reset the device and see it boot."""
        self.nmt(command)
        self.expect_boot_up()

    def produce_heartbeats(self) -> Abort | None:
        """Let the device tell its state by a time in 1017h; return the abort if it refuses.

        One that has a time of its own, which cannot be written, tells its state all the same.
        """
        self.require(NMT)
        refusal = self.learn_or_refusal(HEARTBEAT_TIME)
        if refusal is not None:
            return refusal
        for self._period in HEARTBEAT_PERIODS:
            data = round(self._period * 1000).to_bytes(2, "little")
            refusal = self.write_parameter(HEARTBEAT_TIME, data)
            if refusal is None or refusal.code not in TOO_SHORT:
                break
        if refusal is not None:
            own = int.from_bytes(self.device.parameters[HEARTBEAT_TIME], "little") / 1000
            self._period = own if own <= LONGEST_PERIOD else 0.0
        return refusal

    def settle(self) -> None:
        """Wait until the device tells that it is in the state last asked for, twice if it beats.

        The first heartbeat may have been on its way when the last frame was sent to the device.
        """
        if not self._period:
            self._wait_settled()
            return
        told = 0
        patience = max(self.channel.response_timeout, 2 * self._period)
        for _ in range(round(patience / self._period) + 2):
            frame = self.channel.receive_error_control(patience)
            if frame is None:
                raise self.breach("heartbeats, as 1017h says", "none")
            told = told + 1 if frame.data[0] & 0x7F == self.nmt_state else 0
            if told > 1:
                return
        state = NmtState.INITIALISING if self.nmt_state is None else self.nmt_state
        raise self.breach(f"heartbeats with {state:02X}h", f"{frame}")

    def _wait_settled(self) -> None:
        """Let the time pass in which a device settles; a heartbeat now and then does not end it."""
        deadline = time.monotonic() + SETTLING_TIME
        while (left := deadline - time.monotonic()) > 0:
            if self.channel.receive_error_control(left) is None:
                return

    def end_heartbeats(self) -> None:
        """Write 0 to 1017h, and expect no heartbeat beyond those that had been queued before."""
        self.download(HEARTBEAT_TIME, bytes(2))
        # A device that takes its time to confirm that has told its state meanwhile.
        while self.channel.receive_error_control(0.0) is not None:
            pass
        for _ in range(MOST_QUEUED):
            if self.channel.receive_error_control(self._period / 2) is None:
                break
        if self.channel.receive_error_control(2 * self._period) is not None:
            raise self.breach("no heartbeat with 1017h = 0", "one came")
        self._period = 0.0

    def end_nmt(self) -> None:
        """Leave the device in a state in which it serves, whatever became of the case."""
        if self._booting:
            self.channel.receive_error_control(BOOT_TIME)
            self._booting = False
        if self.nmt_state not in (None, NmtState.PRE_OPERATIONAL):
            self.nmt(NmtCommand.ENTER_PRE_OPERATIONAL)

    # Communication parameters

    def learn(self, mux: Multiplexer) -> bool:
        """Read a parameter before it is written for the first time; say whether it is there."""
        return self.learn_or_refusal(mux) is None

    def learn_or_refusal(self, mux: Multiplexer) -> Abort | None:
        """Read a parameter before it is written for the first time; return the abort if refused."""
        if mux not in self.device.parameters:
            try:
                self.device.parameters[mux] = self.read(mux)
            except ServerAborted as aborted:
                return aborted.abort
        return None

    def write_parameter(self, mux: Multiplexer, data: bytes) -> Abort | None:
        """Write a parameter that was learned; return the abort if the server refuses."""
        if not self.learn(mux):
            raise self.breach(f"{mux} to be readable", "it is not")
        return self.try_download(mux, data)
