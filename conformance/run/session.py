"""A run against one device: its conversations, its frames, and what the cases saw on the way."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from conformance.beginning.revival import Revival
from conformance.beginning.survey import SURVEY, survey
from conformance.bus.channel import Channel
from conformance.bus.errors import DeviceLost
from conformance.bus.link import Captured, Direction
from conformance.device.device import Device
from conformance.device.effort import AUDITS
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.causes import Causes
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.network import Network
from conformance.dialogue.slow_device import Allowance
from conformance.run.evidence import cansend_lines
from conformance.run.frame_loss import Doubts
from conformance.run.recording import Recording
from conformance.run.restorer import Restorer
from conformance.run.trace import Trace, trace_of
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.decoding import decode_response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import (
    ANSWERED,
    UNSOLICITED,
    Level,
    Rule,
    Violation,
)
from conformance.sdo.seen import Received

_RESTORING = Rule("run.restoring", "", Level.MAY, "What puts values back outside the cases.")
MOST_INCIDENTS = 200
# What comes faster than it is taken has no end.
MOST_LATE = 1000
CAME_LATE = f"{UNSOLICITED.id}: an answer behind the case"


@dataclass(frozen=True, slots=True)
class Incident:
    """Something that a device did wrong beside the point of the case in which it was seen."""

    case_id: str
    violation: Violation


@dataclass(slots=True)
class WholeRun:
    """What the cases of a run saw on the way, to be judged at its end.

    ``incidents`` are reserved fields and filler bytes that are not 0; ``late`` are responses that
    came after the case in which they could have been asked for; ``causes`` are what stands.
    """

    causes: Causes = field(default_factory=Causes)
    incidents: list[Incident] = field(default_factory=list)
    late: list[Incident] = field(default_factory=list)


class DeviceSession:
    """One device in one run."""

    def __init__(
        self,
        channel: Channel,
        device: Device,
        *,
        seed: int,
        cansend_channel: str,
        revival: Revival | None = None,
        causes: Causes | None = None,
    ) -> None:
        """Take a device that was discovered, and what can bring it back when it is lost.

        ``causes`` is what the discovery has found to be wrong with it.
        """
        self.channel = channel
        self.device = device
        self.causes = Causes() if causes is None else causes
        self.whole_run = WholeRun(self.causes)
        self.restorer = Restorer(device)
        self.lost = False
        self.written_beside: list[Multiplexer] = []
        self.revival = revival
        self._seed = seed
        self._cansend_channel = cansend_channel
        self._frames = Recording(channel.ids)
        self._in_case = False
        self._asked_by_others = False
        self._last_case = "the beginning of the run"
        self.doubts = Doubts()
        channel.link.listen(self._capture)

    def _capture(self, captured: Captured) -> None:
        numbers = self.channel.request_id, self.channel.response_id
        self.doubts.frames += captured.frame.can_id in numbers
        # What goes to and fro while another device is tested is none of this one's.
        if self._in_case:
            self._frames.add(captured)
        elif captured.direction is Direction.SENT:
            own = self.channel.ids.request
            self._asked_by_others |= captured.frame.can_id == own.can_id

    def _dialogue(self, rule: Rule) -> Dialogue:
        return Dialogue(self.channel, self.device, CaseRecord(rule, self.causes), self._seed)

    def survey(self) -> None:
        """Find out, before the first case, what is wrong with every answer of the device.

        Raises DeviceLost.
        """
        sdo = self._dialogue(SURVEY)
        try:
            survey(sdo, None if self.revival is None else self._brought_back)
        except DeviceLost:
            self.lost = True
            raise
        finally:
            if not self.lost:
                with self.channel.link.stop.putting_back():
                    self.restorer.restore(sdo)

    def _brought_back(self) -> bool:
        """Take that the device is lost; say whether it could be brought back."""
        self.lost = True
        return not self.revive()

    def begin(self, case_id: str, rule: Rule, *, as_before: bool = True) -> Dialogue:
        """Start the conversation of a case: what is still in the queue is of the one before.

        ``as_before``: it finds all values as they were before the run.
        """
        self.collect_late()
        contents = self.device.contents
        if as_before and contents.left():
            with self.channel.link.stop.putting_back():
                self.restorer.put_back_left(self._dialogue(_RESTORING))
            self.keep_late(self._last_case)
        contents.case_begins()
        sdo = self._dialogue(rule)
        sdo.wire.timing.allowance = Allowance(self.channel.pace)
        sdo.record.in_case = True
        self._frames.clear()
        self._in_case = True
        self._last_case = case_id
        return sdo

    def loss(self) -> DeviceLost:
        """Describe that the device has stopped answering."""
        return DeviceLost(
            f"Node {self.device.node_id} answered before, but does not answer any more, not even "
            "a read of 1000h after an abort. Reset or power-cycle it; the cases before this one "
            "show what was sent to it last."
        )

    def collect_late(self) -> None:
        """Take unsolicited responses; they belong to the case that was last.

        A case on another device may have asked this one: what came then is no late answer.
        """
        asked, self._asked_by_others = self._asked_by_others, False
        for _ in range(MOST_LATE):
            frame = self.channel.receive(0)
            if frame is None:
                break
            if asked or self._may_be_lost(CAME_LATE):
                continue
            seen = Received(decode_response(frame.data), remark=f" ({frame})")
            late = Violation(UNSOLICITED, expected="nothing", actual=seen)
            self.whole_run.late.append(Incident(self._last_case, late))

    def keep_late(self, case_id: str) -> None:
        """Keep the late answers of a case that were met when its values were put back.

        A silence that was met there is none of them, but a cause.
        """
        late, self.restorer.late = self.restorer.late, []
        for violation in late:
            if self._may_be_lost(f"{violation.rule.id} when a value was put back"):
                continue
            if violation.rule is ANSWERED and violation.asked is not None:
                cause = self.causes.of(violation, violation.rule, violation.asked)
                self.causes.add(cause, case_id, violation, aside=True)
            else:
                self.whole_run.late.append(Incident(case_id, violation))

    def _may_be_lost(self, cause: str) -> bool:
        """Say whether what was met behind a case may be due to the bus, and note that."""
        if not self.channel.link.may_lose or not self.doubts.excuses(cause):
            return False
        self.doubts.add(f"behind {self._last_case}", cause)
        return True

    def revive(self) -> str:
        """Bring a lost device back and put back what its loss has kept from being restored.

        Returns an empty text, or why the device stays lost. Raises BenchError.
        """
        if self.revival is None:
            return "the run cannot bring it back without --sdo-process or --sdo-recover"
        with self.channel.link.stop.putting_back():
            why = self.revival.attempt()
            if not why:
                self.lost = False
                self._go_home()
                self.restore_pending()
        return why

    def _go_home(self) -> None:
        """Send a device that has booted to the NMT state in which it serves what the cases need."""
        sdo = self._dialogue(_RESTORING)
        try:
            Network(sdo).go_home()
        except Violation:
            sdo.silence.recover()  # the next case shows what is wrong there

    def restore_pending(self) -> None:
        """Try once more to put back what could not be; what still cannot stays listed."""
        if self.lost or not self.restorer.unrestored or self.channel.link.stop.gives_up:
            return
        self.restorer.restore_pending(self._dialogue(_RESTORING))
        self.keep_late(self._last_case)

    def finish(self) -> None:
        """Put back, behind the last case, what is not back, and what no case has meant to write.

        A wrong device may write elsewhere whatever is put back: so it is looked at again.
        """
        self.collect_late()
        self.restore_pending()
        found: dict[Multiplexer, None] = {}
        for _ in range(AUDITS):
            if self.lost or self.channel.link.stop.gives_up or not self.device.contents.is_used:
                break
            beside = self.restorer.audit(self._dialogue(_RESTORING))
            if not beside:
                break
            found |= dict.fromkeys(beside)
        self.written_beside = list(found)
        self.restore_pending()

    def close(self) -> None:
        """Take no more frames."""
        self.channel.link.ignore(self._capture)

    def end(self) -> None:
        """End the running case."""
        self._in_case = False

    def frames_so_far(self) -> int:
        """Return how many frames the running case has seen."""
        return len(self._frames)

    @property
    def frames(self) -> list[Captured]:
        """The frames of the running case that were kept."""
        return self._frames.kept()

    def show(self, frames: Sequence[Captured]) -> None:
        """Let the running case have exchanged these frames, and no others so far."""
        self._frames.clear()
        for captured in frames:
            self._frames.add(captured)

    def trace(
        self,
        own: int,
        channels: Sequence[ChannelIds],
        *,
        aside: bool,
        decisive: bool,
        shown: Sequence[bytes] = (),
    ) -> Trace:
        """Return the decoded frames of the case: its ``own`` ones, and those ``aside`` behind them.

        ``decisive``: one of them is what the verdict is about, see ``trace_of``.
        """
        return trace_of(
            self._frames.kept(),
            channels,
            own=own,
            gap=self._frames.gap(),
            aside=aside,
            decisive=decisive,
            shown=shown,
        )

    def reproduce(self, own: int) -> list[str]:
        """Return the commands that send what the case sent in its first ``own`` frames.

        There are none for a bus that cansend does not know.
        """
        if not self._cansend_channel:
            return []
        frames, gap = self._frames.kept(), self._frames.gap()
        if gap is not None and own > gap.at:
            own = max(gap.at, own - gap.frames)
            return cansend_lines(frames[:own], self._cansend_channel, gap=gap)
        return cansend_lines(frames[:own], self._cansend_channel)
