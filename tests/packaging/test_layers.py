"""Imports run one way, down the list of packages in docs/architecture.md."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
LISTED = re.compile(r"^\| `conformance/(\w+)` \|", re.MULTILINE)


def layers() -> list[str]:
    """Return the packages from the highest to the lowest."""
    return LISTED.findall((ROOT / "docs/architecture.md").read_text())


def imported(path: Path) -> set[str]:
    """Return the packages that a module imports, wherever in it."""
    nodes = ast.walk(ast.parse(path.read_text()))
    names = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    return {name.split(".")[1] for name in names if name.startswith("conformance.")}


def test_no_package_imports_one_above_it() -> None:
    above: set[str] = set()
    for package in layers():
        modules = sorted((ROOT / "conformance" / package).rglob("*.py"))
        assert modules, package
        above.add(package)
        upward = {str(path): imported(path) & (above - {package}) for path in modules}
        assert not any(upward.values()), {path: names for path, names in upward.items() if names}


def test_each_package_is_in_the_list() -> None:
    """Those that stand above it all, or beside it, are named below it."""
    text = (ROOT / "docs/architecture.md").read_text()
    packages = {path.parent.name for path in (ROOT / "conformance").glob("*/__init__.py")}
    assert {name for name in packages if f"conformance/{name}`" not in text} == set()
