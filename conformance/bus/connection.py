"""Whether a bus behind a network is still reached: else its silence is not the device's."""

import socket

from conformance.bus.errors import InterfaceLost

GREETING = b"< hi >"
# Seconds within which a daemon greets a client that connects.
PATIENCE = 2.0


class Connection:
    """A socketcand daemon, as its settings name it.

    python-can keeps its own connection to itself, and the protocol has no sign of life on it. But
    the daemon greets each new one.
    """

    def __init__(self, host: str, port: int, patience: float | None = None) -> None:
        """``patience`` is the time in seconds within which the daemon has to greet."""
        self._address = host, port
        self._patience = PATIENCE if patience is None else patience

    def check(self) -> None:
        """Raise InterfaceLost where the daemon does not greet."""
        try:
            with socket.create_connection(self._address, self._patience) as connection:
                connection.settimeout(self._patience)
                if connection.recv(len(GREETING)) == GREETING:
                    return
                trouble = "it does not answer as socketcand does any more"
        except OSError as error:
            trouble = str(error)
        host, port = self._address
        raise InterfaceLost(
            f"socketcand at {host}, port {port}, is not reached: {trouble}. Check the network and "
            "the daemon; the suite does not see the frames of the device meanwhile."
        )
