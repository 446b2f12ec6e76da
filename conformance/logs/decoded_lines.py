"""What ``conformance decode`` shows of a recorded log, line by line."""

from collections.abc import Iterator
from itertools import chain
from operator import itemgetter

from conformance.logs.judging import PATIENCE, Finding, LogJudge, NotFollowed
from conformance.logs.reading import RecordedLog, Seen
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.describe import Decoder, describe
from conformance.sdo.layout import FRAME_LENGTH

NOT_FOLLOWED = (
    "not judged from here until the channel is quiet for "
    f"{PATIENCE * 1000:.0f} ms: the client does not wait for its answers, so the responses are "
    "ambiguous"
)


def decoded(log: RecordedLog, only: int | None) -> Iterator[str]:
    """Yield the SDO messages of a log in words, of all nodes or of ``only`` one."""
    decoders: dict[tuple[str, int], Decoder] = {}
    for seen in log:
        words = _in_words(seen, decoders, only)
        if words is not None:
            yield f"{seen.time * 1000:10.1f} ms {seen.bus} {seen.frame!s:<20} {words}"


def _in_words(seen: Seen, decoders: dict[tuple[str, int], Decoder], only: int | None) -> str | None:
    frame = seen.frame
    node_id, function = frame.can_id & 0x7F, frame.can_id & ~0x7F
    if function not in (REQUEST_BASE, RESPONSE_BASE) or only not in (None, node_id):
        return None
    if frame.remote or frame.extended or frame.dlc != FRAME_LENGTH:
        return f"node {node_id}: not a data frame of 8 bytes with an 11-bit identifier"
    decoder = decoders.get((seen.bus, node_id))
    if decoder is None:
        decoder = decoders[seen.bus, node_id] = Decoder()
    follow = decoder.request if function == REQUEST_BASE else decoder.response
    return f"node {node_id}: {describe(follow(frame.data))}"


class Judged:
    """Judges a log; ``failures`` counts what was not allowed, as far as the lines were read."""

    def __init__(self, log: RecordedLog, only: int | None) -> None:
        """Judge all nodes, or ``only`` one."""
        self._log = log
        self._only = only
        self.failures = 0

    def lines(self) -> Iterator[str]:
        """Yield what was not allowed, what each device chose, and the outcome."""
        judge = LogJudge()
        for finding in chain(chain.from_iterable(map(judge.take, self._log)), judge.end()):
            if self._only not in (None, finding.node_id):
                continue
            if isinstance(finding, NotFollowed):
                yield f"{self._place(finding)}: {NOT_FOLLOWED}"
                continue
            self.failures += finding.is_failure
            yield from self._found(finding)
        not_judged = 0
        for (bus, node_id), channel in sorted(judge.channels.items(), key=itemgetter(0)):
            if self._only in (None, node_id):
                counts = f"{channel.requests} requests, {channel.responses} responses"
                left_out = f", {channel.not_judged} not judged" if channel.not_judged else ""
                not_judged += channel.not_judged
                yield f"{bus}, node {node_id}: {counts}{left_out}"
                for line in channel.oracle.profile.lines():
                    yield f"    {line}"
        all_of = f"all responses but the {not_judged} not judged" if not_judged else "all responses"
        yield f"{self.failures} not allowed" if self.failures else f"{all_of} allowed"

    def _place(self, found: Finding | NotFollowed) -> str:
        seen = found.seen
        place = f"{self._log.unit} {seen.number}, {seen.time * 1000:.1f} ms, {seen.bus}"
        return f"{place}, node {found.node_id}"

    def _found(self, finding: Finding) -> Iterator[str]:
        violation = finding.violation
        rule = f"{violation.rule.id} ({violation.level}) {violation.rule.sentence}"
        yield f"{self._place(finding)}: {rule}"
        yield f"    expected: {violation.expected}"
        yield f"    actual:   {violation.actual} [{finding.seen.frame}]"
