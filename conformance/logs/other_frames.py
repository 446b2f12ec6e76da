"""The frames of CANopen that are neither SDO nor NMT, by their default identifiers."""

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import HIGHEST_NODE_ID

SYNC, TIME = 0x080, 0x100
LSS = {0x7E5: "LSS request", 0x7E4: "LSS response"}
FIRST_PDO, LAST_PDO = 0x180, 0x57F
ERROR_CONTROL = 0x700


def describe_other(frame: CanFrame) -> str:
    """Say what a frame is by its identifier, if no device has configured another; or empty.

    >>> describe_other(CanFrame(0x285, bytes(8)))
    'TPDO 2 of node 5'
    """
    if frame.extended:
        return ""
    can_id, node_id = frame.can_id, frame.can_id & HIGHEST_NODE_ID
    if can_id == SYNC:
        return f"SYNC, counter {frame.data[0]}" if frame.data else "SYNC"
    if can_id == TIME:
        return "TIME"
    if can_id in LSS:
        return LSS[can_id]
    if not node_id:
        return ""
    if FIRST_PDO <= can_id <= LAST_PDO:
        # Transmit and receive PDOs take turns, from those of number 1 on.
        number, received = divmod((can_id - FIRST_PDO) >> 7, 2)
        asked = "request for " if frame.remote else ""
        return f"{asked}{'RPDO' if received else 'TPDO'} {number + 1} of node {node_id}"
    if can_id == ERROR_CONTROL + node_id and frame.remote:
        return f"node guarding request to node {node_id}"
    return ""
