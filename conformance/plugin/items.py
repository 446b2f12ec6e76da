"""How cases become pytest items: named by their id, one for each variation and device."""

import inspect
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from inspect import Signature, signature
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import pytest

from conformance.device.eds_listing import Listing
from conformance.plugin.case_order import FIRST, Place, place_in_run
from conformance.plugin.failure import CaseFailed, as_pytest_shows
from conformance.run.case import CaseInfo, case_info
from conformance.run.case_files import CASE_FILES, CASES
from conformance.run.risks import Kind, Risk

# The fixture behind all fixtures of a device.
DEVICE_SESSION = "_conformance_device_session"
# The prefix of a user's fixture before the name of an argument.
FOR_USERS = "sdo_"
# The parameter that the variation of a case is to pytest and to the reports of its plugins.
VARIATION = "sdo_variation"


NOTHING = Signature()
# It keeps no function, which a run lets go of.
_SIGNATURES: WeakKeyDictionary[object, dict[tuple[object, ...], Signature]] = WeakKeyDictionary()

# The ids and arguments of a case by the labels in the ids; without an argument, by None.
Variations = Mapping[str | None, tuple[str, Mapping[str, object]]]


class CaseModule(pytest.Module):
    """A file of cases; it has the same node-ID wherever the suite is installed."""


class Variation(partial[object]):
    """A case's function with its argument, if it has one.

    The ``labels`` of its variations are for the collection alone.
    """

    labels: Sequence[str] = ()
    __test__: bool

    @property
    def __name__(self) -> str:
        """The name of the function, which pytest and its plugins ask for."""
        return self.func.__name__

    @property
    def pytestmark(self) -> list[pytest.Mark]:
        """The marks of the function."""
        return list(getattr(self.func, "pytestmark", ()))

    @property
    def wanted(self) -> Signature:
        """The names of its arguments; the same for all variations of a function."""
        known = _SIGNATURES.setdefault(self.func, {})
        key = tuple(self.keywords)
        if key not in known:
            found = signature(self.func)
            known[key] = found.replace(
                parameters=[
                    each for name, each in found.parameters.items() if name not in self.keywords
                ]
            )
        return known[key]

    @property
    def __signature__(self) -> Signature:
        """What pytest has to give it."""
        return self.wanted


class OwnVariation(Variation):
    """A case of the suite: it asks pytest for nothing, and gets its arguments from the suite."""

    given: dict[str, object]

    @property
    def __signature__(self) -> Signature:
        """What pytest has to give it."""
        return NOTHING

    def __call__(self) -> object:
        """Call the function with its arguments."""
        return super().__call__(**self.given)


class CaseFunction(pytest.Function):
    """One case on one device; ``risk`` are its frames that the device may not survive.

    ``label`` names the value in which it varies; it is empty for a case that does not vary. It is
    ``written`` in a file, at a line, and is the n-th variation there.
    """

    case: CaseInfo
    case_id: str
    label: str
    node_id: int
    risk: Risk | None
    written: tuple[str, int, int]

    @property
    def is_own(self) -> bool:
        """Whether the case is one of the suite's, not of the user's."""
        return isinstance(self.parent, CaseModule)

    @property
    def asked(self) -> Collection[str]:
        """The names of the arguments of its function, beside its own."""
        return self._variation.wanted.parameters

    @property
    def given(self) -> dict[str, object]:
        """The arguments of a case of the suite, for the try that runs."""
        variation = self._variation
        if not isinstance(variation, OwnVariation):
            raise TypeError(f"{self.name} gets fixtures of pytest")
        return variation.given

    @property
    def _variation(self) -> Variation:
        variation: Variation = self.obj
        return variation

    def asks_for(self, name: str) -> bool:
        """Say whether it asks for something of the suite, directly or by a fixture."""
        return name in self.asked or FOR_USERS + name in self.fixturenames

    @property
    def service(self) -> str:
        """The service of the protocol that the file is about."""
        return self.path.stem.removeprefix("test_").replace("_", " ")

    def reportinfo(self) -> tuple[str, int | None, str]:
        """Say where the case is. The blank keeps -v from writing ``::`` for the dot of an id."""
        file, line, _ = self.written
        return file, line - 1, f"{self.name} "

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Leave out the traceback of a breach: it takes long, and the evidence takes its place."""
        if isinstance(excinfo.value, CaseFailed):
            return as_pytest_shows(self, excinfo, excinfo.value.result)
        return super().repr_failure(excinfo)

    def __repr__(self) -> str:
        rule = self.case.rule
        cited = " ".join(each.id for each in self.case.cites)
        rules = f"  rules {cited}" if cited else ""
        return f"<Case {self.name}  {rule.level}  clause {rule.clause}{rules}>"


def make_module(path: Path, parent: pytest.Collector) -> pytest.Module | None:
    """Return the collector for a file of the suite's own cases, None for any other file."""
    if path.parent != CASES or not path.match(CASE_FILES):
        return None
    return CaseModule.from_parent(parent, path=path, nodeid=f"cases/{path.name}")


