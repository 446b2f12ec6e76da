"""The bench of a run: one bus, the devices on it, and the frames that went over it."""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field

from conformance.bus.channel import Channel
from conformance.bus.errors import SilentNode
from conformance.bus.link import Captured, Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.device import Device
from conformance.device.objects import KnownObject
from conformance.device.safety import WritePolicy
from conformance.run.discovery import discover
from conformance.run.session import DeviceSession

DEFAULT_RESPONSE_TIMEOUT = 1.0
DEFAULT_SEED = 1


@dataclass(slots=True)
class RunSettings:
    """What the user asked for; ``response_timeout`` is in seconds.

    ``neighbours`` are devices on the same bus that another process tests at the same time.
    """

    node_ids: list[int]
    bus: BusSettings
    response_timeout: float = DEFAULT_RESPONSE_TIMEOUT
    objects: list[KnownObject] = field(default_factory=list)
    seed: int = DEFAULT_SEED
    neighbours: frozenset[int] = frozenset()


def private_channel() -> str:
    """Return a channel of the virtual bus that no other process or run uses."""
    return f"conformance-{os.getpid()}-{os.urandom(4).hex()}"


def _cansend_channel(bus: BusSettings) -> str:
    """Return the interface for lines that can be pasted; other buses have no cansend."""
    return bus.channel if bus.interface == "socketcan" and bus.channel else "can0"


class Bench:
    """Opened before the first case, closed after the last."""

    def __init__(
        self,
        settings: RunSettings,
        hosts: list[AbstractContextManager[object]],
        listener: Callable[[Captured], None],
    ) -> None:
        """``hosts`` are devices to run beside the suite; ``listener`` is handed every frame."""
        self.sessions: dict[int, DeviceSession] = {}
        self.silent: dict[int, SilentNode] = {}
        self._settings = settings
        self._hosts = hosts
        self._listener = listener
        self._stack = ExitStack()

    def open(self) -> None:
        """Open the bus and get to know every device that answers; raises BenchError.

        A device that does not answer has no session and is listed in ``silent``.
        """
        settings = self._settings
        link = Link(open_bus(settings.bus), str(settings.bus))
        self._stack.callback(link.close)
        link.watch(settings.node_ids, settings.neighbours)
        link.listen(self._listener)
        for host in self._hosts:
            self._stack.enter_context(host)
        for node_id in settings.node_ids:
            try:
                self.sessions[node_id] = self._session(link, node_id)
            except SilentNode as error:
                self.silent[node_id] = error

    def _session(self, link: Link, node_id: int) -> DeviceSession:
        settings = self._settings
        channel = Channel(link, node_id, settings.response_timeout)
        writable = [known.mux for known in settings.objects if known.access.writable]
        device = Device(
            node_id,
            list(settings.objects),
            policy=WritePolicy(writable),
            neighbours=settings.neighbours,
        )
        discover(channel, device)
        return DeviceSession(
            channel,
            device,
            seed=settings.seed,
            cansend_channel=_cansend_channel(settings.bus),
        )

    def close(self) -> None:
        """Take what came too late, stop the hosts and close the bus."""
        try:
            for session in self.sessions.values():
                session.collect_late()
        finally:
            self._stack.close()
