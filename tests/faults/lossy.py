"""Runs the cases over an adapter that loses, repeats or swaps one frame in N.

    python tests/faults/lossy.py [--each FRAMES] [--seeds COUNT] [ARGUMENT ...]

The device is the reference server on the simulated bus, the arguments go to pytest. Fails when a
case fails, or when what was lost is not told.
"""

import argparse
import random
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import can
from case_runs import Run, run_cases

from conformance.faults import hosting
from conformance.plugin.exit_code import ExitCode

MISHAPS = ("lost", "repeated", "swapped")


class LossyBus(can.BusABC):
    """A bus of which some frames are lost, come twice, or change places with the next."""

    def __init__(self, bus: can.BusABC, each: int, seed: int) -> None:
        """One frame in ``each`` has a mishap, on its way to the bus or from it."""
        super().__init__(channel="lossy")
        self._bus = bus
        self._each = each
        self._random = random.Random(seed)
        self._sent: can.Message | None = None
        self._arrived: deque[can.Message] = deque()
        self.mishaps: list[str] = []
        if hasattr(bus, "now"):
            self.now = bus.now

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame, or not, or twice; one that is held goes out behind the next."""
        del timeout
        mishap = self._mishap()
        if mishap == "swapped" and self._sent is None:
            self._sent = msg
            return
        for _ in range({"lost": 0, "repeated": 2}.get(mishap, 1)):
            self._bus.send(msg)
        self._release()

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame that was not lost."""
        self._release()
        while not self._arrived:
            message = self._bus.recv(timeout)
            if message is None:
                return None
            mishap = self._mishap()
            behind = self._bus.recv(0) if mishap == "swapped" else None
            if behind is not None:
                self._arrived.append(behind)
            self._arrived.extend([message] * {"lost": 0, "repeated": 2}.get(mishap, 1))
        return self._arrived.popleft()

    def shutdown(self) -> None:
        """Close the bus."""
        self._bus.shutdown()
        super().shutdown()

    def _release(self) -> None:
        if self._sent is not None:
            self._bus.send(self._sent)
            self._sent = None

    def _mishap(self) -> str:
        if self._random.randrange(self._each):
            return ""
        self.mishaps.append(self._random.choice(MISHAPS))
        return self.mishaps[-1]


@contextmanager
def lossy_adapter(each: int, seed: int) -> Iterator[list[str]]:
    """Within this, the simulated bus of a run is reached by such an adapter; yields its mishaps."""
    mishaps: list[str] = []

    def opened(*arguments: object, **options: object) -> can.BusABC:
        bus = LossyBus(hosting.simulated_bus(*arguments, **options), each, seed)  # type: ignore[arg-type]
        bus.mishaps = mishaps
        return bus

    with patch("conformance.plugin.bench_opening.simulated_bus", opened):
        yield mishaps


def run_lossy(each: int, seed: int, *arguments: str, fault: str | None = None) -> tuple[Run, int]:
    """Run cases over such an adapter; return what they said and how many mishaps there were."""
    with lossy_adapter(each, seed) as mishaps:
        run = run_cases(fault, *arguments)
    return run, len(mishaps)


def main() -> int:
    """Run with several seeds; print what came of each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=1000, metavar="FRAMES")
    parser.add_argument("--seeds", type=int, default=3, metavar="COUNT")
    parser.add_argument("--first", type=int, default=1, metavar="SEED")
    parser.add_argument("--fault", metavar="NAME")
    options, arguments = parser.parse_known_args()
    problems = 0
    for seed in range(options.first, options.first + options.seeds):
        run, mishaps = run_lossy(options.each, seed, *arguments, fault=options.fault)
        failed = run.failed(strict=True)
        print(
            f"seed {seed}: {mishaps} mishaps, exit status {run.exit_code}, "
            f"{len(run.verdicts)} cases, {len(failed)} failed, {run.seconds:.0f} s",
            flush=True,
        )
        for case_id in failed:
            print(f"    {case_id}: {run.causes.get(case_id, '')}")
        told = run.exit_code == ExitCode.BENCH_ERROR or (run.exit_code == 0 and not mishaps)
        if failed or not told:
            problems += 1
            print(run.output[-6000:])
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
