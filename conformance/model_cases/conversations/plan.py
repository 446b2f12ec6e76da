"""How far a search for a conversation that fails goes."""

from dataclasses import dataclass

SEARCH_SECONDS = 60.0
SHRINK_SECONDS = 30.0
# Most conversations are as short as they get by then; the last transfers would cost as much again.
SHRINK_ANSWERS = 1000


@dataclass(frozen=True, slots=True)
class Plan:
    """How many conversations to try, from which seed, for how many seconds and answers at most."""

    examples: int
    seed: int
    search_seconds: float = SEARCH_SECONDS
    shrink_seconds: float = SHRINK_SECONDS
    shrink_answers: int = SHRINK_ANSWERS
