"""How a function becomes a case: its id, level and rules stand above it, its sentence in it.

    @must("segmented-upload.size", "segmented-upload.segments", "upload.size", size=[8, 14])
    def test_size(sdo, device, size):
        '''An upload delivers the bytes of the object.'''

is two cases, ``segmented-upload.size[8]`` and ``segmented-upload.size[14]``. Both test the two
rules that are named (``python -m conformance rules upload.size`` shows one), and their clause is
that of the first. A case that is called as a rule tests that one before all others.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import getdoc
from typing import TypeVar

from conformance.device.eds_listing import Listing
from conformance.run.risks import Risk, RiskOf
from conformance.sdo.rules import RULES_BY_ID, Level, Rule, rule_of

Function = TypeVar("Function", bound=Callable[..., None])
Values = Mapping[str, object] | Sequence[object]
OfListing = Callable[[Listing], Mapping[str, object]]
ATTRIBUTE = "conformance_case"


@dataclass(frozen=True, slots=True)
class CaseInfo:
    """A decorated case: its requirement, and the values for which it is run.

    ``rule`` is the requirement as the case puts it; ``cites`` are the rules of the registry that it
    tests. A ``slow`` case waits for a time that the device declares; a ``thorough`` one is run with
    --sdo-thorough, or where it is named.
    ``risk`` are frames that a device may not survive; a function gives them for each value.
    ``state`` is that of the server in which a case of the matrix sends each value.
    """

    rule: Rule
    cites: tuple[Rule, ...] = ()
    argument: str | None = None
    values: Mapping[str, object] | OfListing = field(default_factory=dict)
    slow: bool = False
    risk: Risk | RiskOf | None = None
    thorough: bool = False
    state: str = ""

    @property
    def tested_rules(self) -> set[str]:
        """The ids of the rules that the case tests, with its own."""
        return {self.rule.id, *(rule.id for rule in self.cites)}

    def risk_of(self, arguments: Mapping[str, object]) -> Risk | None:
        """Return the risk of a case, by the arguments that ``variations`` gives for it."""
        if self.argument is None or not callable(self.risk):
            return self.risk if isinstance(self.risk, Risk) else None
        return self.risk(arguments[self.argument])

    @property
    def is_of_listed(self) -> bool:
        """Whether there is one of it for each of some objects that are listed of a device."""
        return callable(self.values)

    def chosen(self, listing: Listing | None = None) -> Mapping[str, object]:
        """Return the values of the argument by their labels; some depend on the listing."""
        return self.values(listing or Listing()) if callable(self.values) else self.values

    def variations(self, listing: Listing | None = None) -> list[tuple[str, dict[str, object]]]:
        """Return each case's id and arguments; some depend on the listing of a device."""
        if self.argument is None:
            return [(self.rule.id, {})]
        return [
            (f"{self.rule.id}[{label}]", {self.argument: value})
            for label, value in self.chosen(listing).items()
        ]


def must(
    id_: str,
    *rules: str,
    clause: str | None = None,
    slow: bool = False,
    thorough: bool = False,
    risk: Risk | RiskOf | None = None,
    in_state: str = "",
    **each: Values | OfListing,
) -> Callable[[Function], Function]:
    """Mark a case whose breach fails a device.

    ``rules`` are the ids of the rules that the case tests beside the one whose id it has itself, if
    there is one. ``clause`` is for a case
    on a narrower clause than that of the first rule. ``each`` is at most one argument with its
    values: a sequence, a mapping from label to value, or a function that chooses such a mapping
    from the listing of the device. ``risk`` is for a case with frames that a device may not
    survive, or a function from the argument: such cases run behind the others. ``in_state`` is
    that of the server in which a case of the matrix sends its stimuli.

    Raises UnknownRule for a rule that is not in the registry, ValueError for one named twice.
    """
    return _case(
        Level.MUST,
        id_,
        rules,
        clause,
        each,
        slow=slow,
        thorough=thorough,
        risk=risk,
        in_state=in_state,
    )


def should(
    id_: str,
    *rules: str,
    clause: str | None = None,
    risk: Risk | RiskOf | None = None,
    **each: Values | OfListing,
) -> Callable[[Function], Function]:
    """Mark a case whose breach fails a device only with --strict."""
    return _case(Level.SHOULD, id_, rules, clause, each, risk=risk)


def may(
    id_: str,
    *rules: str,
    clause: str | None = None,
    risk: Risk | RiskOf | None = None,
    **each: Values | OfListing,
) -> Callable[[Function], Function]:
    """Mark a case on a choice of the server; it fails if the response fits no choice."""
    return _case(Level.MAY, id_, rules, clause, each, risk=risk)


def _case(
    level: Level,
    id_: str,
    names: tuple[str, ...],
    clause: str | None,
    each: dict[str, Values | OfListing],
    *,
    slow: bool = False,
    thorough: bool = False,
    risk: Risk | RiskOf | None = None,
    in_state: str = "",
) -> Callable[[Function], Function]:
    if len(each) > 1:
        raise ValueError(f"{id_} varies in {', '.join(each)}: one argument is all a case may vary")
    own = (id_,) if id_ in RULES_BY_ID else ()
    cites = tuple(rule_of(name) for name in (*own, *names))
    if len(set(cites)) < len(cites):
        raise ValueError(f"{id_} names a rule twice")
    if clause is None:
        if not cites:
            raise ValueError(f"{id_} names neither a rule nor a clause")
        clause = cites[0].clause

    def mark(function: Function) -> Function:
        sentence = " ".join((getdoc(function) or "").split())
        rule = Rule(id_, clause, level, sentence)
        argument, values = next(iter(each.items()), (None, {}))
        if not isinstance(values, Mapping) and not callable(values):
            values = {str(value): value for value in values}
        case = CaseInfo(rule, cites, argument, values, slow, risk, thorough, in_state)
        setattr(function, ATTRIBUTE, case)
        return function

    return mark


def case_info(function: object) -> CaseInfo | None:
    """Return the case of a decorated function, None for an ordinary one."""
    info = getattr(function, ATTRIBUTE, None)
    return info if isinstance(info, CaseInfo) else None
