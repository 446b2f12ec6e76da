"""A transfer that begins in the middle of another: what may come before its first answer."""

import pytest
from support.run_bench import NODE_ID, TEXT, discovered

from conformance.dialogue.exchange import InitiateRefused
from conformance.faults.catalogue import build_node
from conformance.model_cases.server_states import BLOCK_DOWNLOAD_END
from conformance.sdo.checks import ServerAborted
from conformance.sdo.frames import UploadInitiate, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer

VENDOR_ID = Multiplexer(0x1018, 1)
MISSING = Multiplexer(0x5FFF)


@pytest.mark.parametrize("name", [None, "superseded-transfer-aborted"])
def test_it_is_served_at_once_or_behind_an_abort_of_the_other(name: str | None) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        sdo = bench.dialogue()
        sdo.initiate_download(TEXT, 20)
        with sdo.superseding():
            sdo.send(UploadInitiate(VENDOR_ID))
            answer = sdo.receive()
        assert isinstance(answer, UploadInitiateResponse)
        assert answer.mux == VENDOR_ID
        assert sdo.fence() == []


@pytest.mark.parametrize("name", ["new-initiate-refused", "new-initiate-at-block-end-refused"])
def test_it_is_refused(name: str) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        sdo = bench.dialogue()
        if name == "new-initiate-refused":
            sdo.initiate_download(TEXT, 20)
        else:
            BLOCK_DOWNLOAD_END.reach(sdo, TEXT, 20)
        with pytest.raises(InitiateRefused) as refused, sdo.superseding():
            sdo.upload(VENDOR_ID)
        assert refused.value.abort.mux in (TEXT.mux, VENDOR_ID)
        assert sdo.upload(VENDOR_ID)


def test_only_the_first_answer_may_be_an_abort_of_the_other() -> None:
    with discovered(build_node(None, NODE_ID)) as bench:
        sdo = bench.dialogue()
        sdo.initiate_download(TEXT, 20)
        with sdo.superseding():
            sdo.upload(VENDOR_ID)
            with pytest.raises(ServerAborted):
                sdo.read(MISSING)


def test_to_an_idle_server_it_is_a_transfer_as_any() -> None:
    with discovered(build_node(None, NODE_ID)) as bench:
        sdo = bench.dialogue()
        with pytest.raises(ServerAborted), sdo.superseding():
            sdo.read(MISSING)
