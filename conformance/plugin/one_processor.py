"""A self-test on one processor: its device and the suite are two threads that take turns.

Only one of them can run at a time, as a Python process has one lock for all its threads. On two
processors each frame wakes the other processor twice, once for the frame and once for the lock,
which takes longer than what either thread does with the frame.
"""

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

# Every so many seconds it is looked whether these threads had better move.
LOOK = 0.5
# Another process computes there, or a processor has nothing to do, if it is so for this part.
MUCH = 0.2
# What Linux tells of the running thread: the 37th field behind its name is its processor.
THREAD = Path("/proc/thread-self/stat")
PROCESSOR = 36
# What Linux tells of all processors, in ticks: first those of programs, in two fields, then those
# of the kernel.
PROCESSORS = Path("/proc/stat")
COMPUTING = slice(3)
# So many of them are a second, on any machine: what the kernel tells programs is scaled to that.
TICKS = 100


@contextmanager
def one_processor() -> Iterator[None]:
    """Keep this thread, and those that it starts, on the processor on which this is entered.

    On Linux only. Where another process needs that processor while others have nothing to do they
    are let go: of two processes that are kept there, the system could not move one away.
    """
    if sys.platform != "linux":
        yield
        return
    allowed = os.sched_getaffinity(0)
    with ExitStack() as staying:
        with suppress(OSError):  # a sandbox may lack the files, or forbid it
            here = int(THREAD.read_text(encoding="ascii").rpartition(")")[2].split()[PROCESSOR])
            before = _computed()
            if allowed <= before.keys():
                os.sched_setaffinity(0, {here})
                staying.enter_context(_watched(here, allowed, before))
        yield


@contextmanager
def _watched(here: int, allowed: set[int], before: dict[int, float]) -> Iterator[None]:
    """Let the threads go where they had better move, and at the end."""
    ended = threading.Event()
    watch = threading.Thread(target=_look, args=(ended, here, allowed, before), daemon=True)
    watch.start()
    try:
        yield
    finally:
        ended.set()
        watch.join()
        _let_go(allowed)


def _look(ended: threading.Event, here: int, allowed: set[int], before: dict[int, float]) -> None:
    begin, own = time.monotonic(), time.process_time()
    while not ended.wait(LOOK):
        now, computed, all_own = time.monotonic(), _computed(), time.process_time()
        much = MUCH * (now - begin)
        spent = {processor: computed[processor] - before[processor] for processor in allowed}
        is_shared = spent.pop(here) - (all_own - own) > much
        if is_shared and any(now - begin - each > much for each in spent.values()):
            _let_go(allowed)
            return
        begin, before, own = now, computed, all_own


def _let_go(allowed: set[int]) -> None:
    if sys.platform == "linux":
        for thread in threading.enumerate():
            if thread.native_id is not None:
                with suppress(ProcessLookupError):
                    os.sched_setaffinity(thread.native_id, allowed)


def _computed() -> dict[int, float]:
    """Return for how many seconds each processor has computed since the machine was started."""
    _, *lines = PROCESSORS.read_text(encoding="ascii").splitlines()  # the first has the sum
    named = [line.removeprefix("cpu").split() for line in lines if line.startswith("cpu")]
    return {
        int(number): sum(int(ticks) for ticks in fields[COMPUTING]) / TICKS
        for number, *fields in named
    }
