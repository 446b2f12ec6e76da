"""What must not store the parameters of a device or load its defaults (CiA 301, 7.5.2.13, .14)."""

from collections.abc import Iterator
from contextlib import contextmanager

from conformance.device.not_testable import Unimplemented
from conformance.device.object_roles import Roles
from conformance.device.protected_objects import NMT, STORE_PARAMETERS
from conformance.dialogue.changing import changes_by_itself
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.storage import Storage, require_command
from conformance.run.case import must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import shown
from conformance.sdo.frames import DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.rules.idle import READ_ONLY
from conformance.sdo.rules.object_dictionary import SIGNATURE
from conformance.sdo.seen import Data
from conformance.sdo.storage_commands import LAST_PART, LOAD_ALL, SAVE_ALL, signature_of

Codes = tuple[AbortCode, ...]


def expect_nothing_else_taken(
    sdo: Dialogue, command: Multiplexer, other: Multiplexer, codes: Codes = SIGNATURE.codes
) -> None:
    """Expect an entry of 1010h or 1011h to refuse all that is not its signature.

    What was stored before is stored still then.
    """
    stored, signature = sdo.device.contents.stored, signature_of(command)
    for wrong in (
        bytes(4),
        b"\xff\xff\xff\xff",
        signature[::-1],
        signature.upper(),
        signature_of(other),
    ):
        sdo.send(DownloadInitiate.with_data(command, wrong))
        sdo.expect_abort(*codes, of=command, tolerated=SIGNATURE.tolerated)
    sdo.device.contents.stored = stored


def parts_of(sdo: Dialogue, command: Multiplexer) -> list[tuple[Multiplexer, Codes]]:
    """Return the entries for parts of the parameters, each with the codes that refuse a signature.

    An entry that says that it follows no command may be read-only. Raises Unimplemented where there
    are none.
    """
    found: list[tuple[Multiplexer, Codes]] = []
    highest = sdo.upload(Multiplexer(command.index))
    for sub_index in range(2, min(*highest, LAST_PART) + 1 if highest else 0):
        mux = Multiplexer(command.index, sub_index)
        value = sdo.read_if_there(mux)
        if value is not None:
            follows = value[:1] and value[0] & 1
            found.append((mux, SIGNATURE.codes if follows else SIGNATURE.codes + READ_ONLY.codes))
    if not found:
        raise Unimplemented(f"{command.index:04X}h has no entry for a part of the parameters")
    return found


@contextmanager
def nothing_stored(sdo: Dialogue, network: Network) -> Iterator[None]:
    """Expect a number that was written to be back behind a reset, whatever was refused meanwhile.

    Not where a device stores it by itself, or has none. What was stored is stored again if need be.
    """
    device, contents, stored = sdo.device, sdo.device.contents, sdo.device.contents.stored
    resettable = {known.mux for known in device.resettable()}
    numbers = Roles(device).all_writable(lambda known: known.length is not None)
    known = next((one for one in numbers if one.mux in resettable), None)
    if known is None:
        yield
        return
    before = sdo.upload(known)
    sdo.write_number(known)
    network.reset(NmtCommand.RESET_NODE)
    if sdo.upload(known) != before:
        yield
        return
    contents.will_lose({known.mux: before})
    sdo.write_number(known)
    yield
    network.reset(NmtCommand.RESET_NODE)
    found = sdo.upload(known)
    if found != before:
        raise sdo.breach(f"{known} reads {shown(before)} behind a reset, as stored", Data(found))
    contents.nothing_was_lost()
    contents.stored = stored


@must("od.save-signature", "storage.signature")
def test_save_signature(sdo: Dialogue, network: Network) -> None:
    """Only "save" stores the parameters: everything else that 1010h:01 gets is refused.

    A number holds another value than is stored meanwhile; a reset brings that back. The reset at
    first makes sure that nothing else could be stored but what is stored already.
    """
    sdo.device.permits.require(NMT)
    sdo.device.permits.require(STORE_PARAMETERS)
    require_command(sdo, SAVE_ALL)
    network.reset_to_stored()
    with nothing_stored(sdo, network):
        expect_nothing_else_taken(sdo, SAVE_ALL, other=LOAD_ALL)


@must("od.load-signature", "storage.signature", clause="7.5.2.14")
def test_load_signature(sdo: Dialogue, network: Network, storage: Storage) -> None:
    """Only "load" loads the defaults: everything else that 1011h:01 gets is refused.

    What the defaults would replace is known before, and is stored again where they are loaded. If
    there is any, it is there still behind a reset.
    """
    storage.prepare_loading()
    expect_nothing_else_taken(sdo, LOAD_ALL, other=SAVE_ALL)
    stored = sdo.device.contents.to_store
    if stored:
        network.reset(NmtCommand.RESET_NODE)
    for mux, value in stored.items():
        if (found := sdo.upload(mux)) != value and not changes_by_itself(sdo, mux):
            raise sdo.breach(f"{mux} reads {shown(value)} behind a reset, as stored", Data(found))
    sdo.device.contents.nothing_was_lost()


@must("od.save-signature-of-part", "storage.signature")
def test_save_signature_of_part(sdo: Dialogue, parameters: Parameters, network: Network) -> None:
    """Only "save" stores a part of the parameters: 1010h:02 and further ones refuse all else.

    The reset makes sure that nothing is stored but what is stored already.
    """
    sdo.device.permits.require(NMT)
    sdo.device.permits.require(STORE_PARAMETERS)
    parameters.present(Multiplexer(SAVE_ALL.index))
    parts = parts_of(sdo, SAVE_ALL)
    network.reset_to_stored()
    for part, codes in parts:
        expect_nothing_else_taken(sdo, part, other=LOAD_ALL, codes=codes)


@must("od.load-signature-of-part", "storage.signature", clause="7.5.2.14")
def test_load_signature_of_part(sdo: Dialogue, parameters: Parameters, storage: Storage) -> None:
    """Only "load" loads a part of the defaults: 1011h:02 and further ones refuse all else."""
    parameters.present(Multiplexer(LOAD_ALL.index))
    parts = parts_of(sdo, LOAD_ALL)
    storage.prepare_loading()
    for part, codes in parts:
        expect_nothing_else_taken(sdo, part, other=SAVE_ALL, codes=codes)
    sdo.device.contents.nothing_was_lost()
