"""Causes are told by kinds, so that no breach is built with a sentence that has values in it."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = [path for name in ("conformance", "cases") for path in (ROOT / name).rglob("*.py")]


def actual(call: ast.Call) -> ast.expr | None:
    """Return what came instead, where a call builds a breach."""
    match call.func:
        case ast.Name(id="Violation"):
            return next((each.value for each in call.keywords if each.arg == "actual"), None)
        case ast.Attribute(attr="breach") if len(call.args) > 1:
            return call.args[1]
    return None


def formatted(source: str) -> Iterator[int]:
    """Yield the lines in which a breach is built with a formatted string."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(actual(node), ast.JoinedStr):
            yield node.lineno


def test_a_sentence_with_values_says_which_of_them_are_no_part_of_its_kind() -> None:
    found = {str(path): list(formatted(path.read_text())) for path in SOURCES}
    assert {path: lines for path, lines in found.items() if lines} == {}
    assert list(formatted('sdo.breach("1", f"{2}")\nViolation(rule, actual=f"{3}")')) == [1, 2]
