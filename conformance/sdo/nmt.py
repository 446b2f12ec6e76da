"""Network management as far as it decides on SDO: commands, states, boot-up and heartbeat.

A node is Initialising until it has sent its boot-up message, and Pre-operational from then on.
Each command leads to the same state from wherever it comes (CiA 301, 7.3.2).
"""

from dataclasses import dataclass
from enum import IntEnum

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import HIGHEST_NODE_ID

NMT_ID = 0x000
EMERGENCY_BASE = 0x080
EMERGENCY_LENGTH = 8
ERROR_CONTROL_BASE = 0x700
ALL_NODES = 0
COMMAND_LENGTH = 2
# The indices that a reset of the communication is about.
COMMUNICATION_AREA = range(0x1000, 0x2000)


class NmtState(IntEnum):
    """The states by their number in a heartbeat; 0 there is the boot-up message."""

    INITIALISING = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127

    @property
    def serves_sdo(self) -> bool:
        """Whether an SDO server answers in this state."""
        return self in _SERVING


_SERVING = frozenset({NmtState.PRE_OPERATIONAL, NmtState.OPERATIONAL})


class NmtCommand(IntEnum):
    """The command specifiers."""

    START = 1
    STOP = 2
    ENTER_PRE_OPERATIONAL = 128
    RESET_NODE = 129
    RESET_COMMUNICATION = 130


# Where a command leads; the resets by way of Initialising, with a boot-up message.
TRANSITIONS = {
    NmtCommand.START: NmtState.OPERATIONAL,
    NmtCommand.STOP: NmtState.STOPPED,
    NmtCommand.ENTER_PRE_OPERATIONAL: NmtState.PRE_OPERATIONAL,
    NmtCommand.RESET_NODE: NmtState.INITIALISING,
    NmtCommand.RESET_COMMUNICATION: NmtState.INITIALISING,
}
_KNOWN = frozenset(NmtCommand)


@dataclass(frozen=True, slots=True)
class NmtMessage:
    """A command to one node, or to all (node-ID 0)."""

    command: NmtCommand
    node_id: int

    def frame(self) -> CanFrame:
        """Return the frame that carries the command."""
        return CanFrame(NMT_ID, bytes((self.command, self.node_id)))


def decode_nmt(frame: CanFrame) -> NmtMessage | None:
    """Read a command; None for every other frame."""
    plain = frame.can_id == NMT_ID and not frame.extended and not frame.remote
    if not plain or frame.dlc != COMMAND_LENGTH or frame.data[0] not in _KNOWN:
        return None
    return NmtMessage(NmtCommand(frame.data[0]), frame.data[1])


def error_control(node_id: int, state: NmtState) -> CanFrame:
    """Return the heartbeat of a node in a state; that of Initialising is the boot-up message."""
    return CanFrame(ERROR_CONTROL_BASE + node_id, bytes((state,)))


def emergency(node_id: int, code: int, register: int) -> CanFrame:
    """Return an emergency message: error code (0: error reset) and error register (7.2.7.1)."""
    data = code.to_bytes(2, "little") + bytes((register,)) + bytes(5)
    return CanFrame(EMERGENCY_BASE + node_id, data)


def describe_nmt(frame: CanFrame) -> str:
    """Say in words what a frame means by which a network is managed; empty for every other one.

    These are NMT commands, boot-up messages, heartbeats and emergencies.

    >>> describe_nmt(emergency(5, 0x8110, 0x11))
    'emergency of node 5: error code 8110h, error register 11h'
    """
    message = decode_nmt(frame)
    if message is not None:
        what = message.command.name.lower().replace("_", " ")
        return f"NMT: {what}, {f'node {message.node_id}' if message.node_id else 'all nodes'}"
    node_id = frame.can_id & HIGHEST_NODE_ID
    if frame.extended or frame.remote or not node_id:
        return ""
    base = frame.can_id - node_id
    if base == ERROR_CONTROL_BASE and frame.dlc == 1:
        return _describe_error_control(node_id, frame.data[0])
    if base == EMERGENCY_BASE and frame.dlc == EMERGENCY_LENGTH:
        code, register = int.from_bytes(frame.data[:2], "little"), frame.data[2]
        what = f"error code {code:04X}h" if code else "no error any more"
        return f"emergency of node {node_id}: {what}, error register {register:02X}h"
    return ""


def _describe_error_control(node_id: int, state: int) -> str:
    if state not in frozenset(NmtState):
        return ""
    if state == NmtState.INITIALISING:
        return f"boot-up of node {node_id}"
    return f"heartbeat of node {node_id}: {NmtState(state).name.lower().replace('_', '-')}"
