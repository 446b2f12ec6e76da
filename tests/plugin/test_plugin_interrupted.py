"""Ctrl-C in the middle of a case: what was written is put back, in workers as well."""

import os
import signal
import subprocess
import sys
import threading

import pytest
from plugin_runs import QUICK, hosted_on
from socketcand_bus import socketcand

from conformance.faults.dictionary import reference_device
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer
from conformance.sdo.node import Node
from conformance.sdo.server import Server

pytest_plugins = ["pytester"]

NODES = (5, 9)
WRITTEN = Multiplexer(0x2004)
NEW = b"new!"
# Only what hangs takes so many seconds, on any machine.
HANGS = 600.0
# A loaded machine may take its time: a device that seems lost is not written to any more.
PATIENT = "--response-timeout=60"
INTERRUPTED = """
    import threading
    import pytest
    from conformance.sdo.layout import Multiplexer

    @pytest.mark.parametrize("node_id", [5, 9])
    def test_written(sdo, node_id):
        sdo.download(Multiplexer(0x2004), b"new!")
        threading.Event().wait()
"""


class Watched(Node):
    """Tells when its object was written."""

    def __init__(self, node_id: int) -> None:
        self.objects = reference_device(node_id)
        self.written = threading.Event()
        super().__init__(node_id, Server(self.objects))

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        if self.value == NEW:
            self.written.set()
        return answers

    @property
    def value(self) -> bytes:
        return self.objects.find(WRITTEN).value


@pytest.mark.parametrize("workers", [(), ("-n", "2")], ids=["one-process", "workers"])
def test_what_was_written_is_put_back(pytester: pytest.Pytester, workers: tuple[str, ...]) -> None:
    pytester.makepyfile(test_mine=INTERRUPTED)
    nodes = [Watched(node_id) for node_id in NODES]
    before = nodes[0].value
    with socketcand() as bus, hosted_on(bus, *nodes):
        reports = "--report-dir=left behind"
        options = (*QUICK, PATIENT, reports, "--object=2004=unsigned32", *bus, *workers)
        process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-m", "pytest", "--node-id=5,9", *options, "test_mine.py"],
            cwd=pytester.path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        for node in nodes if workers else nodes[:1]:
            assert node.written.wait(HANGS)
        os.killpg(process.pid, signal.SIGINT)  # as the terminal does
        output, _ = process.communicate(timeout=HANGS)
        assert [node.value for node in nodes] == [before, before]
    assert process.returncode == pytest.ExitCode.INTERRUPTED, output.decode()
    assert list((pytester.path / "left behind").glob("*/bus*.log")), output.decode()
