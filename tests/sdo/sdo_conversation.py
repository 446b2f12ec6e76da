"""Drives a transfer of the reference client against responses that were written down."""

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Request, Response
from conformance.sdo.rules import Violation

Transfer = Generator[Request, Response, Any]
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Ended:
    """What a transfer sent, and how it ended; ``error`` None and ``finished`` False: it waits."""

    requests: list[bytes]
    finished: bool
    result: Any = None
    error: Violation | ServerAborted | None = None

    @property
    def broken_rule(self) -> str | None:
        return self.error.rule.id if isinstance(self.error, Violation) else None


def drive(transfer: Transfer, responses: Iterable[bytes]) -> Ended:
    """Feed the responses to a transfer, until it ends or they do."""
    requests = [next(transfer).encode()]
    try:
        for response in responses:
            requests.append(transfer.send(decode_response(response)).encode())
    except StopIteration as done:
        return Ended(requests, True, done.value)
    except (Violation, ServerAborted) as error:
        return Ended(requests, True, error=error)
    return Ended(requests, False)


def served(
    transfer: Generator[Request, Response, Result], receive: Callable[[bytes], list[bytes]]
) -> Result:
    """Run a transfer against a server that answers each request once; return the result."""
    request = next(transfer)
    while True:
        (response,) = receive(request.encode())
        try:
            request = transfer.send(decode_response(response))
        except StopIteration as done:
            result: Result = done.value
            return result


def frames(*lines: str) -> list[bytes]:
    return [bytes.fromhex(line) for line in lines]
