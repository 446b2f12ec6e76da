"""The lines of ``conformance replay``."""

from collections.abc import Iterator

from conformance.logs.decoded_lines import Judgement, Words
from conformance.logs.judging import LogJudge
from conformance.logs.replaying import Replay

NO_ANSWER = "no answer"


class Replayed:
    """Sends and judges; ``failures`` counts the breaches in the lines that were read."""

    def __init__(self, replay: Replay) -> None:
        """Take the frames to send; the server is idle."""
        self._replay = replay
        self._judgement = Judgement(
            "frame", judge=LogJudge(begins_idle=True, patience=replay.response_timeout)
        )

    @property
    def failures(self) -> int:
        """How many responses were not allowed."""
        return self._judgement.failures

    def lines(self) -> Iterator[str]:
        """Yield each frame in words, the answers in the log, and the breaches."""
        words, judgement = Words(), self._judgement
        number = as_then = 0
        for exchange in self._replay.exchanges():
            for seen in (*exchange.early, exchange.sent, *exchange.received):
                yield from words.lines(seen)
                yield from judgement.take(seen)
            number += 1
            as_then += exchange.is_as_then
            if not exchange.is_as_then:
                then = [f"{frame} {words}".rstrip() for frame, words in exchange.step.answers]
                yield from (f"    in the log: {answer}" for answer in then or [NO_ANSWER])
        yield from judgement.end(self._replay.now)
        if self._replay.stopped:
            yield self._replay.stopped
        yield f"answered as in the log: {as_then} of {number}"
