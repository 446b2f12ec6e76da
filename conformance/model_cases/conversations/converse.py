"""Holds a conversation with a device in lockstep with the oracle, which judges each response."""

from conformance.bus.errors import WriteNotPermitted
from conformance.dialogue.dialogue import Dialogue
from conformance.model_cases.conversations.conversation import Conversation
from conformance.model_cases.conversations.device_objects import DeviceObjects
from conformance.model_cases.conversations.disturbed_client import (
    Action,
    Heard,
    Listen,
    Send,
    Settle,
    Then,
    conversing,
    drive,
)
from conformance.model_cases.lockstep import Lockstep
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.rules import NO_REBOOT, Violation

# One more request before an answer is a fair question to a server; many of them are a flood.
MOST_DOUBTFUL = 2


def converse(conversation: Conversation, objects: DeviceObjects, sdo: Dialogue) -> None:
    """Perform all transfers, then read back what they were about.

    Raises Violation for the first response that fails a device, or when it boots on the way.
    """
    boot_ups = sdo.channel.boot_ups
    oracle = Oracle(objects.knowledge(), sdo.device.node_id)
    objects.values.clear()  # until this conversation has ended well
    lockstep = Lockstep(sdo, oracle)
    driver = _Driver(lockstep)
    with lockstep.following():
        drive(conversing(conversation, objects), driver.do)
    if sdo.channel.boot_ups > boot_ups:
        raise Violation(NO_REBOOT, expected="no boot-up message", actual="the device booted")
    objects.remember(oracle.values)


class _Driver:
    """Does what a conversation asks for, on a bus."""

    def __init__(self, lockstep: Lockstep) -> None:
        self._lockstep = lockstep
        self._doubtful = 0

    def do(self, action: Action) -> Heard:
        """Do one action; raises Violation for what fails a device."""
        match action:
            case Send():
                return self._send(action)
            case Listen():
                return Heard(self._lockstep.behind_gap())
            case Settle():
                # What was on its way may be answered yet: nothing is, where that is certain.
                if not (action.aborted and self._lockstep.oracle.idle):
                    self._lockstep.settle(action.target)
        return Heard()

    def _send(self, action: Send) -> Heard:
        if action.in_sub_block and self._lockstep.has_left():
            return Heard(self._lockstep.arrived(), Then.LEFT)
        if not self._lockstep.may_ask(action.frame):
            return Heard()
        try:
            answers = self._lockstep.send(action.frame)
        except WriteNotPermitted:
            return Heard()  # it was meant as a segment, and would be a request here
        return Heard(answers, Then.ENOUGH if self._floods(odd=action.odd) else Then.GO_ON)

    def _floods(self, *, odd: bool) -> bool:
        """Say whether too many frames went out while an answer may come and need not.

        A sub-block of which segments get lost is sent as it is: only its end has to be answered.
        """
        oracle = self._lockstep.oracle
        lossy = not odd and oracle.states == {SubBlock.name}
        clear = oracle.awaited is not Awaited.MAYBE or lossy
        self._doubtful = 0 if clear else self._doubtful + 1
        return self._doubtful > MOST_DOUBTFUL
