"""The ways in which a server may go on.

The oracle is a nondeterministic automaton. A server is in one of its states (``State``), but CiA
301 leaves choices, so what was said so far may fit several: each is a ``Branch``. A branch is at
rest, which means that the server waits for the client, or an answer is due. A request turns each
branch into all that the specification allows; a response strikes out those that it does not fit.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.rules import Level, Rule, Violation


class Freedom(NamedTuple):
    """A choice that the specification leaves, and what the server chose."""

    topic: str
    choice: str


class Misfit(Exception):
    """A response is not what an answer has to be.

    ``near`` tells how close it came: 0 for another message altogether, 1 for the right one with a
    wrong content.
    """

    def __init__(self, tell: Callable[[], Violation], near: int = 0) -> None:
        """``tell`` says what is wrong with it: most are never asked, as another branch fits."""
        super().__init__()
        self._tell = tell
        self.near = near

    @property
    def violation(self) -> Violation:
        """What is wrong with it."""
        return self._tell()


class State(Protocol):
    """Where a server is between two frames."""

    name: ClassVar[str]

    def receive(self, frame: bytes, memory: Memory) -> "list[Branch]":
        """Return all that a server may do with the data bytes of a request."""

    def pass_time(self, memory: Memory) -> "list[Branch]":
        """Return all that a server may do when its client is silent for long."""


@dataclass(frozen=True, slots=True, eq=False)
class Due:
    """An answer that has to come: ``take`` reads it and returns what it may mean, or Misfit."""

    rule: Rule
    words: str
    take: Callable[[bytes], "Iterable[Branch]"]


@dataclass(frozen=True, slots=True)
class Branch:
    """One way in which a server may have gone on.

    ``rule`` is the one by which the server got here. While an answer is ``due``,
    ``state`` is the one before it, and requests that come meanwhile wait in the ``backlog``.
    ``freedoms`` and ``findings`` are what is to be reported if this is the way it went.
    """

    state: State
    memory: Memory
    rule: Rule
    due: Due | None = None
    backlog: tuple[bytes, ...] = ()
    freedoms: frozenset[Freedom] = frozenset()
    findings: tuple[Violation, ...] = ()

    @property
    def failures(self) -> int:
        """The number of breaches of a MUST."""
        return sum(finding.rule.level is Level.MUST for finding in self.findings)

    # What follows is done for each branch of each frame, and replace() takes three times as long.

    def waiting(self, frame: bytes) -> "Branch":
        """Let another request wait for the answer that is due."""
        backlog = (*self.backlog, frame)
        return Branch(
            self.state, self.memory, self.rule, self.due, backlog, self.freedoms, self.findings
        )

    def noting(self, *findings: Violation) -> "Branch":
        """Add breaches that do not stop the following."""
        return self._found((*self.findings, *findings)) if findings else self

    def unburdened(self) -> "Branch":
        """Drop the breaches, once they are reported."""
        return self._found(()) if self.findings else self

    def _found(self, findings: tuple[Violation, ...]) -> "Branch":
        return Branch(
            self.state, self.memory, self.rule, self.due, self.backlog, self.freedoms, findings
        )

    def choosing(self, *freedoms: Freedom) -> "Branch":
        """Add choices that the server made."""
        if self.freedoms.issuperset(freedoms):
            return self
        return self.having(self.freedoms.union(freedoms))

    def having(self, freedoms: frozenset[Freedom]) -> "Branch":
        """Let these be the choices that the server made."""
        return Branch(
            self.state, self.memory, self.rule, self.due, self.backlog, freedoms, self.findings
        )


def quiet(state: State, memory: Memory, rule: Rule, *freedoms: Freedom) -> Branch:
    """Build the branch of a server that does not answer."""
    return Branch(state, memory, rule, freedoms=frozenset(freedoms))


def owing(state: State, memory: Memory, due: Due, *freedoms: Freedom) -> Branch:
    """Build the branch of a server that has to answer."""
    return Branch(state, memory, due.rule, due, freedoms=frozenset(freedoms))
