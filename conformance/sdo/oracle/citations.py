"""Rules by the row of the protocol reference that says what is required there."""

from dataclasses import replace
from functools import cache

from conformance.sdo.rules import Level, Rule

# What the rows of each table are about: the letter of the row, the clause and the subject.
_TABLES = {
    "I": ("7.2.4.3", "A server without a transfer reacts to each request as CiA 301 draws it."),
    "D": ("7.2.4.3.4", "A segmented download goes on, or ends, as CiA 301 draws it."),
    "U": ("7.2.4.3.7", "A segmented upload goes on, or ends, as CiA 301 draws it."),
    "B": ("7.2.4.3.10", "The sub-blocks of a block download are taken as CiA 301 draws it."),
    "E": ("7.2.4.3.11", "A block download ends as CiA 301 draws it."),
    "F": ("7.2.4.3.14", "The sub-blocks of a block upload are sent as CiA 301 draws it."),
    "G": ("7.2.4.3.15", "A block upload ends as CiA 301 draws it."),
    "O": ("7.2.4.3", "What CiA 301 leaves open is settled in one of the accepted ways."),
}


@cache
def rule_of(row: str) -> Rule:
    """Return the rule of a row, for example ``D3``.

    Raises KeyError for a row that no table has.
    """
    clause, sentence = _TABLES[row[0]]
    return Rule(row, clause, Level.MUST, sentence)


@cache
def must(row: str) -> Rule:
    """Return the rule of a row as one whose breach is a failure."""
    return _at(row, Level.MUST)


@cache
def should(row: str) -> Rule:
    """Return the rule of a row as one whose breach is accepted with a warning."""
    return _at(row, Level.SHOULD)


def _at(row: str, level: Level) -> Rule:
    rule = rule_of(row)
    return rule if rule.level is level else replace(rule, level=level)
