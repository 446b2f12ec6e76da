"""The reasons why a case cannot be run on a device: no case fails because of them."""

from enum import StrEnum
from typing import NamedTuple

from conformance.sdo.seen import Seen


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
    """A thing that a user may add: its kind, and of an object or a permission the name."""

    kind: Lack
    name: str = ""

    def __str__(self) -> str:
        return f"{self.kind} {self.name}".rstrip()


class NotTestable(Exception):
    """A case needs something that the device or its description lacks.

    The text is for people; ``missing`` is the thing that a user may add, or None.
    """

    def __init__(self, words: str, missing: Missing | None = None) -> None:
        """Take the need, in words."""
        super().__init__(words)
        self.missing = missing


class Unimplemented(Exception):
    """An optional service was properly refused.

    ``frames`` are the bytes of the refusal, if it is one of frames.
    """

    def __init__(self, refusal: str | Seen) -> None:
        """Take the refusal, or words for it."""
        super().__init__(refusal.words if isinstance(refusal, Seen) else refusal)
        self.frames = refusal.frames if isinstance(refusal, Seen) else ()
