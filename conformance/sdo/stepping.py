"""Takes a transfer of the reference client from step to step, and to its result."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Generic, TypeVar

from conformance.sdo.block_client import Step
from conformance.sdo.frames import Response

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Ended(Generic[Result]):
    """A transfer is over; ``result`` is what it returned."""

    result: Result


def advance(
    transfer: Generator[Step, Response, Result], response: Response | None = None
) -> Step | Ended[Result]:
    """Return the next step of a transfer, or its end.

    ``response`` answered the step before, None where none was awaited.
    Raises Violation and ServerAborted as the transfer does.
    """
    try:
        return next(transfer) if response is None else transfer.send(response)
    except StopIteration as done:
        return Ended(done.value)
