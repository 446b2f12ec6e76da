"""The bench of a run: one bus, the devices on it, and the frames that went over it."""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from conformance.bus.channel import Channel
from conformance.bus.errors import BenchError, ProcessFailed, SilentNode
from conformance.bus.link import Captured, Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.device import Device
from conformance.device.objects import KnownObject
from conformance.device.process import DeviceProcess, ProcessSettings
from conformance.device.safety import WritePolicy
from conformance.run.discovery import discover
from conformance.run.revival import Revival
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
    process: ProcessSettings | None = None


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
        folder: Path,
    ) -> None:
        """``hosts`` are devices to run beside the suite; ``listener`` is handed every frame.

        ``folder`` takes what the programs of devices write.
        """
        self.sessions: dict[int, DeviceSession] = {}
        self.silent: dict[int, BenchError] = {}
        self._settings = settings
        self._hosts = hosts
        self._listener = listener
        self._folder = folder
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
            except (SilentNode, ProcessFailed) as error:
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
        revival = self._revival(channel)
        if revival is not None:
            revival.start()
        discover(channel, device)
        return DeviceSession(
            channel,
            device,
            seed=settings.seed,
            cansend_channel=_cansend_channel(settings.bus),
            revival=revival,
        )

    def _revival(self, channel: Channel) -> Revival | None:
        if self._settings.process is None:
            return None
        settings = self._settings.process.of(channel.node_id)
        log = self._folder / f"device-{channel.node_id}.log"
        process = self._stack.enter_context(DeviceProcess(settings, log))
        return Revival(settings, process, channel)

    def close(self) -> None:
        """Take what came too late, put back what can be, stop the hosts and close the bus."""
        try:
            for session in self.sessions.values():
                session.collect_late()
                session.restore_pending()
        finally:
            self._stack.close()
