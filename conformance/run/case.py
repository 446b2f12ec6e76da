"""How a function becomes a case: its id, clause and level stand above it, its sentence in it.

    @must("segmented-upload.size", clause="7.2.4.3.7", size=[8, 14])
    def test_size(sdo, device, size):
        '''An upload delivers the bytes of the object.'''

is two cases, ``segmented-upload.size[8]`` and ``segmented-upload.size[14]``.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import getdoc
from typing import Any, TypeVar

from conformance.device.listing import Listing
from conformance.sdo.rules import Level, Rule

Function = TypeVar("Function", bound=Callable[..., None])
Values = Mapping[str, Any] | Sequence[Any]
OfListing = Callable[[Listing], Mapping[str, Any]]
ATTRIBUTE = "conformance_case"


@dataclass(frozen=True, slots=True)
class CaseInfo:
    """What the decorator said: the rule, and the values for which the case is run."""

    rule: Rule
    argument: str | None = None
    values: Mapping[str, Any] | OfListing = field(default_factory=dict)

    def variations(self, listing: Listing | None = None) -> list[tuple[str, dict[str, Any]]]:
        """Return each case's id and arguments; some depend on what is listed of a device."""
        if self.argument is None:
            return [(self.rule.id, {})]
        values = self.values(listing or Listing()) if callable(self.values) else self.values
        return [
            (f"{self.rule.id}[{label}]", {self.argument: value}) for label, value in values.items()
        ]


def must(id_: str, *, clause: str, **each: Values | OfListing) -> Callable[[Function], Function]:
    """Mark a case whose breach fails a device.

    ``each`` is at most one argument with its values: a sequence, a mapping from label to value, or
    a function that chooses such a mapping from what is listed of the device.
    """
    return _case(Level.MUST, id_, clause, each)


def should(id_: str, *, clause: str, **each: Values | OfListing) -> Callable[[Function], Function]:
    """Mark a case whose breach fails a device only with --strict."""
    return _case(Level.SHOULD, id_, clause, each)


def may(id_: str, *, clause: str, **each: Values | OfListing) -> Callable[[Function], Function]:
    """Mark a case on what the specification leaves open; it fails for what no choice allows."""
    return _case(Level.MAY, id_, clause, each)


def _case(
    level: Level, id_: str, clause: str, each: dict[str, Values | OfListing]
) -> Callable[[Function], Function]:
    if len(each) > 1:
        raise ValueError(f"{id_} varies in {', '.join(each)}: one argument is all a case may vary")

    def mark(function: Function) -> Function:
        sentence = " ".join((getdoc(function) or "").split())
        rule = Rule(id_, clause, level, sentence)
        argument, values = next(iter(each.items()), (None, {}))
        if not isinstance(values, Mapping) and not callable(values):
            values = {str(value): value for value in values}
        setattr(function, ATTRIBUTE, CaseInfo(rule, argument, values))
        return function

    return mark


def case_info(function: object) -> CaseInfo | None:
    """Return what the decorator said, or None for an ordinary function."""
    info = getattr(function, ATTRIBUTE, None)
    return info if isinstance(info, CaseInfo) else None
