"""What each case has to do, as it was counted on the built-in device (``tests/workload.py``).

A device that holds less, or serves less, has less to do; which cases take long is the same.
"""

import json
import re
from dataclasses import dataclass
from functools import cache
from math import inf
from pathlib import Path

RANDOM = "random"
# Assumed of a case that was not counted: answers and silences to wait for, and milliseconds.
UNKNOWN = (10.0, 0.0, 10.0)
_PATH = Path(__file__).with_suffix(".json")


@dataclass(frozen=True, slots=True)
class Work:
    """The ``answers`` that a case waits for, and the ``seconds`` it takes where they come at once.

    ``silences`` are the answers that it waits for and that need not come. ``at_most`` limits its
    duration, in seconds.
    """

    service: str
    family: str
    answers: float
    silences: float
    seconds: float
    at_most: float = inf

    @property
    def point(self) -> str:
        """What the case is about, whatever the service.

        >>> work_of("cases/test_block_upload.py::block-upload.beyond-16-bits").point
        'beyond-16-bits'
        """
        return self.family.partition(".")[2]

    def due(self, work: float, answer: float, silence: float) -> float:
        """Return how long it takes, by the seconds for one of work, an answer and a silence."""
        seconds = self.seconds * work + self.answers * answer + self.silences * silence
        return min(seconds, self.at_most)


def service_of(name: str) -> str:
    """Return the service that a case is about, by its name in pytest.

    >>> service_of("cases/test_block_upload.py::block-upload.size@5[14]")
    'block_upload'
    """
    file = name.partition("::")[0].rpartition("/")[2]
    return file.removesuffix(".py").removeprefix("test_")


def family_of(name: str) -> str:
    """Return the name of a case without its variation and its node.

    >>> family_of("cases/test_block_upload.py::block-upload.size@5[14]")
    'block-upload.size'
    """
    return name.partition("::")[2].partition("[")[0].partition("@")[0]


def case_of(name: str) -> str:
    """Return the name of a case without its node.

    >>> case_of("cases/test_block_upload.py::block-upload.size@5[14]")
    'block-upload.size[14]'
    """
    return re.sub(r"@\d+", "", name.partition("::")[2], count=1)


def work_of(name: str) -> Work:
    """Return what a case has to do, by its name in pytest."""
    service, family, table = service_of(name), family_of(name), _table()
    answers, silences, milliseconds = (
        table.get(case_of(name)) or table.get(family) or table.get(service) or UNKNOWN
    )
    return Work(service, family, answers, silences, milliseconds / 1000)


def counted() -> set[str]:
    """Return the services and families of which it is known what they have to do."""
    return set(_table())


@cache
def _table() -> dict[str, tuple[float, float, float]]:
    found: dict[str, tuple[float, float, float]] = json.loads(_PATH.read_text(encoding="utf-8"))
    return found
