"""What is known of a device's objects, and what the conversation has taught about them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, auto
from typing import Self

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import AS_WRITTEN, Access, DataType, Habits, same_data
from conformance.sdo.rules import Rule, idle


class Presence(Enum):
    """Whether an object exists.

    ``FORBIDDEN`` is a sub-index that an object cannot have; whether there is the object is open.
    """

    OPEN = auto()
    PRESENT = auto()
    NO_OBJECT = auto()
    NO_SUB_INDEX = auto()
    FORBIDDEN = auto()


@dataclass(frozen=True, slots=True)
class Facts:
    """What is known of one object; None stands for what is not known.

    ``steady`` says that the value stays until a client writes it; without that, values are not
    compared. ``low`` and ``high`` are limits of a number, both included; ``any_value`` says that
    every value within them is taken. A string or domain surely has room for ``capacity`` bytes.
    Its ``habits`` are reported elsewhere: they are allowed here.

    ``reads_by`` is the rule by which it reads as it does, ``read_only`` that by which it refuses
    every download, ``takes_by`` that by which it refuses all values but those that it ``takes``.
    """

    presence: Presence = Presence.OPEN
    access: Access | None = None
    data_type: DataType | None = None
    value: bytes | None = None
    steady: bool = False
    low: float | None = None
    high: float | None = None
    any_value: bool = False
    capacity: int | None = None
    habits: Habits = AS_WRITTEN
    reads_by: Rule = idle.NOT_REFUSED
    read_only: Rule = idle.READ_ONLY
    takes: frozenset[bytes] | None = None
    takes_by: Rule = idle.NOT_REFUSED

    @property
    def length(self) -> int | None:
        """The bytes of a value; None when they vary or the type is not known."""
        return self.data_type.length if self.data_type is not None else None

    @property
    def reads(self) -> int | None:
        """The bytes that an upload brings; None when they vary, or are known to be wrong."""
        wrong = self.habits.too_long or self.habits.miscounted
        return None if wrong else self.length

    @property
    def varies(self) -> bool:
        """Whether values of several lengths are possible, as far as is known."""
        return self.length is None

    @property
    def keeps_on_abort(self) -> bool:
        """Whether a download that is aborted leaves the value: others may keep a part of it."""
        return self.length is not None

    def same(self, found: bytes, due: bytes) -> bool:
        """Compare values: the 00h that ends a string is optional."""
        return same_data(self.data_type, found, due, self.habits)

    def begins(self, found: bytes, due: bytes) -> bool:
        """Say whether ``found`` may be the first bytes of ``due``."""
        filled = self.habits.filling(due)
        return filled.startswith(found) or (len(found) > len(due) and self.same(found, due))


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What is known of each object; ``otherwise`` holds for all that are not listed."""

    objects: Mapping[Multiplexer, Facts] = field(default_factory=dict)
    otherwise: Facts = Facts()

    @classmethod
    def complete(cls, objects: Mapping[Multiplexer, Facts]) -> Self:
        """Take a list that is complete: what is not in it does not exist."""
        return cls(objects, Facts(Presence.NO_OBJECT))

    def of(self, mux: Multiplexer) -> Facts:
        """Return what is known of an object."""
        if mux in self.objects:
            return self.objects[mux]
        if self.otherwise.presence is Presence.NO_OBJECT and self._has_index(mux.index):
            return replace(self.otherwise, presence=Presence.NO_SUB_INDEX)
        return self.otherwise

    def _has_index(self, index: int) -> bool:
        return any(
            mux.index == index
            for mux, facts in self.objects.items()
            if facts.presence is Presence.PRESENT
        )


@dataclass(frozen=True, slots=True)
class Memory:
    """What the objects hold after what was said so far, if the server did what it seems to.

    ``values`` has the objects whose value is no longer the one that was known at first; None
    stands for any value. ``served`` are objects and services that the server has shown to have.
    ``doubtful`` says that after a breach of the protocol no value is certain.
    """

    knowledge: Knowledge
    values: Mapping[Multiplexer, bytes | None] = field(default_factory=dict)
    served: frozenset[tuple[type, Multiplexer]] = frozenset()
    doubtful: bool = False

    def facts(self, mux: Multiplexer) -> Facts:
        """Return what is known of an object apart from its present value."""
        return self.knowledge.of(mux)

    def value(self, mux: Multiplexer) -> bytes | None:
        """Return what an object has to read as; None for anything."""
        facts = self.facts(mux)
        if not facts.steady:
            return None
        if mux in self.values:
            return self.values[mux]
        return facts.value if self._is_constant(mux) or not self.doubtful else None

    def now(self, mux: Multiplexer) -> bytes | None:
        """Return what an object holds if it keeps its value by itself; None for anything."""
        if mux in self.values:
            return self.values[mux]
        return None if self.doubtful else self.facts(mux).value

    def learned(self, mux: Multiplexer, value: bytes | None) -> "Memory":
        """Remember a value that was written or read; None for one that is not certain.

        Of an object of which nothing is known no value is compared, so none is remembered.
        """
        facts = self.facts(mux)
        if facts.presence is Presence.OPEN and not facts.steady:
            return self
        if self.values.get(mux, b"") == value and mux in self.values:
            return self
        return replace(self, values={**self.values, mux: value})

    def begun(self, mux: Multiplexer) -> "Memory":
        """Remember that a download has begun which may leave a part behind if it is aborted."""
        return self if self.facts(mux).keeps_on_abort else self.learned(mux, None)

    def serving(self, service: type, mux: Multiplexer) -> "Memory":
        """Remember that the server has a service for an object."""
        if (service, mux) in self.served:
            return self
        return replace(self, served=self.served | {(service, mux)})

    def in_doubt(self) -> "Memory":
        """Forget all values but constants: the server has broken the protocol."""
        kept = {mux: value for mux, value in self.values.items() if self._is_constant(mux)}
        return Memory(self.knowledge, kept, self.served, doubtful=True)

    def after_reset(self) -> "Memory":
        """Forget all that was learned: it may be another program, or another device."""
        return Memory(self.knowledge, doubtful=True)

    def _is_constant(self, mux: Multiplexer) -> bool:
        return self.facts(mux).access is Access.CONST
