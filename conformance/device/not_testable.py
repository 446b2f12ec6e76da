"""What keeps a case from being run on a device: no case fails because of it."""

from enum import StrEnum
from typing import NamedTuple


class Lack(StrEnum):
    """The kinds of things that a user may add for a case to be tested."""

    OBJECT = "object"
    PERMISSION = "permission"
    EDS = "EDS"
    SERVER_TIMEOUT = "server time-out"
    WHOLE_READING = "whole reading"
    EXAMPLES = "examples"
    TIME = "time"


class Missing(NamedTuple):
    """What a user may add: its kind, and of an object or a permission the name."""

    kind: Lack
    name: str = ""

    def __str__(self) -> str:
        return f"{self.kind} {self.name}".rstrip()


class NotTestable(Exception):
    """A case needs something that the device or its description lacks.

    The text is for people; ``missing`` is what the user may add, if there is such a thing.
    """

    def __init__(self, words: str, missing: Missing | None = None) -> None:
        """Say in words what is needed."""
        super().__init__(words)
        self.missing = missing


class Unimplemented(Exception):
    """An optional service was properly refused; the text holds the refusal."""
