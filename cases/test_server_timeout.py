"""The server's own time-out, where the device declares one (CiA 301, 7.2.4.2): optional, but exact.

These cases wait, and no others do.
"""

from collections.abc import Callable, Generator

from conformance.device.object_roles import Roles
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import PROMPT, Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.model_cases.open_transfer import begin
from conformance.model_cases.server_states import (
    BLOCK_DOWNLOAD_INSIDE,
    BLOCK_UPLOAD_BETWEEN,
    SEGMENTED_DOWNLOAD_MIDDLE,
    SILENT,
    State,
    by_name,
)
from conformance.run.case import must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import Burst, Step
from conformance.sdo.frames import Abort, Request, Response
from conformance.sdo.seen import said
from conformance.sdo.stepping import Ended, advance

SERVICE = "7.2.4.2"
SIZE = 26
WAITING: dict[str, State[Request]] = by_name(
    SEGMENTED_DOWNLOAD_MIDDLE, BLOCK_DOWNLOAD_INSIDE, BLOCK_UPLOAD_BETWEEN
)
Transfer = Generator[Step, Response, object]


@must(
    "server-timeout.gives-up",
    "time-out.server",
    "segmented-download.client-silent",
    "segmented-upload.client-silent",
    "block-download.silent-in-sub-block",
    "block-download.silent-before-sub-block",
    "block-download.silent-before-end",
    "block-upload.client-silent",
    "block-upload.silent-at-end",
    clause=SERVICE,
    slow=True,
    state=SILENT,
)
def test_gives_up(sdo: Dialogue, server_timeout: float, state: State[Request]) -> None:
    """The server aborts the transfer of a silent client with 05040000h and stores nothing."""
    transfer = begin(sdo, state)
    sdo.expect_timed_out(transfer.known, server_timeout)
    sdo.expect_dead(transfer.due)
    if transfer.value is not None:
        sdo.expect_kept(transfer.known, transfer.value)


@must(
    "server-timeout.once",
    "time-out.server",
    "server.nothing-afterwards",
    clause=SERVICE,
    slow=True,
    state=WAITING,
)
def test_once(sdo: Dialogue, server_timeout: float, state: State[Request]) -> None:
    """A server that has given up says so once, and does not answer the client's own abort."""
    transfer = begin(sdo, state)
    sdo.expect_timed_out(transfer.known, server_timeout)
    further = sdo.wait(server_timeout * (1 + PROMPT))
    if further is not None:
        raise sdo.breach("no further frame", said("{}", further.encode().hex(" ")))
    sdo.send(Abort(transfer.known.mux, AbortCode.TIMED_OUT))
    sdo.expect_nothing()


@must(
    "server-timeout.after-abort",
    "server.nothing-afterwards",
    "time-out.client",
    clause=SERVICE,
    slow=True,
    state=WAITING,
)
def test_after_abort(sdo: Dialogue, server_timeout: float, state: State[Request]) -> None:
    """A transfer that the client has aborted does not time out behind that."""
    transfer = begin(sdo, state)
    sdo.send(Abort(transfer.known.mux, AbortCode.TIMED_OUT))
    late = sdo.wait(server_timeout * (1 + PROMPT))
    if late is not None:
        raise sdo.breach(
            "no frame behind the abort of the client", said("{}", late.encode().hex(" "))
        )
    sdo.expect_nothing()


def _segmented_download(sdo: Dialogue) -> Transfer:
    text = Roles(sdo.device).text()
    data = Room(sdo).prepare(text, SIZE, least=8)
    return sdo.client.download(text.mux, data)


def _segmented_upload(sdo: Dialogue) -> Transfer:
    known, _ = Room(sdo).long_object(segments=4)
    return sdo.client.upload(known.mux)


def _block_download(sdo: Dialogue) -> Transfer:
    text = Roles(sdo.device).text()
    data = Room(sdo).prepare(text, SIZE)
    Blocks(sdo).initiate_download(text, len(data))
    sdo.end_transfer()
    return sdo.client.block_download(text.mux, data)


def _block_upload(sdo: Dialogue) -> Transfer:
    known, _ = Room(sdo).long_object(segments=4)
    Blocks(sdo).initiate_upload(known)
    sdo.end_transfer()
    return sdo.client.block_upload(known.mux, block_size=1)


SLOW = {
    "segmented-download": _segmented_download,
    "segmented-upload": _segmented_upload,
    "block-download": _block_download,
    "block-upload": _block_upload,
}


@must("server-timeout.slow-client", "time-out.server", clause=SERVICE, slow=True, begin=SLOW)
def test_slow_client(
    sdo: Dialogue, server_timeout: float, begin: Callable[[Dialogue], Transfer]
) -> None:
    """The time counts from the last frame: a transfer that takes longer in all is served."""
    transfer = begin(sdo)
    step = advance(transfer)
    while not isinstance(step, Ended):
        burst = step if isinstance(step, Burst) else Burst((step,))
        for request in burst.requests:
            if not sdo.expect_patience(server_timeout * PROMPT):
                sdo.info("a sub-block that does not go on is acknowledged")
                return
            sdo.send(request)
        step = advance(transfer, sdo.receive() if burst.awaited else None)
