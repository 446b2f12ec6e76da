"""What a server has to serve because it is no point of the case: a refusal of it is a breach."""

from types import TracebackType

from conformance.dialogue.wire import Wire
from conformance.sdo.checks import ServerAborted
from conformance.sdo.describe import describe
from conformance.sdo.rules import NOT_REFUSED, Violation
from conformance.sdo.seen import Received


class Served:
    """A context within which the server may refuse nothing of what is sent."""

    def __init__(self, wire: Wire) -> None:
        """Take what knows what was sent last."""
        self._wire = wire

    def __enter__(self) -> None:
        """Begin; that may be within another."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if isinstance(error, ServerAborted):
            asked = self._wire.last_sent
            raise Violation(
                NOT_REFUSED,
                expected=f"an answer to: {describe(asked)}",
                actual=Received(error.abort),
                asked=asked,
            ) from error
