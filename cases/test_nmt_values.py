"""What a reset of the communication changes of the values of a device, and what not (7.3.2.2.1)."""

from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.by_itself import judge_kept
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import HEARTBEAT_TIME, Network
from conformance.dialogue.parameters import Parameters
from conformance.run.case import must
from conformance.sdo.describe import shown
from conformance.sdo.nmt import COMMUNICATION_AREA, NmtCommand
from conformance.sdo.seen import Data

# Heartbeat times in milliseconds, in which a reset is over.
TIMES = (2000, 3000)


@must("nmt.reset-restores", "storage.by-itself")
def test_reset_restores(sdo: Dialogue, network: Network, parameters: Parameters) -> None:
    """A reset of the communication restores 1017h, which was written before.

    A device that stores it by itself keeps it, over a reset of the node as well.
    """
    network.reset(NmtCommand.RESET_COMMUNICATION)
    due = parameters.present(HEARTBEAT_TIME)
    times = [time.to_bytes(2, "little") for time in TIMES]
    new = next(time for time in times if time != due)
    parameters.write_if_configurable(HEARTBEAT_TIME, new)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    if (found := sdo.upload(HEARTBEAT_TIME)) == due:
        return
    expected = f"{HEARTBEAT_TIME} reads {shown(due)}, as before it was written"
    if found != new:
        raise sdo.breach(expected, Data(found))
    judge_kept(
        sdo,
        network,
        lambda: sdo.upload(HEARTBEAT_TIME) != due,
        expected,
        Data(found, HEARTBEAT_TIME),
    )


@must("nmt.reset-keeps-application")
def test_reset_keeps_application(sdo: Dialogue, network: Network, number: KnownObject) -> None:
    """A reset of the communication leaves a number from 2000h on as it was written."""
    if number.mux.index in COMMUNICATION_AREA or not number.is_steady:
        raise NotTestable("needs a writable number from 2000h on that changes by no other means")
    written = sdo.write_number(number)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    if (found := sdo.upload(number)) != written:
        raise sdo.breach(f"{number} reads {shown(written)} as before the reset", Data(found))
