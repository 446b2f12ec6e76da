"""The exit status of a run, where pytest has none of its own for it."""

from enum import IntEnum


class ExitCode(IntEnum):
    """Exit codes beside pytest's own: the bench is broken, or too little was tested."""

    SILENT_NODE = 10
    BENCH_ERROR = 11
    DEVICE_LOST = 12
    SUITE_ERROR = 13
    NOT_TESTED = 14
