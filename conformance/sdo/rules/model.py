"""What a rule is: what it asks for, how binding it is, what a breach of it is, and its cause."""

from dataclasses import dataclass
from enum import StrEnum

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Request
from conformance.sdo.kinds import Kind
from conformance.sdo.seen import Said, Seen


class Level(StrEnum):
    """How binding a rule is."""

    MUST = "MUST"
    SHOULD = "SHOULD"
    MAY = "MAY"


MUST, SHOULD, MAY = Level.MUST, Level.SHOULD, Level.MAY


@dataclass(frozen=True, slots=True)
class Rule:
    """One requirement on a server: a stable id, the clause of CiA 301, and one sentence.

    A MAY is a freedom of the server; it is broken by what no choice allows.

    ``reaction`` says in words what is accepted. ``codes`` are the abort codes that are right
    where an abort is due or allowed, the most precise first; with one that is only ``tolerated`` a
    server misses a SHOULD. ``open`` says what the specification leaves to the server.
    ``untestable`` says why no case tests the rule; it is empty when one does.
    """

    id: str
    clause: str
    level: Level
    sentence: str
    reaction: str = ""
    codes: tuple[AbortCode, ...] = ()
    tolerated: tuple[AbortCode, ...] = (AbortCode.GENERAL_ERROR,)
    open: str = ""
    untestable: str = ""


def cited(clause: str) -> str:
    """Return the clause of a rule with the name of its specification."""
    return clause if clause.startswith("CiA") else f"CiA 301 clause {clause}"


@dataclass(frozen=True, slots=True)
class Cause:
    """A defect of a device: the id of a rule, and the kind of answer that breaks it.

    ``code`` is that of an abort. ``request`` is the kind of request where that tells causes apart,
    with its preposition: "to upload initiate".
    """

    rule_id: str
    answer: str
    code: int | None = None
    request: str = ""

    @property
    def kind(self) -> Kind:
        """The kind of answer."""
        return Kind(self.answer, self.code)

    @property
    def words(self) -> str:
        """All but the rule in words."""
        return f"{self.kind} {self.request}" if self.request else str(self.kind)

    def __str__(self) -> str:
        return f"{self.rule_id}: {self.words}"


class Violation(Exception):
    """A response, or its absence, that a rule does not allow.

    ``seen`` is what came instead, ``actual`` is the same in words. ``asked`` is the request that
    was sent last when it was seen, None where that was not noted; ``asked_as`` is its kind where
    that fits more than one request. ``told_as`` is the defect behind this symptom, where it breaks
    other rules as well.
    ``is_certain``: other data came behind a positive confirmation, which no frame explains that was
    lost, repeated or swapped on the bus.
    """

    def __init__(
        self,
        rule: Rule,
        *,
        expected: str,
        actual: Seen | str,
        asked: Request | None = None,
        asked_as: str = "",
        told_as: Cause | None = None,
        is_certain: bool = False,
    ) -> None:
        """``expected`` says in words what the rule asked for; ``actual`` came instead."""
        super().__init__(rule, expected, actual)
        self.rule = rule
        self.expected = expected
        self.seen = Said(actual) if isinstance(actual, str) else actual
        self.asked = asked
        self.asked_as = asked_as
        self.told_as = told_as
        self.is_certain = is_certain

    def __str__(self) -> str:
        return f"{self.rule.id}: expected {self.expected}; got {self.actual}"

    @property
    def actual(self) -> str:
        """The sight in words."""
        return self.seen.words

    @property
    def level(self) -> Level:
        """How bad the breach is: a SHOULD may be missed, what no freedom allows must not be."""
        return SHOULD if self.rule.level is SHOULD else MUST
