"""One field of the matrix: lead the server into a state, send one frame, judge what follows."""

from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.objects import KnownObject
from conformance.run.dialogue import Dialogue
from conformance.run.lockstep import Lockstep, knowledge_of
from conformance.run.matrix.states import SIZE, STATES
from conformance.run.matrix.stimuli import Stimulus, Targets
from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import Violation


def perform(
    state: str, stimulus: Stimulus, sdo: Dialogue, device: Device, known: KnownObject
) -> None:
    """Judge the reaction to a stimulus, the value that ``known`` has then, and the next transfers.

    ``known`` is a writable string. The oracle follows from the first frame on. Raises Violation,
    NotTestable and Unimplemented.
    """
    missing = sdo.missing_object()
    try:
        missing_sub_index = sdo.missing_sub_index(DEVICE_TYPE.index)
    except Violation:
        # That this device serves any sub-index is for other cases to say.
        missing_sub_index = Multiplexer(missing.index, 1)
    targets = Targets(device.node_id, known.mux, missing, missing_sub_index)
    sdo.need_room(known, SIZE)
    knowledge = knowledge_of(device, {known.mux: device.room[known.mux]}, targets.there)
    oracle = Oracle(knowledge, device.node_id)
    lockstep = Lockstep(sdo, oracle)
    with lockstep.following():
        STATES[state](sdo, known)
        lockstep.check()
        lockstep.send(stimulus(targets))
        lockstep.settle(known.mux)
        sdo.upload(known)
        lockstep.check()
