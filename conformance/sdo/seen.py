"""The sights that break a rule: a silence, an answer, other data, an odd frame, or something else.

Each has a ``kind``, which identifies causes, and ``words`` for people.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.describe import hex_bytes, in_words, shown
from conformance.sdo.frames import Abort, Response
from conformance.sdo.kinds import NO_ANSWER, OTHER_DATA, Kind, kind_of_answer

# Of so many answers each is shown: a sub-block that comes late has up to 127.
MOST_SHOWN = 3
# A kind has so many letters at the most.
MOST_LETTERS = 60


@dataclass(frozen=True, slots=True)
class Seen(ABC):
    """A sight of any sort; ``remark`` is for people only."""

    remark: str = field(default="", kw_only=True)

    @property
    @abstractmethod
    def kind(self) -> Kind:
        """Its kind: no numbers, no objects, no data."""

    @property
    def responses(self) -> Sequence[Response]:
        """The responses that are part of it."""
        return ()

    @property
    def frames(self) -> Sequence[bytes]:
        """The bytes of the frames that are part of it."""
        return [response.encode() for response in self.responses]

    @property
    def words(self) -> str:
        """It in words."""
        return self._shown() + self.remark

    @abstractmethod
    def _shown(self) -> str:
        """Return it in words, without the remark."""

    def remarking(self, remark: str) -> Self:
        """Return the same with some more words."""
        return replace(self, remark=self.remark + remark)


@dataclass(frozen=True, slots=True)
class NoAnswer(Seen):
    """No answer; ``responses`` may have come that are none to what was asked."""

    sentence: str = "no answer"
    responses: Sequence[Response] = ()

    @property
    def kind(self) -> Kind:
        """That of each silence."""
        return NO_ANSWER

    def _shown(self) -> str:
        return "; ".join([self.sentence, *_in_brief(self.responses)])


@dataclass(frozen=True, slots=True)
class Received(Seen):
    """A response, and perhaps ``more`` of them: the first has the kind."""

    response: Response
    more: Sequence[Response] = ()

    @property
    def kind(self) -> Kind:
        """That of the first response."""
        return kind_of_answer(self.response)

    @property
    def responses(self) -> Sequence[Response]:
        """All of them."""
        return (self.response, *self.more)

    def _shown(self) -> str:
        return "; ".join(_in_brief(self.responses))


@dataclass(frozen=True, slots=True)
class Misread(Received):
    """A response whose data are not those that the object has."""

    @property
    def kind(self) -> Kind:
        """That of all data."""
        return OTHER_DATA


@dataclass(frozen=True, slots=True)
class Data(Seen):
    """Other data than those that are due, perhaps with the object ``of`` which they are."""

    data: bytes
    of: object = None

    @property
    def kind(self) -> Kind:
        """That of all data."""
        return OTHER_DATA

    def _shown(self) -> str:
        return shown(self.data) if self.of is None else f"{self.of} reads {shown(self.data)}"


@dataclass(frozen=True, slots=True)
class OddFrame(Seen):
    """A frame that is no proper response; ``odd`` says why, kinds and words."""

    frame: CanFrame
    odd: dict[str, str]

    @property
    def kind(self) -> Kind:
        """Why it is odd."""
        return Kind(", ".join(self.odd))

    @property
    def frames(self) -> Sequence[bytes]:
        """The frame."""
        return (self.frame.data,)

    def _shown(self) -> str:
        return f"{self.frame} ({', '.join(self.odd.values())})"


@dataclass(frozen=True, slots=True)
class Said(Seen):
    """Anything else: its first line is its kind, unless numbers in it call for a ``sort``.

    It may be about a ``frame``.
    """

    sentence: str
    sort: str = ""
    frame: bytes = b""

    @property
    def kind(self) -> Kind:
        """The sort, or the words."""
        return Kind((self.sort or self.sentence).split("\n", 1)[0][:MOST_LETTERS])

    @property
    def frames(self) -> Sequence[bytes]:
        """The frame, if there is one."""
        return (self.frame,) if self.frame else ()

    def _shown(self) -> str:
        return self.sentence


def _in_brief(responses: Sequence[Response]) -> list[str]:
    """Return the first of some responses in words, and how many more there are."""
    shown = [in_words(each) for each in responses[:MOST_SHOWN]]
    more = len(responses) - len(shown)
    return [*shown, f"{more} more"] if more else shown


def said(template: str, *values: object) -> Said:
    """Build the sight that a sentence describes; its kind has dots for the values.

    >>> said("{} segments", 7).words, str(said("{} segments", 7).kind)
    ('7 segments', '… segments')
    """
    return Said(template.format(*values), template.format(*("…" for _ in values)))


def filled(rest: bytes, frame: bytes) -> Said:
    """Build the sight of bytes without data that are not 0."""
    words = f"{hex_bytes(rest)} in bytes without data [{hex_bytes(frame)}]"
    return Said(words, "… in bytes without data", frame)


def other_data(sentence: str) -> Said:
    """Build the sight of data that a sentence describes."""
    return Said(sentence, OTHER_DATA.name)


def abort_in(seen: Seen) -> Abort | None:
    """Return the abort that was seen, if it was one."""
    response = seen.response if isinstance(seen, Received) else None
    return response if isinstance(response, Abort) else None
