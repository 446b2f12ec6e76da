"""A signal in the middle of a case: what was written is put back, in workers as well."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable

import pytest
from plugin_runs import QUICK, hosted_on, self_test, the_report
from socketcand_bus import socketcand

from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.reporting.recorded import read_run
from conformance.run.verdict import Verdict
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.layout import Multiplexer

pytest_plugins = ["pytester"]

NODES = (5, 9)
WRITTEN = Multiplexer(0x2004)
NEW = b"new!"
# Only a program that hangs takes this time, in seconds, on any machine.
HANGS = 600.0
# A loaded machine may take its time: a device that seems lost is not written to any more.
PATIENT = "--sdo-response-timeout=60"
INTERRUPTED = """
    import threading
    import pytest
    from conformance.sdo.layout import Multiplexer

    @pytest.mark.parametrize("node_id", [5, 9])
    def test_written(sdo, node_id):
        sdo.download(Multiplexer(0x2004), b"new!")
        while not threading.Event().wait(1):
            pass  # a signal that comes just before Python begins to wait is seen behind that
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


def to_all(process: subprocess.Popen[bytes]) -> None:
    """Send what a terminal does at Ctrl-C."""
    os.killpg(process.pid, signal.SIGINT)


def to_one(process: subprocess.Popen[bytes]) -> None:
    """Send what a cancelled job does: the processes that it has started hear nothing."""
    process.send_signal(signal.SIGTERM)


IGNORING = ("sh", "-c", "trap '' INT; exec \"$@\"", "sh")
WORKERS = ("-n", "2")


@pytest.mark.parametrize(
    ("how", "workers", "started_by"),
    [
        (to_all, (), ()),
        (to_all, (), IGNORING),
        (to_all, WORKERS, IGNORING),
        (to_one, (), ()),
        (to_one, WORKERS, ()),
    ],
    ids=["ctrl-c", "ignored", "ignored-workers", "sigterm", "sigterm-workers"],
)
def test_what_was_written_is_put_back(
    pytester: pytest.Pytester,
    how: Callable[[subprocess.Popen[bytes]], None],
    workers: tuple[str, ...],
    started_by: tuple[str, ...],
) -> None:
    pytester.makepyfile(test_mine=INTERRUPTED)
    nodes = [Watched(node_id) for node_id in NODES]
    before = nodes[0].value
    with socketcand() as bus, hosted_on(bus, *nodes):
        reports = "--sdo-report-dir=left behind"
        options = (*QUICK, PATIENT, reports, "--sdo-object=2004=unsigned32", *bus, *workers)
        process = subprocess.Popen(  # noqa: S603
            [
                *started_by,
                sys.executable,
                "-m",
                "pytest",
                "--node-id=5,9",
                *options,
                "test_mine.py",
            ],
            cwd=pytester.path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        for node in nodes if workers else nodes[:1]:
            assert node.written.wait(HANGS)
        how(process)
        output, _ = process.communicate(timeout=HANGS)
        assert [node.value for node in nodes] == [before, before]
    assert process.returncode == pytest.ExitCode.INTERRUPTED, output.decode()
    (folder,) = (pytester.path / "left behind").iterdir()
    assert (folder / "junit.xml").exists()
    recorded = read_run(folder)
    assert recorded.end is not None
    assert recorded.end["how"].startswith("the run was stopped")
    assert len(recorded.results) == 2
    assert {result.verdict for result in recorded.results} == {Verdict.NOT_RUN}
    assert list(folder.glob("bus*.log")), output.decode()


THRICE = """
    import os
    import signal
    from conformance.bus.stop import RunStopped

    def test_stubborn(sdo):
        for _ in range(5):
            try:
                os.kill(os.getpid(), signal.SIGTERM)
            except RunStopped:
                print("not yet")
"""


def test_the_third_signal_ends_at_once(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=THRICE)
    result = pytester.runpytest_subprocess(*QUICK, "--self-test", "-s", "test_mine.py")
    assert result.ret == -signal.SIGTERM
    assert result.stdout.str().count("not yet") == 2


TWICE = """
    import os
    import signal
    from conformance.sdo.layout import Multiplexer

    def test_twice(sdo):
        sdo.download(Multiplexer(0x2004), b"new!")
        link = sdo.channel.link
        send = link.send

        def again(frame):
            if link.stop.requests == 1:
                os.kill(os.getpid(), signal.SIGTERM)
            send(frame)

        link.send = again
        os.kill(os.getpid(), signal.SIGTERM)
"""


def test_the_second_signal_lists_what_is_not_back(pytester: pytest.Pytester) -> None:
    """It comes while the value is put back."""
    pytester.makepyfile(test_mine=TWICE)
    result = self_test(pytester, "test_mine.py")
    assert result.ret == pytest.ExitCode.INTERRUPTED
    result.stdout.fnmatch_lines(
        ["not restored: write 4 bytes: * to 2004h:00 of node 5", "*'conformance restore *"]
    )
    assert list(the_report(pytester).glob("not-restored.jsonl"))


def test_handlers_are_what_they_were(pytester: pytest.Pytester) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    self_test(pytester, "-k", "abort.frame")
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before
