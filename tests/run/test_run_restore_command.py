"""What puts back the values of an earlier run leaves a server idle, however it ends."""

import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.run_bench import HASTY, NODE_ID, TEXT, Recording, recording, undiscovered

from conformance.bus.errors import OtherDevice
from conformance.device.change_journal import LeftBehind
from conformance.run.restore_command import put_back
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, DownloadSegment, Response
from conformance.sdo.layout import Multiplexer

LONG = bytes(range(0x20, 0x50))
ABORT_OF_TEXT = Abort(TEXT.mux, AbortCode.GENERAL_ERROR).encode()


class Deaf(Recording):
    """Does not answer the second segment of a download."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        return [] if request.toggle else super().on_download_segment(request)


class Interrupting(Deaf):
    """Is the user who presses Ctrl-C then."""

    def on_download_segment(self, request: DownloadSegment) -> list[Response]:
        if request.toggle:
            main = threading.main_thread().ident
            assert main is not None
            signal.pthread_kill(main, signal.SIGINT)
        return super().on_download_segment(request)


def left(**identity: str) -> LeftBehind:
    return LeftBehind(Path("journal"), NODE_ID, "", identity, {TEXT.mux: LONG})


def test_what_is_not_taken_stays_listed() -> None:
    server = recording(Deaf)
    with undiscovered(server, timeout=HASTY) as bench:
        back, pending = put_back(bench.channel, left())
        bench.dialogue().fence()
        assert server.transfer is None
    assert not back
    assert set(pending) == {str(TEXT.mux)}


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Let SIGINT interrupt, also where a shell has started the tests in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("ctrl_c")
def test_no_transfer_stays_open() -> None:
    server = recording(Interrupting)
    with undiscovered(server) as bench:
        with pytest.raises(KeyboardInterrupt):
            put_back(bench.channel, left())
        bench.dialogue().fence()
        assert ABORT_OF_TEXT in server.requests


@pytest.mark.parametrize("there", [True, False])
def test_another_device_is_not_written_to(*, there: bool) -> None:
    server = recording()
    if not there:
        server.objects.remove(0x1018)
    with (
        undiscovered(server) as bench,
        pytest.raises(OtherDevice, match="is not the device" if there else "cannot be read now"),
    ):
        put_back(bench.channel, left(**{"vendor-id": "0x00000001"}))
    assert server.writes == []
    assert Multiplexer(0x1018, 1) in server.entries
