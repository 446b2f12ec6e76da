"""Sends the requests of a log to a device again, each once the one before is answered."""

from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from conformance.bus.errors import BenchError
from conformance.bus.link import Link
from conformance.device.safety import written_by
from conformance.logs.reading import Seen
from conformance.logs.replay_plan import (
    ReplayPlan,
    Step,
    is_answer,
    is_boot_up,
    node_of,
    read_request,
)
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, ChannelIds
from conformance.sdo.frames import Abort
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.line import Line

# Seconds that a device may take to start again after an NMT command that resets it.
BOOT_TIME = 10.0
# Seconds for which the channel has to be quiet behind an abort, and how long that is awaited.
QUIET, MOST_QUIET = 0.05, 2.0
# Frames that come faster than they are taken have no end.
MOST_EARLY = 1000
DEVICE_TYPE = Multiplexer(0x1000, 0)


@dataclass(frozen=True, slots=True)
class ReplayedExchange:
    """A step of the log, the frame that was sent for it, and what came then.

    ``early`` are frames that came before it was sent, though no more were due.
    """

    step: Step
    early: list[Seen]
    sent: Seen
    received: list[Seen]

    @property
    def is_as_then(self) -> bool:
        """Whether the answers are those of the log, and no others."""
        then = [answer.frame for answer in self.step.answers]
        return not self.early and [seen.frame for seen in self.received] == then


class Replay:
    """Sends a plan, with a server that is idle before and afterwards; it closes the link.

    ``response_timeout`` is how long an answer is waited for, in seconds; ``stopped`` a sentence on
    what was not sent, empty for nothing.
    """

    def __init__(self, link: Link, bus: str, plan: ReplayPlan, response_timeout: float) -> None:
        """Take a link in use; ``bus`` is its name in each frame. The time is in seconds."""
        self._link = link
        self._bus = bus
        self._plan = plan
        self.response_timeout = response_timeout
        self._lines: defaultdict[int, Line] = defaultdict(Line)
        self._number = 0
        self._begin = self._link.now()
        self.stopped = ""

    def __enter__(self) -> Self:
        """End what may be open on the channels."""
        try:
            self._link.watch(self._plan.node_ids)
            self._end_transfers()
        except BaseException:
            self._link.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End what may be open, as far as the bus is there, and close it."""
        try:
            with suppress(BenchError):
                self._end_transfers()
        finally:
            self._link.close()

    @property
    def now(self) -> float:
        """The time since the beginning, in seconds."""
        return self._link.now() - self._begin

    def exchanges(self) -> Iterator[ReplayedExchange]:
        """Send frame by frame; raises BenchError."""
        self._begin = self._link.now()
        for step in self._plan.steps:
            if self._would_write_elsewhere(step):
                return
            early = list(self._early())
            sent = self._seen(self.now, step.seen.frame)
            self._link.send(step.seen.frame)
            yield ReplayedExchange(step, early, sent, list(self._answers(step)))

    def _early(self) -> Iterator[Seen]:
        for _ in range(MOST_EARLY):
            frames = self._link.look()
            if not frames:
                return
            for frame in frames:
                if self._is_shown(frame):
                    yield self._received(frame)

    def _would_write_elsewhere(self, step: Step) -> bool:
        """Follow a request; say whether it begins to write what it did not in the log.

        A segment of a block download does, for example, if the device has refused the download.
        """
        node_id = step.node_id
        request = read_request(step.seen.frame, self._lines[node_id]) if node_id else None
        target = None if request is None else written_by(request)
        if target is None or (node_id, target) in self._plan.writes:
            return False
        self.stopped = (
            f"{step.seen.frame} and what follows it were not sent: the device is in another state "
            f"than in the log, and it would write {target}"
        )
        return True

    def _answers(self, step: Step) -> Iterator[Seen]:
        """Yield frames until all answers of the log are there, or the time is over."""
        then = [answer.frame for answer in step.answers]
        due = Counter(frame.can_id for frame in then)
        seconds = self.response_timeout
        if due:
            seconds = max(seconds, BOOT_TIME) if any(map(is_boot_up, then)) else seconds
        elif step.waited is not None:
            seconds = min(seconds, step.waited)
        patience = self._link.patience(seconds)
        while (frame := self._link.receive_with(patience)) is not None:
            patience.looked(silent=False)
            if not self._is_shown(frame):
                continue
            yield self._received(frame)
            if due[frame.can_id]:
                due -= Counter((frame.can_id,))
                if not due:
                    return
                patience = self._link.patience(seconds)

    def _is_shown(self, frame: CanFrame) -> bool:
        """Choose the answers, and the requests of another client, of the nodes that are asked."""
        node_id = node_of(frame)
        asked = frame.can_id == REQUEST_BASE + node_id
        return node_id in self._plan.node_ids and (asked or is_answer(frame))

    def _received(self, frame: CanFrame) -> Seen:
        ids = ChannelIds.default(node_of(frame))
        if ids.response.matches(frame) and frame.dlc == FRAME_LENGTH:
            self._lines[node_of(frame)].response(frame.data)
        return self._seen(self._link.arrived - self._begin, frame)

    def _seen(self, when: float, frame: CanFrame) -> Seen:
        self._number += 1
        return Seen(self._number, when, self._bus, frame)

    def _end_transfers(self) -> None:
        for node_id in self._plan.node_ids:
            abort = Abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR).encode()
            self._link.send(ChannelIds.default(node_id).request.frame(abort))
        deadline = self._link.deadline(MOST_QUIET)
        patience = self._link.patience(QUIET)
        while not deadline.has_passed:
            frame = self._link.receive_with(patience)
            if frame is None:
                return
            patience.looked(silent=False)
            if self._is_shown(frame):
                patience = self._link.patience(QUIET)
