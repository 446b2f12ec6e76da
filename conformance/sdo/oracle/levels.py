"""Rules at the level of what has happened.

A rule that grants a freedom (MAY) is broken by what no choice allows: that is a failure. Within
what is allowed, some choices are worse than others: those are breaches of a SHOULD.
"""

from dataclasses import replace
from functools import cache

from conformance.sdo.rules import Level, Rule


def must(rule: Rule) -> Rule:
    """Return a rule as one whose breach is a failure."""
    return rule if rule.level is Level.MUST else _at(rule, Level.MUST)


def should(rule: Rule) -> Rule:
    """Return a rule as one whose breach is accepted with a warning."""
    return rule if rule.level is Level.SHOULD else _at(rule, Level.SHOULD)


@cache
def _at(rule: Rule, level: Level) -> Rule:
    return replace(rule, level=level)
