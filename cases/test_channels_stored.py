"""All SDO parameter records, 1200h to 12FFh, over resets and storing (CiA 301, 7.5.2.33, .34)."""

from collections.abc import Iterable

from conformance.device.device import Device
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.protected_objects import NMT, STORE_PARAMETERS
from conformance.dialogue.channels import (
    CLIENT,
    DEFAULT_RECORD,
    FIRST_CLIENT,
    LAST_CLIENT,
    LAST_RECORD,
    NOT_THERE,
    REQUEST,
    RESPONSE,
    Channels,
)
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.storage import require_command, write_signature
from conformance.run.case import must
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import in_words
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.seen import Received, Said, said
from conformance.sdo.storage_commands import SAVE_ALL

SERVER_RECORDS = range(DEFAULT_RECORD + 1, LAST_RECORD + 1)
CLIENT_RECORDS = range(FIRST_CLIENT, LAST_CLIENT + 1)

Records = dict[int, tuple[bytes, bytes]]


def records(sdo: Dialogue, indices: Iterable[int]) -> Records:
    """Read both COB-IDs of each record; what is not there has to be refused as missing."""
    found: Records = {}
    for index in indices:
        try:
            request = sdo.read(Multiplexer(index, REQUEST))
        except ServerAborted as aborted:
            if aborted.abort.code not in NOT_THERE:
                raise sdo.breach(
                    f"{index:04X}h:01 to be served, or 06020000h",
                    Received(aborted.abort),
                ) from aborted
            continue
        found[index] = (request, sdo.upload(Multiplexer(index, RESPONSE)))
    return found


def near(indices: range, due: Iterable[int]) -> list[int]:
    """Return where records are, and where one is most likely to come up that was missing.

    That is next to those that are there, and at both ends. To read all of them again would cost as
    many requests as a hundred cases.
    """
    around = {beside for index in due for beside in (index - 1, index, index + 1)}
    return sorted({*around, indices[0], indices[-1]} & set(indices))


def expect_there(sdo: Dialogue, indices: range, due: Iterable[int]) -> Records:
    """Expect the same records to be there as before, and none beside them; return them."""
    found = records(sdo, near(indices, due))
    changed = sorted(set(found) ^ set(due))
    if changed:
        before, now = (
            ("missing", "it is there") if changed[0] in found else ("there", "it is missing")
        )
        raise sdo.breach(f"{changed[0]:04X}h {before}, as before the reset", now)
    return found


def expect_same(sdo: Dialogue, indices: range, due: Records) -> None:
    """Expect the records to read as before, all of them."""
    found = expect_there(sdo, indices, due)
    for index, cob_ids in due.items():
        if found[index] != cob_ids:
            before, now = (
                " and ".join(f"{value[::-1].hex().upper()}h" for value in pair)
                for pair in (cob_ids, found[index])
            )
            raise sdo.breach(
                f"{index:04X}h:01 and :02 read {before}, as before", Said(now, "… and …")
            )


@must("channel.records", "channel.missing")
def test_records(sdo: Dialogue) -> None:
    """Each record of 1201h to 127Fh is there with both COB-IDs, or refused as a missing object."""
    records(sdo, SERVER_RECORDS)


@must("channel.records-after-reset", "channel.after-reset", "channel.missing")
def test_records_after_reset(sdo: Dialogue, network: Network) -> None:
    """Each record of 1201h to 127Fh is there after a reset as before it, or missing as before.

    Its COB-IDs are those of power-on then: the next reset of the communication leads to the same.
    """
    sdo.device.permits.require(NMT)
    before = records(sdo, SERVER_RECORDS)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    power_on = expect_there(sdo, SERVER_RECORDS, before)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    expect_same(sdo, SERVER_RECORDS, power_on)


@must("channel.clients-after-store", "storage.save", "channel.client-parameter")
def test_clients_after_store(sdo: Dialogue, network: Network) -> None:
    """What there is of 1280h to 12FFh reads after storing and a reset as before, or is missing.

    The first reset makes sure that nothing is stored but what is stored already.
    """
    sdo.device.permits.require(NMT)
    sdo.device.permits.require(STORE_PARAMETERS)
    require_command(sdo, SAVE_ALL)
    network.reset_to_stored()
    before = records(sdo, CLIENT_RECORDS)
    write_signature(sdo, SAVE_ALL)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    expect_same(sdo, CLIENT_RECORDS, before)


@must("channel.client-stored", "storage.save", "channel.client-parameter")
def test_client_stored(
    sdo: Dialogue, network: Network, parameters: Parameters, channels: Channels, device: Device
) -> None:
    """A node-ID in sub-index 03h of a client's record that was stored is there after a reset."""
    sdo.device.permits.require(NMT)
    sdo.device.permits.require(STORE_PARAMETERS)
    channels.require_parameters()
    require_command(sdo, SAVE_ALL)
    network.reset_to_stored()
    there = next((index for index in CLIENT_RECORDS if records(sdo, [index])), None)
    if there is None:
        raise Unimplemented(channels.refusal(Multiplexer(FIRST_CLIENT, REQUEST)))
    mux = Multiplexer(there, CLIENT)
    if not device.may_put_back(mux):
        raise NotTestable(f"{mux} may not be written: device.toml says so")
    before = sdo.upload(mux)[:1]
    new = bytes((before[0] % 127 + 1,))
    refused = parameters.write(mux, new)
    if refused is not None:
        raise NotTestable(f"{mux} does not take {new[0]}: {in_words(refused)}")
    device.contents.will_lose({mux: before})
    write_signature(sdo, SAVE_ALL)
    network.reset(NmtCommand.RESET_COMMUNICATION)
    found = sdo.upload(mux)[:1]
    if found != new:
        raise sdo.breach(f"{mux} reads {new.hex()}, as it was stored", said("{}", found.hex()))
