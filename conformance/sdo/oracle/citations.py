"""Rules by the row of the protocol reference, at the level of what has happened.

A rule that grants a freedom (MAY) is broken by what no choice allows: that is a failure. Within
what is allowed, some choices are worse than others: those are breaches of a SHOULD.
"""

from dataclasses import replace
from functools import cache

from conformance.sdo.rules import Level, Rule, rule_of


@cache
def must(row: str) -> Rule:
    """Return the rule of a row, for example ``D3``, as one whose breach is a failure."""
    return _at(row, Level.MUST)


@cache
def should(row: str) -> Rule:
    """Return the rule of a row as one whose breach is accepted with a warning."""
    return _at(row, Level.SHOULD)


def _at(row: str, level: Level) -> Rule:
    rule = rule_of(row)
    return rule if rule.level is level else replace(rule, level=level)
