"""The garbage collector is spared what a run keeps: thousands of items and results, over and over.

22.3 s of processor time for a simulated self-test, and 19.7 s without (means of three, 2026-11-22).
To look through all results so far took another 1.0 s of 10.7 s.
"""

import gc
from collections.abc import Generator

import pytest

# What is old is looked through this much less often than what is not: once in six self-tests.
SELDOM = 1000


class Garbage:
    """Hooks that set aside what there is when the cases are collected, and again in the end.

    Between them, what is old is looked through but seldom: it is what the run keeps. What was set
    aside stays so behind the run, as pytest looks for leaks before it ends. Another run in the same
    process changes nothing, nor does one in a process that has set aside something itself: what
    many runs leave behind is to be found.
    """

    def __init__(self) -> None:
        self._is_first = gc.get_freeze_count() == 0
        self._thresholds = gc.get_threshold()

    @pytest.hookimpl(wrapper=True)
    def pytest_collection(self) -> Generator[None, object, object]:
        """Collect without it: nothing is let go yet."""
        if not gc.isenabled():
            return (yield)
        gc.disable()
        try:
            return (yield)
        finally:
            self._set_aside(SELDOM)
            gc.enable()

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self) -> None:
        """Set the results aside as well."""
        self._set_aside(self._thresholds[-1])

    def _set_aside(self, seldom: int) -> None:
        if self._is_first:
            gc.freeze()
            gc.set_threshold(*self._thresholds[:-1], seldom)
