"""What a case does beside SDO: NMT commands, boot-up and heartbeat.

All of it needs a permission of the user. The device ends Pre-operational, or in the state in which
it serves more.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from math import ceil

from conformance.bus.deadline import Deadline
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.protected_objects import NMT
from conformance.device.serving import STATE_NAMES, Service
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.serving_trial import ServingTrial
from conformance.dialogue.value_access import ValueAccess
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import (
    COMMUNICATION_AREA,
    TRANSITIONS,
    NmtCommand,
    NmtMessage,
    NmtState,
)
from conformance.sdo.rules import Violation
from conformance.sdo.rules.channels import NMT_INITIALISING
from conformance.sdo.rules.defects import BOOTED_AS_HEARTBEAT, NO_HEARTBEATS
from conformance.sdo.seen import NoAnswer, Said

# What leads to each state in which a device serves.
COMMANDS = {
    NmtState.PRE_OPERATIONAL: NmtCommand.ENTER_PRE_OPERATIONAL,
    NmtState.OPERATIONAL: NmtCommand.START,
}
HEARTBEAT_TIME = Multiplexer(0x1017)
# What is asked for, in seconds; the second where the first is refused as too short. At 10 kbit/s a
# heartbeat takes a third of the first.
HEARTBEAT_PERIODS = (0.02, 0.1)
# A device that has a time of its own is watched by it, unless that takes longer than this.
LONGEST_PERIOD = 0.25
# A bit beside the state in what a device sends for error control.
TOGGLED = 0x7F
# How many heartbeats a device may have in its queue when it stops to send them.
MOST_QUEUED = 8
# Within how many seconds a device boots.
BOOT_TIME = 5.0
# How long a device gets to enter a state that cannot be observed, unless it was seen to be faster.
SETTLING_TIME = 0.1
TOO_SHORT = (AbortCode.VALUE_TOO_LOW, AbortCode.VALUE_INVALID)


class Network:
    """NMT and heartbeat of one device, in one case.

    ``state`` is the NMT state that the device was brought into, None as long as it was not asked
    for one. ``expected_boot_ups`` counts the resets.
    """

    def __init__(self, sdo: Dialogue) -> None:
        """Nothing was asked of the device yet: its NMT state is what it was."""
        self.state: NmtState | None = None
        self.expected_boot_ups = 0
        self._sdo = sdo
        self._device = sdo.device
        self._channel = sdo.channel
        self._parameters = Parameters(sdo)
        self._booting = False
        # The time between heartbeats in seconds, 0 where there are none, or too few.
        self._period = 0.0
        # The state in its last heartbeat, None before the first; and when it was sent a command, by
        # the monotonic clock.
        self._told: int | None = None
        self._sent_at = 0.0

    def send(self, command: NmtCommand) -> None:
        """Send a command to the device."""
        self._device.permits.require(NMT)
        state = TRANSITIONS[command]
        if state is NmtState.INITIALISING:
            if not self._channel.is_default:
                raise NotTestable("a reset may end this channel: needs the default SDO channel")
            self._require_kept(command)
            self.expected_boot_ups += 1
            self._booting = True
            self._period = 0.0
            self._told = None
            self._expect_reset(command)
        if not state.serves_sdo:
            self._sdo.line.open = None
        self._sdo.silence.calms_down = state.serves_sdo
        self._take(state)
        self._sdo.device.contents.current.clear()
        self._sent_at = self._channel.link.now()
        self._channel.send_nmt(NmtMessage(command, self._device.node_id))

    def _take(self, state: NmtState) -> None:
        self.state = state
        self._device.learned.serving.enter(state)

    def enter(self, state: NmtState) -> None:
        """Bring the device into a state in which it serves, and see what it refuses there.

        That is tried on a few objects, once in a run; each keeps its value.
        """
        self.send(COMMANDS[state])
        self.settle()
        ServingTrial(self._sdo).try_once()

    @contextmanager
    def in_other_state(self) -> Iterator[None]:
        """Run steps in the state, of the two that serve, in which cases do not run otherwise.

        What is wrong there is told with that state.
        """
        home, state = self._device.learned.serving.home, NmtState.OPERATIONAL
        if home is NmtState.OPERATIONAL:
            state = NmtState.PRE_OPERATIONAL
        self.enter(state)
        try:
            yield
        except Violation as breach:
            breach.seen = breach.seen.remarking(f"; in {STATE_NAMES[state]}")
            raise

    def go_home(self) -> None:
        """Leave the device in the state in which it serves what the cases need."""
        home = self._device.learned.serving.home
        if home not in (None, self.state):
            self.send(COMMANDS[home])
            self.settle()

    def _require_kept(self, command: NmtCommand) -> None:
        """Raise NotTestable where a reset may change what could not be put back."""
        everything = command is NmtCommand.RESET_NODE
        lost = self._device.lost_in_reset(None if everything else COMMUNICATION_AREA)
        if lost:
            raise NotTestable(
                f"a reset may change {len(lost)} objects of very many that were not read when the "
                "run began: a run without --sdo-quick reads them",
                Missing(Lack.WHOLE_READING),
            )

    def _expect_reset(self, command: NmtCommand) -> None:
        """Count as written what a reset may change: it is put back after the case."""
        everything = command is NmtCommand.RESET_NODE
        muxes = [
            known.mux
            for known in self._device.resettable()
            if everything or known.mux.index in COMMUNICATION_AREA
        ]
        reset = self._device.contents.reset(command, muxes)
        self._sdo.record.written |= reset
        self._sdo.record.reset |= dict.fromkeys(reset, command)

    def expect_boot_up(self) -> None:
        """Expect the boot-up message that follows a reset; a wrong one is noted, if it is all."""
        self._booting = False
        odd: CanFrame | None = None
        deadline = self._channel.link.deadline(BOOT_TIME)
        while (frame := self._error_control_until(deadline)) is not None:
            if frame.data[0] == NmtState.INITIALISING:
                self._has_booted()
                return
            if frame.data[0] & TOGGLED == NmtState.PRE_OPERATIONAL:
                odd = frame
                if self._sdo.record.causes.boots_up_as_heartbeat:
                    break
        if odd is None:
            raise self._sdo.breach("a boot-up message", NoAnswer(f"none within {BOOT_TIME:g} s"))
        self._has_booted()
        expected = "a boot-up message: 00h"
        self._sdo.note(
            Violation(
                NMT_INITIALISING, expected=expected, actual=str(odd), told_as=BOOTED_AS_HEARTBEAT
            )
        )

    def _has_booted(self) -> None:
        """Take that the device is Pre-operational, unless it goes on by itself."""
        self._take(NmtState.PRE_OPERATIONAL)
        home = self._device.learned.serving.home
        if home is not None:
            self.send(COMMANDS[home])
            self.settle()

    def reset(self, command: NmtCommand) -> None:
        """Reset the device and see it boot."""
        self.send(command)
        self.expect_boot_up()

    def reset_to_stored(self) -> None:
        """Reset the node: it holds what it has stored, and nothing that cases have left.

        So it may be stored again, also by a device that forgets nothing in a reset.
        """
        self._device.permits.require(NMT)
        ValueAccess(self._sdo).write_all_own()
        self.reset(NmtCommand.RESET_NODE)

    def produce_heartbeats(self) -> Abort | None:
        """Let the device tell its state by a time in 1017h; return the abort if it refuses.

        One that has a time of its own, which cannot be written, tells its state nevertheless.
        """
        self._device.permits.require(NMT)
        refusal = self._parameters.learn_or_refusal(HEARTBEAT_TIME)
        if refusal is not None:
            return refusal
        for self._period in HEARTBEAT_PERIODS:
            data = round(self._period * 1000).to_bytes(2, "little")
            refusal = self._parameters.write(HEARTBEAT_TIME, data)
            if refusal is None or refusal.code not in TOO_SHORT:
                break
        if refusal is not None:
            own = int.from_bytes(self._device.contents.parameters[HEARTBEAT_TIME], "little") / 1000
            self._period = own if own <= LONGEST_PERIOD else 0.0
        return refusal

    def settle(self) -> None:
        """Wait until the device tells that it is in the state last asked for.

        The first heartbeat may have been on its way when the command was sent, and an SDO server
        may follow somewhat later: a device tells its state twice, and a slow one more often.
        """
        pace = self._channel.pace
        if self._period:
            self._expect_told(self._beats(pace.nearly_all))
        else:
            self._pause(pace.entering(self.state, SETTLING_TIME))

    def linger(self) -> None:
        """Stay in a state in which a request is not answered until it has been met for sure.

        That takes as long as an answer elsewhere.
        """
        if self._period:
            self._expect_told(self._beats(self._sdo.wire.waits.look))
        else:
            self._pause(self._sdo.wire.waits.soon)

    def _beats(self, seconds: float) -> int:
        """Return the number of heartbeats that take so long at least, whenever the first comes."""
        return 1 + max(ceil(seconds / self._period), 1)

    def _expect_told(self, times: int) -> None:
        """Expect so many heartbeats in a row with the state last asked for."""
        told = 0
        patience = max(self._channel.response_timeout, 2 * self._period)
        for _ in range(round(patience / self._period) + times):
            frame = self._channel.receive_error_control(patience)
            if frame is None:
                expected = "heartbeats, as 1017h says"
                raise self._sdo.breach(expected, "none", told_as=NO_HEARTBEATS)
            state = frame.data[0] & 0x7F
            beat = Said(f"{frame}", f"…#{state:02X}")
            told = told + 1 if state == self.state else 0
            if told and self._told not in (None, state):
                self._channel.pace.entered(self.state, self._channel.arrived - self._sent_at)
            self._told = state
            if told == times:
                return
        due = NmtState.INITIALISING if self.state is None else self.state
        raise self._sdo.breach(f"heartbeats with {due:02X}h", beat)

    def _error_control_until(self, deadline: Deadline) -> CanFrame | None:
        """Return the next boot-up or heartbeat message before an end, or None."""
        if deadline.has_passed:
            return None
        return self._channel.receive_error_control(deadline.left)

    def _pause(self, seconds: float) -> None:
        """Let a time pass; a heartbeat now and then does not end it."""
        deadline = self._channel.link.deadline(seconds)
        while not deadline.has_passed:
            if self._channel.receive_error_control(deadline.left) is None:
                return

    def end_heartbeats(self) -> None:
        """Write 0 to 1017h, and expect no heartbeat beyond those that had been queued before."""
        if self._device.learned.serving.may_refuse(Service.DOWNLOAD, HEARTBEAT_TIME):
            self.end()
        self._sdo.download(HEARTBEAT_TIME, bytes(2))
        # A device that takes its time to confirm that has told its state meanwhile.
        deadline = self._channel.link.deadline(self._channel.response_timeout)
        while not deadline.has_passed and self._channel.receive_error_control(0.0) is not None:
            pass
        for _ in range(MOST_QUEUED):
            if self._channel.receive_error_control(self._period / 2) is None:
                break
        if self._channel.receive_error_control(2 * self._period) is not None:
            raise self._sdo.breach("no heartbeat with 1017h = 0", "one came")
        self._period = 0.0

    def end(self) -> None:
        """Leave the device in a state in which it serves, whatever became of the case."""
        if self._booting:
            self._channel.receive_error_control(BOOT_TIME)
            self._booting = False
        home = self._device.learned.serving.home
        if self.state is not None and home is not None:
            self.go_home()
        elif self.state not in (None, NmtState.PRE_OPERATIONAL):
            self.send(NmtCommand.ENTER_PRE_OPERATIONAL)
