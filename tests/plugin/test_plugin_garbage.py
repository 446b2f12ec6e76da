"""The garbage collector is spared what a run keeps, but not what many runs leave behind."""

import gc
from collections.abc import Iterator
from inspect import signature
from weakref import ref

import pytest
from plugin_runs import QUICK, reports

from conformance.plugin.garbage import SELDOM
from conformance.plugin.items import Variation

pytest_plugins = ["pytester"]


class Looking:
    """Notes how many objects the garbage collector is spared, and how often it looks at others."""

    def __init__(self) -> None:
        self.at_first = self.in_the_end = -1
        self.within: tuple[int, ...] = ()

    @pytest.hookimpl(trylast=True)
    def pytest_sessionstart(self) -> None:
        self.at_first = gc.get_freeze_count()

    def pytest_runtest_call(self) -> None:
        self.within = gc.get_threshold()

    def pytest_unconfigure(self) -> None:
        self.in_the_end = gc.get_freeze_count()


@pytest.fixture(autouse=True)
def nothing_is_spared() -> Iterator[None]:
    """Nor do other tests in this process lose what they are spared."""
    gc.unfreeze()
    yield
    gc.freeze()


def look(pytester: pytest.Pytester, *arguments: str) -> Looking:
    """Run an ordinary test, as a run on a device or not."""
    pytester.makepyfile(test_ordinary="def test_nothing(): pass")
    looking = Looking()
    given = (*QUICK, f"--sdo-report-dir={reports(pytester)}", "test_ordinary.py", *arguments)
    result = pytester.runpytest_inprocess(*given, plugins=[looking])
    result.assert_outcomes(passed=1)
    return looking


def test_what_a_run_keeps_is_set_aside(pytester: pytest.Pytester) -> None:
    looking = look(pytester, "--self-test")
    assert (looking.at_first, looking.in_the_end > 0) == (0, True)


def test_nothing_is_added_to_what_others_have_set_aside(pytester: pytest.Pytester) -> None:
    gc.freeze()
    spared = gc.get_freeze_count()
    assert 0 < look(pytester, "--self-test").in_the_end <= spared


def test_what_is_old_is_looked_through_seldom(pytester: pytest.Pytester) -> None:
    before = gc.get_threshold()
    assert look(pytester, "--self-test").within == (*before[:-1], SELDOM)
    assert look(pytester, "--self-test").within == before  # another run in the same process


def test_the_collector_stays_as_it_was(pytester: pytest.Pytester) -> None:
    before = gc.get_threshold()
    look(pytester, "--self-test")
    assert gc.isenabled()
    assert gc.get_threshold() == before
    gc.disable()
    try:
        look(pytester, "--self-test")
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_run_without_devices_is_left_alone(pytester: pytest.Pytester) -> None:
    assert look(pytester).in_the_end == 0


def test_the_functions_of_an_earlier_run_are_let_go() -> None:
    """Nothing keeps them for the signature that pytest has asked for."""
    functions = []
    for _ in range(3):

        def case(sdo: object, size: int) -> None: ...

        assert list(signature(Variation(case, size=7)).parameters) == ["sdo"]
        functions.append(ref(case))
        del case
    gc.collect()
    assert [function() is None for function in functions] == [True, True, True]
