"""How far a search for a conversation that fails goes."""

from dataclasses import dataclass

from conformance.device.effort import SEARCH_SECONDS, SHRINK_ANSWERS, SHRINK_SECONDS


@dataclass(frozen=True, slots=True)
class SearchPlan:
    """How many conversations to try, from which seed, for how many seconds and answers at most."""

    examples: int
    seed: int
    search_seconds: float = SEARCH_SECONDS
    shrink_seconds: float = SHRINK_SECONDS
    shrink_answers: int = SHRINK_ANSWERS
