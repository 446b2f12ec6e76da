"""Transitions of the reference server to a wrong next state, with the right answer.

Behind one kind of request in one state, the server is idle, or as it was before the request.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from showing import Duet, all_scripts
from support.oracle_objects import NODE_ID

from conformance.faults.catalogue import build_node
from conformance.faults.situation import copied
from conformance.reference.segmented_server import SegmentedServer, Transfer
from conformance.reference.server import BlockDownload, BlockUpload
from conformance.sdo.layout import FRAME_LENGTH, whole_frame

IDLE, BEFORE = "idle", "as before"
Change = Callable[[SegmentedServer, Transfer | None, tuple[str, str, str]], None]


@dataclass(frozen=True, slots=True, order=True)
class Misled:
    """The reference server, but for the state behind one kind of request."""

    state: str
    request: str
    next: str
    wrong: str

    @property
    def name(self) -> str:
        """The transition in words."""
        return f"{self.state} + {self.request} -> {self.next}: {self.wrong}"

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Let the reference server go wrong for a while."""
        with changed(self._mislead):
            yield

    def _mislead(
        self, server: SegmentedServer, before: Transfer | None, seen: tuple[str, str, str]
    ) -> None:
        if seen == (self.state, self.request, self.next):
            server.transfer = before if self.wrong == BEFORE else None


def all_misled() -> list[Misled]:
    """Return what the scripts of the oracle's lead through, with each other next state."""
    found: set[Misled] = set()

    def note(server: SegmentedServer, before: Transfer | None, seen: tuple[str, str, str]) -> None:
        if server.transfer is not None:
            found.add(Misled(*seen, IDLE))
        if server.transfer != before:
            found.add(Misled(*seen, BEFORE))

    with changed(note):
        for script in all_scripts():
            Duet(build_node(None, NODE_ID), build_node(None, NODE_ID), further=False).play(script)
    return sorted(found)


@contextmanager
def changed(change: Change) -> Iterator[None]:
    """Let every server call ``change`` behind each request, with the transfer before it."""
    right = SegmentedServer.receive

    def receive(server: SegmentedServer, frame: bytes) -> list[bytes]:
        before, state = copied(server.transfer), state_of(server.transfer)
        request = type(server.decode(whole_frame(frame))).__name__
        answers = right(server, frame)
        if len(frame) == FRAME_LENGTH:
            change(server, before, (state, request, state_of(server.transfer)))
        return answers

    setattr(SegmentedServer, "receive", receive)  # noqa: B010 - mypy minds an assignment
    try:
        yield
    finally:
        setattr(SegmentedServer, "receive", right)  # noqa: B010 - as above


def state_of(transfer: Transfer | None) -> str:
    """Return the state of a server in words."""
    match transfer:
        case None:
            return IDLE
        case BlockDownload(ended=True):
            return "block download, end due"
        case BlockUpload(sent=0):
            return "block upload, start due"
        case BlockUpload(ended=True):
            return "block upload, end acknowledged next"
    return type(transfer).__name__
