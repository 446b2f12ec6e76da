"""Logs for the judge, written a line a frame: the time in seconds, ``>`` for a request, ``<`` for a
response of node 5, and any other frame as candump writes it.
"""

from collections.abc import Iterable

from conformance.logs.decoded_lines import Judgement
from conformance.logs.findings import Finding
from conformance.logs.judging import LogJudge
from conformance.logs.reading import Seen
from conformance.sdo.can_frame import CanFrame

REQUEST, RESPONSE = 0x605, 0x585


def seen_in(*lines: str) -> list[Seen]:
    """Return the frames of lines such as ``0.001 > 40 00 10``; 00h fills up what is missing."""
    return [_seen(number, *line.split(maxsplit=1)) for number, line in enumerate(lines, start=1)]


def _seen(number: int, time: str, frame: str) -> Seen:
    if frame[0] in "<>":
        data = bytes.fromhex(frame[1:]).ljust(8, b"\0")
        return Seen(
            number, float(time), "can0", CanFrame(RESPONSE if frame[0] == "<" else REQUEST, data)
        )
    identifier, data_hex = frame.split("#")
    return Seen(number, float(time), "can0", CanFrame(int(identifier, 16), bytes.fromhex(data_hex)))


def found_in(*lines: str) -> list[str]:
    """Return what the judge finds: the number of a line, and the rule; ``?`` for a SHOULD."""
    judge = LogJudge()
    found = [each for seen in seen_in(*lines) for each in judge.take(seen)]
    return list(_shown([*found, *judge.end()]))


def _shown(found: Iterable[object]) -> Iterable[str]:
    for each in found:
        if isinstance(each, Finding):
            yield f"{each.seen.number} {each.violation.rule.id}{'' if each.is_failure else '?'}"


def told_of(*lines: str) -> list[str]:
    """Return the lines that ``decode --judge`` shows."""
    judgement = Judgement("line")
    told = [line for seen in seen_in(*lines) for line in judgement.take(seen)]
    return [*told, *judgement.end()]
