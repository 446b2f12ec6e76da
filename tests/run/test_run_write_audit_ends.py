"""Every value is put back, or told, where a run ends before its time: ctrl-C, a lost device."""

import re
import signal
import threading
from pathlib import Path

import pytest
from run_audit import WRITABLE, asked_to_write, run
from support.run_bench import NODE_ID, Recording

from conformance.device.safety import IDENTITY
from conformance.plugin.exit_code import ExitCode
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.describe import shown
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry

pytest_plugins = ["pytester"]

# With some of the first writes a case writes, with others it is cleaned up behind. The
# second number says how many requests later the run is interrupted: at the fence behind the case.
WRITES = [
    (1, 0),
    (2, 0),
    (3, 0),
    (31, 0),
    (32, 0),
    (1, 1),
    (1, 2),
    (1, 3),
    (1, 4),
    (31, 1),
    (31, 2),
]
LOST = (1, 2, 31, 32)
CASES = "test_expedited_download or test_segmented_download or test_block_download"
HASTY = "--sdo-response-timeout=0.2"


class Counting(Recording):
    """Does something at a certain write."""

    due = 0

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        if len(self.writes) == self.due:
            self.happen()

    def happen(self) -> None:
        """Do it."""


class Interrupting(Counting):
    """Interrupts the run, as ctrl-C at the terminal does, before it answers."""

    later = 0
    armed = False

    def happen(self) -> None:
        self.armed = True

    def receive(self, frame: bytes) -> list[bytes]:
        answers = super().receive(frame)
        if self.armed:
            if self.later == 0:
                self.armed = False
                main = threading.main_thread().ident
                assert main is not None
                signal.pthread_kill(main, signal.SIGINT)
            self.later -= 1
        return answers


def counting(kind: type[Counting], due: int) -> Counting:
    server = kind(reference_entries(NODE_ID))
    server.due = due
    return server


@pytest.mark.parametrize(("due", "later"), WRITES)
def test_ctrl_c(pytester: pytest.Pytester, due: int, later: int) -> None:
    """In a case, and while it is cleaned up behind one."""
    server = counting(Interrupting, due)
    assert isinstance(server, Interrupting)
    server.later = later
    begin = server.values()
    result = run(pytester, server, Node(NODE_ID, server), "-k", CASES)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    assert server.values() == begin
    assert len(server.writes) >= due
    assert {mux for mux, _ in server.writes} <= WRITABLE
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= set(IDENTITY)
    result.stdout.no_fnmatch_line("not restored:*")


class Wedging(Counting):
    """Answers no more, until a file appears: the power was cycled."""

    wedged = False
    power: Path | None = None

    def happen(self) -> None:
        self.wedged = True


class Wedged(Node):
    """The node of such a server."""

    def __init__(self, server: Wedging) -> None:
        super().__init__(NODE_ID, server)
        self.wedging = server

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        server = self.wedging
        if server.wedged and server.power is not None and server.power.exists():
            server.wedged = False
            server.transfer = None
        answers = [] if server.wedged else super().receive(frame)
        return [] if server.wedged else answers


@pytest.mark.parametrize("due", LOST)
def test_a_device_that_is_lost(pytester: pytest.Pytester, due: int) -> None:
    """What has another value now is told, with the value to write back."""
    server = counting(Wedging, due)
    assert isinstance(server, Wedging)
    begin = server.values()
    result = run(pytester, server, Wedged(server), "-k", CASES, HASTY)
    assert result.ret == ExitCode.DEVICE_LOST
    said = re.findall(
        r"^not restored: write ([^(]*?)(?: \([^)]*\))? to (\w{4})h:(\w\w) of node 5$",
        result.stdout.str(),
        re.MULTILINE,
    )
    told = {Multiplexer(int(index, 16), int(sub, 16)): value for value, index, sub in said}
    changed = {mux for mux, value in server.values().items() if value != begin[mux]}
    assert changed <= set(told) <= WRITABLE
    assert told == {mux: shown(begin[mux]) for mux in told}


# One in a case, one while it is cleaned up behind one.
@pytest.mark.parametrize("due", LOST[1:3])
def test_a_device_that_is_lost_and_brought_back(pytester: pytest.Pytester, due: int) -> None:
    server = counting(Wedging, due)
    assert isinstance(server, Wedging)
    server.power = pytester.path / "power"
    begin = server.values()
    recover = f"--sdo-recover=touch {server.power}"
    result = run(pytester, server, Wedged(server), "-x", "-k", CASES, HASTY, recover)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert server.values() == begin
    assert {mux for mux, _ in server.writes} <= WRITABLE
    result.stdout.no_fnmatch_line("not restored:*")
