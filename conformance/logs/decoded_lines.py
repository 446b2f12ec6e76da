"""The lines of ``conformance decode``."""

from collections import defaultdict
from collections.abc import Iterator
from operator import itemgetter

from conformance.logs.findings import Found, NotFollowed, Remark
from conformance.logs.judged_channel import QUIET, JudgedChannel
from conformance.logs.judging import LogJudge
from conformance.logs.other_frames import describe_other
from conformance.logs.reading import Log, Seen
from conformance.logs.transfers import Transfers
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.describe import describe
from conformance.sdo.frames import Request, Response
from conformance.sdo.layout import FRAME_LENGTH
from conformance.sdo.line import Line
from conformance.sdo.nmt import ALL_NODES, NMT_ID, describe_nmt

MOST_NUMBERS = 10
# Stands in place of the frame where a line sums up those before.
ENDED = f"{'=':<20}"
NOT_FOLLOWED = (
    "not judged from here until the channel is quiet for "
    f"{QUIET * 1000:.0f} ms: the client does not wait for its answers, so the responses are "
    "ambiguous"
)


def decoded(log: Log, only: int | None) -> Iterator[str]:
    """Yield the messages of a log in words, of all nodes or of ``only`` one."""
    words = Words(only)
    for seen in log:
        yield from words.lines(seen)


class Words:
    """Puts frames into words, and transfers as they end."""

    def __init__(self, only: int | None = None) -> None:
        """Take all nodes, or ``only`` one."""
        self._only = only
        self._channels: defaultdict[tuple[str, int], tuple[Line, Transfers]]
        self._channels = defaultdict(lambda: (Line(), Transfers()))

    def lines(self, seen: Seen) -> Iterator[str]:
        """Yield a line for a frame, and one for what it ends.

        There is none for a frame that is nothing of CANopen, or of another node.
        """
        frame = seen.frame
        node_id, function = frame.can_id & 0x7F, frame.can_id & ~0x7F
        if frame.can_id == NMT_ID and frame.data[1:]:
            node_id = frame.data[1] or self._only or ALL_NODES
        if self._only not in (None, node_id):
            return
        if not node_id or function not in (REQUEST_BASE, RESPONSE_BASE):
            if words := describe_nmt(frame) or describe_other(frame):
                yield _line(seen, f"{frame!s:<20}", words)
            return
        if frame.remote or frame.extended or frame.dlc != FRAME_LENGTH:
            words = f"node {node_id}: not a data frame of 8 bytes with an 11-bit identifier"
            yield _line(seen, f"{frame!s:<20}", words)
            return
        line, transfers = self._channels[seen.bus, node_id]
        message: Request | Response
        if function == REQUEST_BASE:
            message = line.request(frame.data)
            ended = transfers.request(message, seen.time)
        else:
            message = line.response(frame.data)
            ended = transfers.response(message, seen.time)
        yield _line(seen, f"{frame!s:<20}", f"node {node_id}: {describe(message)}")
        if ended:
            yield _line(seen, ENDED, f"node {node_id}: {ended}")


def _line(seen: Seen, frame: str, words: str) -> str:
    return f"{seen.time * 1000:10.1f} ms {seen.bus} {frame} {words}"


def judged(log: Log, judgement: "Judgement") -> Iterator[str]:
    """Yield the breaches in a log, the choices of each device, and the outcome."""
    for seen in log:
        yield from judgement.take(seen)
    yield from judgement.end()


class Judgement:
    """Judges frame by frame; ``failures`` counts the breaches so far."""

    def __init__(
        self, unit: str, only: int | None = None, *, judge: LogJudge | None = None
    ) -> None:
        """Judge all nodes, or ``only`` one; ``unit`` is what the log numbers."""
        self._unit = unit
        self._only = only
        self._judge = judge or LogJudge()
        self.failures = 0

    def take(self, seen: Seen) -> Iterator[str]:
        """Take the next frame; yield its breaches, and those of the time before it."""
        for finding in self._judge.take(seen):
            yield from self._told(finding)

    def end(self, now: float = 0.0) -> Iterator[str]:
        """Yield which answers have not come, what each device chose, and the outcome.

        The log goes on until ``now``, in seconds, if that is behind its last frame.
        """
        for finding in self._judge.end(now):
            yield from self._told(finding)
        not_judged = 0
        for (bus, node_id), channel in sorted(self._judge.channels.items(), key=itemgetter(0)):
            if self._only in (None, node_id):
                not_judged += len(channel.not_judged)
                yield from self._summed_up(f"{bus}, node {node_id}", channel)
        all_of = f"all responses but the {not_judged} not judged" if not_judged else "all responses"
        yield f"{self.failures} not allowed" if self.failures else f"{all_of} allowed"

    def _summed_up(self, node: str, channel: JudgedChannel) -> Iterator[str]:
        left_out = len(channel.not_judged)
        counts = f"{channel.requests} requests, {channel.responses} responses"
        yield f"{node}: {counts}{f', {left_out} not judged' if left_out else ''}"
        if left_out:
            shown = ", ".join(map(str, channel.not_judged[:MOST_NUMBERS]))
            more = ", …" if left_out > MOST_NUMBERS else ""
            yield f"    not judged, as the state of the server was open: {self._unit} {shown}{more}"
        for line in channel.oracle.profile.lines():
            yield f"    {line}"

    def _told(self, found: Found) -> Iterator[str]:
        if self._only not in (None, found.node_id):
            return
        place = self._place(found)
        if isinstance(found, NotFollowed):
            yield f"{place}: {NOT_FOLLOWED}"
            return
        if isinstance(found, Remark):
            yield f"{place}: remark: {found.words} [{found.seen.frame}]"
            return
        self.failures += found.is_failure * found.times
        violation = found.violation
        again = f" ({found.times} times more up to here)" if found.more else ""
        yield f"{place}: {violation.rule.id} ({violation.level}) {violation.rule.sentence}{again}"
        yield f"    expected: {violation.expected}"
        yield f"    actual:   {violation.actual} [{found.seen.frame}]"

    def _place(self, found: Found) -> str:
        seen = found.seen
        place = f"{self._unit} {seen.number}, {seen.time * 1000:.1f} ms, {seen.bus}"
        return f"{place}, node {found.node_id}"
