"""What the controller behind a network interface says of errors on the bus (SocketCAN).

The kernel tells it by netlink, which ``ip`` of iproute2 speaks: the state of the controller, how
often it has entered the worse ones, and its counters of errors. A virtual bus has none of them.
"""

import json
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from conformance.bus.counters import counted_since
from conformance.bus.opening import BusSettings

ACTIVE = "ERROR-ACTIVE"
# What it counts beside these, a lost arbitration, is no error.
COUNTED = ("bus_error", "error_warning", "error_passive", "bus_off", "restarts")
PATIENCE = 2.0


@dataclass(frozen=True, slots=True)
class ErrorStates:
    """The state of a controller, and what it has counted; nothing where neither is known."""

    state: str = ""
    counts: Mapping[str, int] = field(default_factory=dict)
    sending: int = 0
    receiving: int = 0

    def since(self, before: "ErrorStates") -> str:
        """Say what is wrong with it, and what it has counted since; empty for a sound one."""
        grown = counted_since(before.counts, self.counts)
        told = [f"{name} {count}" for name, count in grown.items()]
        if self.state not in ("", ACTIVE, "STOPPED"):
            told.append(
                f"now {self.state}, error counters {self.sending} (sending) and "
                f"{self.receiving} (receiving)"
            )
        return ", ".join(told)


def ask_ip(channel: str) -> str:
    """Return what ``ip`` tells of an interface, as JSON; nothing where it tells nothing."""
    program = shutil.which("ip")
    if program is None:
        return ""
    command = [program, "-details", "-statistics", "-json", "link", "show", "dev", channel]
    try:
        told = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE)  # noqa: S603 - no shell
    except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError):
        return ""
    return told.stdout


def read_error_states(settings: BusSettings, ask: Callable[[str], str] = ask_ip) -> ErrorStates:
    """Return the error states of an interface as they are now."""
    if settings.interface != "socketcan" or not settings.channel:
        return ErrorStates()
    try:
        (link,) = json.loads(ask(settings.channel))
        info = link["linkinfo"]
        if info["info_kind"] != "can":
            return ErrorStates()
        counts = info.get("info_xstats", {})
        errors = info["info_data"].get("berr_counter", {})
        return ErrorStates(
            str(info["info_data"].get("state", "")),
            {name: int(counts[name]) for name in COUNTED if name in counts},
            int(errors.get("tx", 0)),
            int(errors.get("rx", 0)),
        )
    except (ValueError, TypeError, LookupError, AttributeError):
        return ErrorStates()
