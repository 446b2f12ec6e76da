"""Devices that store their parameters by themselves: a reset leads to what was written last."""

from collections.abc import Callable

from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import HEARTBEAT_TIME, Network
from conformance.dialogue.parameters import Parameters
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.rules import Violation
from conformance.sdo.rules.object_dictionary import STORES_BY_ITSELF
from conformance.sdo.seen import Data, Said, Seen
from conformance.sdo.storage_commands import COMMUNICATION_PART, SAVE_ALL

# Bit 1 of an entry of 1010h (7.5.2.13).
BY_ITSELF = 0b10
# A heartbeat time, in milliseconds, in which a reset is over.
LONG_TIME = (4000).to_bytes(2, "little")


def stores_by_itself(sdo: Dialogue) -> bool:
    """Say whether the device says in 1010h that it stores parameters of the communication so."""
    values = [
        sdo.read_if_there(Multiplexer(SAVE_ALL.index, sub_index))
        for sub_index in (SAVE_ALL.sub_index, COMMUNICATION_PART)
    ]
    return any(value and value[0] & BY_ITSELF for value in values)


def judge_kept(
    sdo: Dialogue, network: Network, is_kept: Callable[[], bool], due: str, found: Seen
) -> None:
    """Judge a parameter that a reset of the communication has left as it was written.

    ``due`` says what it should read, ``found`` is what it reads. It is right if the device
    stores it by itself; what is not said in 1010h shows by a reset of the node, which keeps the
    heartbeat time as well then.
    """
    if stores_by_itself(sdo):
        sdo.info(f"{found.words}: 1010h says that the device stores it by itself")
        return
    parameters = Parameters(sdo)
    can_write = parameters.learn(HEARTBEAT_TIME)
    was_written = can_write and parameters.write(HEARTBEAT_TIME, LONG_TIME) is None
    network.reset(NmtCommand.RESET_NODE)
    if not is_kept():
        raise sdo.breach(due, _adding(found, ", until the node is reset"))
    if was_written and sdo.upload(HEARTBEAT_TIME) != LONG_TIME:
        raise sdo.breach(
            due, _adding(found, ", and a reset of the node does not keep", f" {HEARTBEAT_TIME}")
        )
    actual = _adding(found, ", also after a reset of the node")
    sdo.note(Violation(STORES_BY_ITSELF, expected=due, actual=actual))


def _adding(found: Seen, words: str, about: str = "") -> Seen:
    """Return the same with more words, which belong to its kind, unless it is that of all data."""
    if isinstance(found, Data):
        return found.remarking(words + about)
    return Said(found.words + words + about, f"{found.kind}{words}")
