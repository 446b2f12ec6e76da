"""Mechanical mutants of source code: one place of one method changed at a time, in memory.

A mutant is named after its method, and the source before and behind the change; so a name lasts
as long as the method.
"""

import ast
import copy
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitOr,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
PLACES = (ast.Attribute, ast.Subscript)


@dataclass(frozen=True, slots=True)
class Mutant:
    """A method of a class with one place changed."""

    name: str
    owner: type[Any]
    method: str
    tree: ast.FunctionDef

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Let the class have the changed method for a while."""
        right = vars(self.owner)[self.method]
        setattr(self.owner, self.method, self._compiled())
        try:
            yield
        finally:
            setattr(self.owner, self.method, right)

    def _compiled(self) -> Any:
        """Return the method; ``super()`` finds its class in the function around it."""
        outer = ast.parse("def outer(__class__):\n    pass").body[0]
        assert isinstance(outer, ast.FunctionDef)
        outer.body = [self.tree, ast.Return(ast.Name(self.method, ast.Load()))]
        module = ast.fix_missing_locations(ast.Module([outer], []))
        found: dict[str, Any] = {}
        names = vars(import_module(self.owner.__module__))
        exec(compile(module, self.name, "exec"), names, found)  # noqa: S102 - it is source of ours
        return found["outer"](self.owner)


def mutants_of(
    modules: Iterable[ModuleType], without: Callable[[str], bool] = lambda _: False
) -> list[Mutant]:
    """Return the mutants of all methods, but for the methods that are left out by name."""
    found: list[Mutant] = []
    for module in modules:
        assert module.__file__
        tree = ast.parse(Path(module.__file__).read_text("utf-8"))
        for kind in tree.body:
            if isinstance(kind, ast.ClassDef):
                for method in kind.body:
                    owner = vars(module)[kind.name]
                    if isinstance(method, ast.FunctionDef) and not without(method.name):
                        found += _mutants(owner, method)
    return found


def _mutants(owner: type[Any], method: ast.FunctionDef) -> Iterator[Mutant]:
    """Yield the mutants of a method; further ones of one name have numbers."""
    names: Counter[str] = Counter()
    for place, new in _changes(method):
        old = _node_at(method, place)
        tree = copy.deepcopy(method)
        _replace(tree, place, copy.deepcopy(new))
        name = f"{owner.__name__}.{method.name}: {_text(old)} -> {_text(new)}"
        names[name] += 1
        number = f" ({names[name]})" if names[name] > 1 else ""
        yield Mutant(name + number, owner, method.name, tree)


# Where a node is: the fields and positions that lead to it.
Place = tuple[tuple[str, int | None], ...]


def _changes(method: ast.FunctionDef) -> Iterator[tuple[Place, ast.AST]]:
    places: list[tuple[Place, ast.AST]] = [
        ((("body", number),), statement) for number, statement in enumerate(method.body)
    ]
    while places:
        place, node = places.pop(0)
        yield from ((place, new) for new in _variants(node))
        for name, value in ast.iter_fields(node):
            if isinstance(value, ast.AST):
                places.append(((*place, (name, None)), value))
            elif isinstance(value, list):
                places += [
                    ((*place, (name, number)), each)
                    for number, each in enumerate(value)
                    if isinstance(each, ast.AST)
                ]


def _variants(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may stand in the place of a node."""
    match node:
        case ast.Compare():
            for number, operator in enumerate(node.ops):
                for other in COMPARISONS[type(operator)]:
                    yield _with(node, "ops", [*node.ops[:number], other(), *node.ops[number + 1 :]])
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield from (ast.Constant(value + 1), ast.Constant(value - 1))
        case ast.BinOp() | ast.AugAssign():
            yield _with(node, "op", OPERATORS[type(node.op)]())
        case ast.BoolOp():
            yield _with(node, "op", ast.Or() if isinstance(node.op, ast.And) else ast.And())
        case ast.UnaryOp(op=ast.Not()):
            yield node.operand
        case ast.If() | ast.IfExp():
            yield from (_with(node, "test", ast.Constant(each)) for each in (True, False))
        case ast.Return(value=ast.List(elts=[_, *_])):
            yield ast.Return(ast.List([], ast.Load()))
    match node:
        case ast.Expr(value=ast.Call()) | ast.Raise() | ast.AugAssign():
            yield ast.Pass()
        case ast.Assign() if isinstance(node.targets[0], PLACES):
            yield ast.Pass()


def _with(node: ast.AST, field: str, value: object) -> ast.AST:
    changed = copy.copy(node)
    setattr(changed, field, value)
    return changed


def _node_at(tree: ast.AST, place: Place) -> ast.AST:
    for name, number in place:
        value = getattr(tree, name)
        tree = value if number is None else value[number]
    return tree


def _replace(tree: ast.AST, place: Place, new: ast.AST) -> None:
    *way, (name, number) = place
    parent = _node_at(tree, tuple(way))
    if number is None:
        setattr(parent, name, new)
    else:
        getattr(parent, name)[number] = new


def _text(node: ast.AST) -> str:
    """Return the first line of a node's source."""
    return ast.unparse(ast.fix_missing_locations(copy.deepcopy(node))).partition("\n")[0]
