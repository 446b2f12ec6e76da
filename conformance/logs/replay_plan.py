"""The plan of ``conformance replay``, from a log: requests, their answers, and their writes."""

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from conformance.device.safety import written_by
from conformance.logs.reading import RecordedLog, Seen
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import HIGHEST_NODE_ID, REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.decoding import decode_request
from conformance.sdo.describe import describe
from conformance.sdo.frames import Request
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer, whole_frame
from conformance.sdo.line import Line
from conformance.sdo.nmt import (
    ALL_NODES,
    ERROR_CONTROL_BASE,
    NMT_ID,
    NmtState,
    decode_nmt,
    describe_nmt,
    error_control,
)

MOST_REQUESTS = 100_000
MOST_NAMED = 20


class NotReplayed(ValueError):
    """A log cannot be sent again, or needs a permission; says why."""


class Answer(NamedTuple):
    """A frame that came in the log, and its meaning in words."""

    frame: CanFrame
    words: str


@dataclass(slots=True)
class Step:
    """A frame to send, and the answers that it had in the log.

    ``waited`` is the time in seconds until the next frame was sent; None for the last.
    """

    seen: Seen
    answers: list[Answer] = field(default_factory=list)
    waited: float | None = None

    @property
    def node_id(self) -> int:
        """The node that is asked; 0 for an NMT command."""
        return 0 if is_nmt(self.seen.frame) else node_of(self.seen.frame)


@dataclass(slots=True)
class ReplayPlan:
    """The frames that are sent; what that would write; which NMT commands there are.

    ``left_out`` counts the frames, by CAN-ID, that were sent according to the log and are neither.
    """

    steps: list[Step] = field(default_factory=list)
    writes: set[tuple[int, Multiplexer]] = field(default_factory=set)
    commands: list[str] = field(default_factory=list)
    left_out: Counter[int] = field(default_factory=Counter)

    @property
    def node_ids(self) -> list[int]:
        """The nodes that are asked."""
        return sorted({step.node_id for step in self.steps} - {0})

    @property
    def changes(self) -> str:
        """The changes that the frames may make, in words; empty if none."""
        objects = [f"{mux} of node {node_id}" for node_id, mux in sorted(self.writes)]
        parts = [f"writes {_listed(objects)}"] if objects else []
        parts += [f"sends NMT commands ({_listed(self.commands)})"] if self.commands else []
        return " and ".join(parts)

    @property
    def notes(self) -> list[str]:
        """The frames of the log that are not sent."""
        return [
            f"{number} frames with {can_id:03X}h are not sent: that is no default SDO channel"
            for can_id, number in sorted(self.left_out.items())
        ]

    def check(self, *, writes: bool) -> None:
        """Raise NotReplayed for a log that changes something, unless it may."""
        if self.changes and not writes:
            raise NotReplayed(f"The log {self.changes}: add --writes to send that to the device.")


def _listed(names: Iterable[str]) -> str:
    known = list(dict.fromkeys(names))
    more = f" and {len(known) - MOST_NAMED} more" if len(known) > MOST_NAMED else ""
    return ", ".join(known[:MOST_NAMED]) + more


def node_of(frame: CanFrame) -> int:
    """Return the node-ID in an identifier of the default connection set."""
    return frame.can_id & HIGHEST_NODE_ID


def is_nmt(frame: CanFrame) -> bool:
    """Say whether a frame has the identifier of NMT commands."""
    return frame.can_id == NMT_ID and not frame.extended


def is_answer(frame: CanFrame) -> bool:
    """Say whether a frame is one that a client waits for: a response, or a boot-up message."""
    node_id = node_of(frame)
    if frame.can_id == RESPONSE_BASE + node_id:
        return node_id != ALL_NODES
    return is_boot_up(frame)


def is_boot_up(frame: CanFrame) -> bool:
    """Say whether a frame is a boot-up message."""
    node_id = node_of(frame)
    booted = error_control(node_id, NmtState.INITIALISING)
    return frame.can_id == ERROR_CONTROL_BASE + node_id and frame == booted


def read_request(frame: CanFrame, line: Line) -> Request | None:
    """Read a request as a server might take it that does not mind its length or its format."""
    if frame.remote or not frame.data:
        return None
    if frame.extended or len(frame.data) != FRAME_LENGTH:
        return decode_request(whole_frame(frame.data))
    return line.request(frame.data)


def read_plan(log: RecordedLog, only: int | None) -> ReplayPlan:
    """Read the frames to all nodes, or to ``only`` one.

    Raises NotReplayed, and LogError and OSError as the log does.
    """
    reader = _Reader(only)
    for seen in log:
        reader.take(seen)
    plan = reader.plan
    asked = set(plan.node_ids)
    if not asked:
        whom = "" if only is None else f" to node {only}"
        raise NotReplayed(f"The log has no SDO requests{whom} on a default channel.")
    for step in plan.steps:  # others boot as well
        step.answers = [each for each in step.answers if node_of(each.frame) in asked]
    return plan


class _Reader:
    """Sorts the frames of a log."""

    def __init__(self, only: int | None) -> None:
        self.plan = ReplayPlan()
        self._only = only
        self._bus = ""
        self._lines: defaultdict[int, Line] = defaultdict(Line)

    def take(self, seen: Seen) -> None:
        """Take the next frame."""
        frame = seen.frame
        node_id = node_of(frame)
        if is_nmt(frame):
            self._command(seen)
        elif node_id and frame.can_id == REQUEST_BASE + node_id:
            if self._only in (None, node_id):
                self._request(node_id, seen)
        elif is_answer(frame):
            self._answer(node_id, seen)
        elif seen.sent:
            self.plan.left_out[frame.can_id] += 1

    def _command(self, seen: Seen) -> None:
        message = decode_nmt(seen.frame)
        if message is None or self._only is None or message.node_id in (ALL_NODES, self._only):
            words = describe_nmt(seen.frame).removeprefix("NMT: ") or str(seen.frame)
            self.plan.commands.append(words)
            self._send(seen)

    def _request(self, node_id: int, seen: Seen) -> None:
        request = read_request(seen.frame, self._lines[node_id])
        target = None if request is None else written_by(request)
        if target is not None:
            self.plan.writes.add((node_id, target))
        self._send(seen)

    def _send(self, seen: Seen) -> None:
        steps = self.plan.steps
        self._bus = self._bus or seen.bus
        if seen.bus != self._bus:
            raise NotReplayed(f"The log has requests on {self._bus} and on {seen.bus}.")
        if len(steps) >= MOST_REQUESTS:
            raise NotReplayed(f"The log has more than {MOST_REQUESTS} requests.")
        if steps:
            steps[-1].waited = max(0.0, seen.time - steps[-1].seen.time)
        steps.append(Step(seen))

    def _answer(self, node_id: int, seen: Seen) -> None:
        if not self.plan.steps or self._only not in (None, node_id) or seen.bus != self._bus:
            return
        frame = seen.frame
        words = describe_nmt(frame)
        if not words and not frame.remote and not frame.extended and frame.dlc == FRAME_LENGTH:
            words = describe(self._lines[node_id].response(frame.data))
        self.plan.steps[-1].answers.append(Answer(frame, words))
