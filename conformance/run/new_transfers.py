"""A new transfer of each kind where another one is not over: it is served whole, or refused."""

from collections.abc import Callable, Generator

from conformance.device.device import VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.object_expectations import value_of
from conformance.dialogue.transfers import Target, mux_of
from conformance.dialogue.values import same_value
from conformance.sdo.block_client import Step
from conformance.sdo.client import Uploaded
from conformance.sdo.describe import shown
from conformance.sdo.frames import Abort, Response
from conformance.sdo.seen import Data, Received

# How many bytes a download writes to a string that takes them; cases find that out before.
INITIATE_SIZE = 9
Initiate = Callable[[Dialogue, KnownObject], Abort | None]


def _upload(sdo: Dialogue, old: KnownObject) -> Abort | None:
    return _read(sdo, old, VENDOR_ID, sdo.client.upload(VENDOR_ID.mux))


def _block_upload(sdo: Dialogue, old: KnownObject) -> Abort | None:
    return _read(sdo, old, VENDOR_ID, sdo.client.block_upload(VENDOR_ID.mux))


def _download(sdo: Dialogue, old: KnownObject) -> Abort | None:
    number = Roles(sdo.device).number()
    value = sdo.device.values[number.mux]
    return _write(sdo, old, number, value, sdo.client.download(number.mux, value))


def _segmented_download(sdo: Dialogue, old: KnownObject) -> Abort | None:
    text = Roles(sdo.device).text()
    data = _fitting(sdo, text)
    return _write(sdo, old, text, data, sdo.client.download(text.mux, data, segmented=True))


def _block_download(sdo: Dialogue, old: KnownObject) -> Abort | None:
    text = Roles(sdo.device).text()
    data = _fitting(sdo, text)
    return _write(sdo, old, text, data, sdo.client.block_download(text.mux, data))


def _fitting(sdo: Dialogue, text: KnownObject) -> bytes:
    """Return what a string takes as far as that is known: a transfer runs, and it is not asked."""
    return sdo.payload(sdo.device.learned.lengths[text.mux].fit(INITIATE_SIZE) or INITIATE_SIZE)


def _read(
    sdo: Dialogue,
    old: KnownObject,
    known: KnownObject,
    transfer: Generator[Step, Response, Uploaded],
) -> Abort | None:
    found = sdo.attempt(transfer)
    if isinstance(found, Abort):
        return _refused(sdo, found, old, known)
    due = value_of(sdo.device, known)
    if not same_value(known, found.data[: known.length], due):
        raise sdo.breach(f"{known} reads {shown(due)}", Data(found.data, known))
    return None


def _write(
    sdo: Dialogue,
    old: KnownObject,
    known: KnownObject,
    data: bytes,
    transfer: Generator[Step, Response, object],
) -> Abort | None:
    refused = sdo.attempt(transfer)
    if isinstance(refused, Abort):
        return _refused(sdo, refused, old, known)
    sdo.expect_value(known, data)
    return None


def _refused(sdo: Dialogue, abort: Abort, old: Target, new: Target) -> Abort:
    if abort.mux not in (mux_of(old), mux_of(new)):
        raise sdo.breach(f"an abort of {mux_of(old)} or {mux_of(new)}", Received(abort))
    return abort


# Each returns the abort with which the server refuses, None where it serves the new transfer.
INITIATES: dict[str, Initiate] = {
    "upload": _upload,
    "download": _download,
    "segmented-download": _segmented_download,
    "block-upload": _block_upload,
    "block-download": _block_download,
}
