"""In which NMT state a device serves what the cases need, where it refuses that by its state."""

from collections.abc import Callable

from conformance.device.effort import OBJECTS_PER_STATE
from conformance.device.known_objects import KnownObject
from conformance.device.protected_objects import NMT
from conformance.device.serving import BY_STATE, Service
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import COMMANDS, Network
from conformance.dialogue.serving_trial import ServingTrial
from conformance.sdo.frames import BlockDownloadInitiate, DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation


def learn_refusal(sdo: Dialogue, mux: Multiplexer) -> None:
    """Take note that the upload of an object was refused by the state of the device, if it was."""
    refusal = sdo.wire.refusal
    if refusal is not None and refusal.mux == mux and refusal.code in BY_STATE:
        sdo.device.learned.serving.learn(Service.UPLOAD, mux, refusal.code)


def was_download_refused(sdo: Dialogue) -> bool:
    """Say whether the last download was refused by the state of the device."""
    asked = isinstance(sdo.wire.last_sent, DownloadInitiate | BlockDownloadInitiate)
    return asked and sdo.wire.refusal is not None and sdo.wire.refusal.code in BY_STATE


def look_where_it_reads(sdo: Dialogue, learn: Callable[[KnownObject], bool]) -> None:
    """Read again what was refused, in the state in which more of it is served; ``learn`` reads."""
    serving = sdo.device.learned.serving
    refused = serving.refused_here(Service.UPLOAD)
    listed = [known for known in sdo.device.objects if known.mux in refused]
    if not listed:
        return
    if NMT in sdo.device.permissions:
        sample = [known.mux for known in listed[:: max(len(listed) // OBJECTS_PER_STATE, 1)]]
        _choose(sdo, lambda: ServingTrial(sdo).uploads(sample))
    for known in listed:
        learn(known)


def look_where_it_writes(sdo: Dialogue) -> None:
    """See which downloads the device refuses by its state, and where it serves more of them."""
    trial = ServingTrial(sdo)
    trial.downloads()
    serving = sdo.device.learned.serving
    if NMT in sdo.device.permissions and serving.refused_here(Service.DOWNLOAD):
        _choose(sdo, trial.downloads)


def _choose(sdo: Dialogue, attempt: Callable[[], None]) -> None:
    """Make an attempt in both states; stay where more is served."""
    network, serving = Network(sdo), sdo.device.learned.serving
    for state in COMMANDS:
        try:
            network.send(COMMANDS[state])
            network.settle()
            attempt()
        except Violation:
            sdo.silence.recover()  # what is wrong there is for the cases to find
    serving.home = max(COMMANDS, key=serving.served_in)
    network.go_home()
