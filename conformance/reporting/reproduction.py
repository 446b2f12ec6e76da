"""reproduce/: for each cause of failures what the suite sent, as a script and as a log.

They hold the frames of the first case that failed, up to the one that the verdict is about. The
script takes can-utils and SocketCAN; ``conformance replay`` sends a log again on any bus.
"""

import math
import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from conformance.reporting.bus_log import Place, in_a_log
from conformance.reporting.cause_counts import CauseCount, causes_of
from conformance.reporting.earlier_values import values_of_before
from conformance.reporting.logged import SENT, Logged, frames_by_case, log_in
from conformance.reporting.recorded import RecordedRun
from conformance.run.evidence import CANSEND_KNOWS
from conformance.run.recording import ChannelDecoder
from conformance.run.trace import TraceLine
from conformance.run.verdict import CaseResult
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.nmt import describe_nmt
from conformance.sdo.printable_text import inert
from conformance.sdo.rules import RULES_BY_ID, cited

FOLDER = "reproduce"
SCRIPT, LOG = ".sh", ".log"
# More of them are not looked at one by one.
MOST_CAUSES = 100
MOST_FRAMES = 20_000
# Seconds between two commands; what is shorter passes while the shell starts the next one.
SHORTEST_PAUSE, LONGEST_PAUSE = 0.01, 60.0
LONGEST_NAME = 60


