"""Runs of pytest within a test spare the garbage collector the tests: they are many."""

import gc
from functools import cache


@cache
def spare_tests() -> None:
    """Set aside what this process has before the first run in it, which then looks at its own."""
    gc.collect()
    gc.freeze()
