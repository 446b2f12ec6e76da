"""Findings of the judge of a log."""

from dataclasses import dataclass

from conformance.logs.reading import Seen
from conformance.sdo.rules import Level, Violation


@dataclass(frozen=True, slots=True)
class Finding:
    """What was wrong, at which frame: the response, or the request that got no answer.

    ``times`` counts the frames of which this says the same; ``more`` of them, behind one that was
    told before.
    """

    node_id: int
    seen: Seen
    violation: Violation
    times: int = 1
    more: bool = False

    @property
    def is_failure(self) -> bool:
        """Whether it was not allowed: a breach of a SHOULD is."""
        return self.violation.level is Level.MUST


@dataclass(frozen=True, slots=True)
class NotFollowed:
    """From this frame on nothing is judged on its channel until that has been quiet."""

    node_id: int
    seen: Seen


@dataclass(frozen=True, slots=True)
class Remark:
    """A remark: allowed, and worth knowing."""

    node_id: int
    seen: Seen
    words: str


Found = Finding | NotFollowed | Remark
