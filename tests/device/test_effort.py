"""How much a run reads, writes and tries."""

import ast
from pathlib import Path

from conformance.device import effort
from conformance.device.effort import LONGEST_READ, Effort

PACKAGE = Path(effort.__file__).parents[1]


def assigned(path: Path) -> set[str]:
    """Return the names of the constants of a module."""
    statements = ast.parse(path.read_text()).body
    targets = [each for one in statements if isinstance(one, ast.Assign) for each in one.targets]
    names = [each for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
    return {each.id for each in names if each.id.isupper()}


def test_each_threshold_has_one_value() -> None:
    """No other module gives a name of the table another value."""
    table = Path(effort.__file__)
    assert len(assigned(table)) > 40
    others = [path for path in PACKAGE.rglob("*.py") if path != table]
    twice = {str(path): assigned(path) & assigned(table) for path in others}
    assert {path: names for path, names in twice.items() if names} == {}


def test_haste_does_less_and_thoroughness_more() -> None:
    assert Effort.HASTE.longest_read < Effort.USUAL.longest_read == LONGEST_READ
    assert Effort.HASTE.objects < Effort.USUAL.objects
    assert Effort.HASTE.further_requests < Effort.USUAL.further_requests
    assert Effort.USUAL.examples < Effort.THOROUGH.examples
    assert Effort.USUAL.search_seconds < Effort.THOROUGH.search_seconds


def test_in_haste_some_items_stand_for_all() -> None:
    assert list(Effort.USUAL.sampled(range(1000))) == list(range(1000))
    assert list(Effort.HASTE.sampled(range(99))) == list(range(99))
    chosen = Effort.HASTE.sampled(range(1000))
    assert (len(chosen), chosen[0], chosen[-1]) == (100, 0, 990)
    assert list(Effort.HASTE.sampled([])) == []
