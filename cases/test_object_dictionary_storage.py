"""What must not store the parameters of a device or load its defaults (CiA 301, 7.5.2.13, .14)."""

from conformance.device.protected_objects import NMT, STORE_PARAMETERS
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.storage import Storage, require_command
from conformance.run.case import must
from conformance.sdo.frames import DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules.object_dictionary import SIGNATURE
from conformance.sdo.storage_commands import LOAD_ALL, SAVE_ALL, SIGNATURES


def expect_nothing_else_taken(sdo: Dialogue, command: Multiplexer, other: Multiplexer) -> None:
    """Expect 1010h:01 or 1011h:01 to refuse all that is not its signature.

    What was stored before is stored still then.
    """
    stored, signature = sdo.device.keeping.stored, SIGNATURES[command]
    for wrong in (
        bytes(4),
        b"\xff\xff\xff\xff",
        signature[::-1],
        signature.upper(),
        SIGNATURES[other],
    ):
        sdo.send(DownloadInitiate.with_data(command, wrong))
        sdo.expect_abort(*SIGNATURE.codes, of=command, tolerated=SIGNATURE.tolerated)
    sdo.device.keeping.stored = stored


@must("od.save-signature", "storage.signature")
def test_save_signature(sdo: Dialogue, network: Network) -> None:
    """Only "save" stores the parameters: everything else that 1010h:01 gets is refused.

    The reset makes sure that nothing is stored but what is stored already.
    """
    sdo.device.permits.require(NMT)
    sdo.device.permits.require(STORE_PARAMETERS)
    require_command(sdo, SAVE_ALL)
    network.reset_to_stored()
    expect_nothing_else_taken(sdo, SAVE_ALL, other=LOAD_ALL)


@must("od.load-signature", "storage.signature", clause="7.5.2.14")
def test_load_signature(sdo: Dialogue, storage: Storage) -> None:
    """Only "load" loads the defaults: everything else that 1011h:01 gets is refused.

    What the defaults would replace is known before, and is stored again where they are loaded.
    """
    storage.prepare_loading()
    expect_nothing_else_taken(sdo, LOAD_ALL, other=SAVE_ALL)
    sdo.device.keeping.nothing_was_lost()
