"""A client goes away in the middle of a transfer: the next one is served (CiA 301, 7.2.4.2)."""

from conformance.device.device import VENDOR_ID
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.object_expectations import value_of
from conformance.model_cases.open_transfer import begin
from conformance.model_cases.server_states import SILENT, State
from conformance.run.case import must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import in_words, shown
from conformance.sdo.frames import Abort, Request
from conformance.sdo.seen import Data


@must(
    "vanished-client.next-transfer",
    "server.idle-afterwards",
    "server.new-initiate-served",
    risk=lambda state: state.risk,
    state=SILENT,
)
def test_next_transfer(sdo: Dialogue, state: State[Request]) -> None:
    """What a client left running does not keep the server from the next transfer.

    That is served at once or with the second request; while segments of a block are due, an
    abort has to come before it.
    """
    transfer = begin(sdo, state)
    if state.segment is not None:
        sdo.send(Abort(transfer.known.mux, AbortCode.TIMED_OUT))
    with sdo.one_transfer():
        found = sdo.attempt(sdo.client.upload(VENDOR_ID.mux))
        if isinstance(found, Abort):
            sdo.info(f"the first request is refused: {in_words(found)}")
            if found.mux == transfer.known.mux:
                sdo.fence()  # it has crossed with the abort: the request has its own answer
        due, value = value_of(sdo.device, VENDOR_ID), sdo.upload(VENDOR_ID)
        if value != due:
            raise sdo.breach(f"{VENDOR_ID} reads {shown(due)}", Data(value))
    if transfer.value is not None:
        sdo.expect_kept(transfer.known, transfer.value)
    begin(sdo, state)