@dataclass(frozen=True, slots=True)
class Step:
    """A frame of the case: seconds, whether the suite sent it, and what it is."""

    time: float
    sent: bool
    frame: CanFrame
    words: str


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A cause and the frames that lead to its first failure; the last one is decisive.

    The first ``earlier`` ones give objects the values that other cases had written.
    """

    number: int
    count: CauseCount
    result: CaseResult
    ids: ChannelIds
    steps: list[Step]
    earlier: int

    @property
    def name(self) -> str:
        """The name of its files, without the end."""
        return file_name(self.number, self.count)


def file_name(number: int, count: CauseCount) -> str:
    """Return the name of the files of a cause, by its number in the reports; without the end."""
    rule = re.sub(r"[^a-z0-9.-]+", "-", count.cause.rule_id.lower())
    return f"{number:02}-{rule[:LONGEST_NAME].strip('.-') or 'cause'}"


def reproductions(folder: Path, number: int, count: CauseCount) -> list[Path]:
    """Return the script and the log of a cause, as far as they lie in the report folder."""
    name = file_name(number, count)
    paths = [folder / FOLDER / (name + end) for end in (SCRIPT, LOG)]
    return [path for path in paths if path.is_file()]


def write_reproductions(folder: Path, run: RecordedRun) -> Path | None:
    """Write the files for each cause into the report folder; return where they are, if there are.

    A cause whose frames bus.log does not have has none. Without a log, those that are there stay.
    Raises OSError.
    """
    target = folder / FOLDER
    logs = {place.log for place in run.places if place is not None}
    if logs and not any(log_in(folder, log).is_file() for log in logs):
        return target if target.is_dir() else None
    if target.is_dir():
        for end in (SCRIPT, LOG):
            for old in target.glob(f"[0-9]*-*{end}"):
                old.unlink()
    found = _reproductions(folder, run)
    if not found:
        return None
    target.mkdir(exist_ok=True)
    channel = run.about["channel"] or ""
    for each in found:
        log = "".join(_log_lines(each, in_a_log(channel) or "can0"))
        (target / (each.name + LOG)).write_text(log, encoding="utf-8")
        if run.about["interface"] == CANSEND_KNOWS:
            script = target / (each.name + SCRIPT)
            script.write_text("\n".join(_script_lines(each, channel)) + "\n", encoding="utf-8")
            script.chmod(0o755)
    return target


def _reproductions(folder: Path, run: RecordedRun) -> list[Reproduction]:
    """Return the causes whose frames are known, in the order in which reports number them."""
    causes = causes_of(run)[:MOST_CAUSES]
    firsts = {id(count.cases[0]): count for count in causes}
    wanted: list[Place | None] = [
        place if id(result) in firsts else None
        for result, place in zip(run.results, run.places, strict=True)
    ]
    channels = run.channels
    own = {cob_id.identifier for ids in channels.values() for cob_id in (ids.request, ids.response)}
    node_ids = [result.node_id for result in run.results]
    found = []
    for log in sorted({place.log for place in wanted if place is not None}):
        path = log_in(folder, log)
        if not path.is_file():
            continue
        lines: dict[int, list[Logged]] = {}
        for number, logged in frames_by_case(folder, log, wanted, node_ids):
            ids = channels[node_ids[number]]
            others = own - {ids.request.identifier, ids.response.identifier}
            lines[number] = _lines(run.results[number], logged, others)
        cases = {
            number: (each, channels[node_ids[number]]) for number, each in lines.items() if each
        }
        earlier = values_of_before(path, list(cases.values()))
        for (number, (each, ids)), before in zip(cases.items(), earlier, strict=True):
            result = run.results[number]
            count = firsts[id(result)]
            steps = _steps([*before, each], ids)
            position = causes.index(count) + 1
            found.append(Reproduction(position, count, result, ids, steps, len(steps) - len(each)))
    return sorted(found, key=lambda each: each.number)


def _lines(result: CaseResult, lines: Sequence[Logged], others: set[int]) -> list[Logged]:
    """Return the frames of a case up to the decisive one; none where they are not to be found.

    Beside the case the log may have frames of what went before, of its first try, and of
    ``others``: devices that were tested at the same time.
    """
    end = None if result.decisive is None else result.decisive + 1
    shown = [line for line in result.trace[:end] if line.frame and line.own]
    places = {(each.stamp, each.frame, each.sent): number for number, each in enumerate(lines)}
    found = [places[key] for key in map(_in_the_log, shown) if key in places]
    if not found or len(found) < len(shown):
        return []
    between = lines[found[0] : found[-1] + 1]
    kept = [each for each in between if each.identifier not in others]
    return kept if any(each.sent for each in kept) and len(kept) <= MOST_FRAMES else []


def _in_the_log(line: TraceLine) -> tuple[str, str, bool]:
    """Return the time, the frame and the direction of a line as bus.log has them."""
    return f"({line.time:f})", line.frame, line.sent


def _steps(parts: Sequence[Sequence[Logged]], ids: ChannelIds) -> list[Step]:
    """Return parts of the log that follow each other at once, up to the last one."""
    lengths = [part[-1].time - part[0].time + SHORTEST_PAUSE for part in parts[:-1]]
    begin = parts[-1][0].time - sum(lengths)
    decoder = ChannelDecoder(ids)
    steps: list[Step] = []
    for part, length in zip(parts, [*lengths, 0.0], strict=True):
        for logged in part:
            frame = CanFrame.parse(logged.frame)
            words = decoder.words(frame) or describe_nmt(frame)
            time = begin + logged.time - part[0].time
            steps.append(Step(time, logged.sent, frame, words))
        begin += length
    return steps


def _log_lines(each: Reproduction, channel: str) -> Iterator[str]:
    for step in each.steps:
        yield f"({step.time:f}) {inert(channel)} {step.frame} {SENT if step.sent else 'R'}\n"


def _script_lines(each: Reproduction, channel: str) -> Iterator[str]:
    yield "#!/bin/sh"
    yield from (f"# {inert(line)}" for line in _about(each, channel))
    yield "set -e"
    sent = [number for number, step in enumerate(each.steps) if step.sent]
    for number, following in pairwise([*sent, len(each.steps)]):
        if each.earlier and number in (0, each.earlier):
            yield "# the case:" if number else "# what objects held that other cases had written:"
        step = each.steps[number]
        words = f"  # {inert(step.words)}" if step.words else ""
        yield f"cansend {shlex.quote(channel)} {step.frame}{words}"
        if following < len(each.steps):
            answered = following > number + 1
            yield from _pause(each.steps[following].time - step.time, answered=answered)
    yield f"# {inert(_look_for(each))}"


def _pause(seconds: float, *, answered: bool) -> Iterator[str]:
    """Yield a pause in which an answer comes, or as long as that of the case was."""
    if answered or seconds >= SHORTEST_PAUSE:
        hundredths = math.ceil(min(max(seconds, SHORTEST_PAUSE), LONGEST_PAUSE) * 100)
        yield f"sleep {hundredths / 100:.2f}"


def _about(each: Reproduction, channel: str) -> Iterator[str]:
    """Yield what the script is about, line by line."""
    result, count = each.result, each.count
    yield f"{count.cause} ({count.told})"
    rule = RULES_BY_ID.get(count.cause.rule_id)
    if rule is not None:
        yield f"rule: {rule.id} ({rule.level}, {cited(rule.clause)}) {rule.sentence}"
    yield f"case: {result.case_id}, node {result.node_id}"
    yield f"expected: {result.expected}"
    yield f"actual: {result.actual}"
    filters = ",".join(map(_filter, (each.ids.request, each.ids.response)))
    yield f"Watch beside it: candump {shlex.quote(f'{channel},{filters}')}"
    yield f"'conformance replay' takes {each.name}{LOG} beside it, and judges the answers."


def _filter(cob_id: CobId) -> str:
    """Write an identifier as candump filters it."""
    return f"{cob_id.can_id:08X}:1FFFFFFF" if cob_id.extended else f"{cob_id.can_id:03X}:7FF"


def _look_for(each: Reproduction) -> str:
    """Say where to look behind the last command, and what it was in the run."""
    decisive = each.steps[-1]
    if decisive.sent:
        return f"Now look for {each.ids.response} with candump; in the run: {each.result.actual}"
    return f"Now candump shows the answer; in the run: {decisive.frame} {decisive.words}".rstrip()