def make_items(
    collector: pytest.Collector,
    function: object,
    listings: Mapping[int, Listing],
    *,
    alone: bool = True,
) -> list[CaseFunction] | None:
    """Return the items of a function that is marked as a case, None for any other.

    There are items for each node-ID in ``listings``, with the objects that are listed of it. Where
    a device is not ``alone`` in the run its node-ID stands in the names.
    """
    info = case_info(function)
    if info is None or not callable(function):
        return None
    return list(_items(collector, function, info, listings, alone))


def _items(
    collector: pytest.Collector,
    function: Callable[..., object],
    info: CaseInfo,
    listings: Mapping[int, Listing],
    alone: bool,
) -> Iterator[CaseFunction]:
    variation = OwnVariation if isinstance(collector, CaseModule) else Variation
    place, where = _place_of(function, collector), ""
    # Pytest makes the same items for all devices with the same objects.
    made_of: dict[tuple[str | None, ...], list[pytest.Function]] = {}
    for node_id, listing in listings.items():
        variations = _labelled(info, listing)
        name = info.rule.id if alone else f"{info.rule.id}@{node_id}"
        labels = tuple(variations)
        if labels not in made_of:
            made_of[labels] = _made_by_pytest(collector, function, variation, variations)
        for number, made in enumerate(made_of[labels]):
            callspec = getattr(made, "callspec", None)
            label = callspec.params.get(VARIATION) if callspec else None
            case_id, arguments = variations[label]
            call = variation(function, **arguments)
            call.__doc__ = function.__doc__  # --collect-only -v shows it
            if isinstance(call, OwnVariation):
                call.given = {}
            item = CaseFunction.from_parent(
                collector,
                name=name + made.name.removeprefix(made.originalname),
                originalname=name,
                callspec=callspec,
                callobj=call,
            )
            item.case, item.case_id, item.node_id = info, case_id, node_id
            item.label = label or ""
            item.risk = info.risk_of(arguments)
            item.written = (*place, number)
            # pytest would look for the file of each.
            where = where or item.location[0]
            item.location = where, *item.reportinfo()[1:]
            yield item


def _place_of(function: Callable[..., object], collector: pytest.Collector) -> tuple[str, int]:
    """Return where a function begins; pytest would look for it for each variation."""
    code = getattr(inspect.unwrap(function), "__code__", None)
    return (str(collector.path), 1) if code is None else (code.co_filename, code.co_firstlineno)


def _labelled(info: CaseInfo, listing: Listing) -> Variations:
    variations = info.variations(listing)
    if info.argument is None:
        return {None: variations[0]}
    return dict(zip(info.chosen(listing), variations, strict=True))


def _made_by_pytest(
    collector: pytest.Collector,
    function: Callable[..., object],
    variation: type[Variation],
    variations: Variations,
) -> list[pytest.Function]:
    """Let pytest make an item of a function for each set of parameters.

    Parameters are the variations of the case (see ``parametrize``) and those of plugins. Pytest has
    no other public way to an id whose brackets are parameters, and ``--lf`` compares such ids.
    """
    if not variations:
        return []
    _, arguments = next(iter(variations.values()))
    varied = variation(function, **arguments)
    # Its decorator makes it a case, with any ``python_functions`` of a project.
    varied.__test__ = True
    varied.labels = [label for label in variations if label is not None]
    made = collector.ihook.pytest_pycollect_makeitem(
        collector=collector, name=function.__name__, obj=varied
    )
    return [each for each in made if isinstance(each, pytest.Function)]


def parametrize(metafunc: pytest.Metafunc) -> None:
    """Give a case its variations as parameters, by their labels.

    No fixture takes them, as the function has its argument already; a fixture for each would take
    time.
    """
    varied = metafunc.function
    if isinstance(varied, Variation) and varied.labels:
        metafunc.fixturenames.append(VARIATION)
        metafunc.parametrize(VARIATION, varied.labels, ids=varied.labels, indirect=True)


def judges_run(item: pytest.Item) -> bool:
    """Say whether a case judges the observations of the other cases of the run."""
    return isinstance(item, CaseFunction) and item.asks_for("whole_run")


UNSORTED = ("", 0, 0)


def ordered(items: Iterable[pytest.Item], *, as_files: bool = False) -> list[pytest.Item]:
    """Sort items: device by device, and the cases that judge a whole run behind its other cases.

    Cases that show most come first (see ``case_order``). Risky cases come behind safe ones (see
    ``run.risks``), the riskiest last: a device that is lost has been tested before.
    ``as_files`` is for a list that is read: it keeps the cases of a file together.
    """

    def place(item: pytest.Item) -> tuple[int, bool, Place, tuple[str, int, int]]:
        if not isinstance(item, CaseFunction):
            return (0, False, FIRST, UNSORTED)
        if as_files:
            return (item.node_id, judges_run(item), FIRST, UNSORTED)
        kind = Kind.ORDINARY if item.risk is None else item.risk.kind
        within = place_in_run(item.case_id, kind)
        # Also where another plugin has shuffled them.
        return (item.node_id, judges_run(item), within, item.written)

    return sorted(items, key=place)
