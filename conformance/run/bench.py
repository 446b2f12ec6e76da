"""The bench of a run: one bus, the devices on it, and the frames that went over it."""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field, replace

import can

from conformance.bus.channel import Channel
from conformance.bus.link import Captured, Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.device.device import Device
from conformance.device.listing import Listing, mandatory_and
from conformance.device.permits import Permits, known_objects
from conformance.device.safety import WritePolicy
from conformance.run.channel_steps import TEST_CHANNELS
from conformance.run.discovery import discover
from conformance.run.session import DeviceSession
from conformance.sdo.cob_id import ChannelIds

DEFAULT_RESPONSE_TIMEOUT = 1.0
DEFAULT_SEED = 1


@dataclass(slots=True)
class RunSettings:
    """What the user asked for; times are in seconds.

    ``server_timeout`` is when the device gives up a transfer whose client is silent, None if never;
    ``sdo_channel`` is another channel of the device than the default one. ``listings`` holds by
    node-ID what an EDS, or the user, says of the objects; to ``scan`` is to read all indices.
    """

    node_ids: list[int]
    bus: BusSettings
    response_timeout: float = DEFAULT_RESPONSE_TIMEOUT
    seed: int = DEFAULT_SEED
    server_timeout: float | None = None
    sdo_channel: ChannelIds | None = None
    listings: dict[int, Listing] = field(default_factory=dict)
    permits: Permits = field(default_factory=Permits)
    scan: bool = False

    @property
    def all_listings(self) -> dict[int, Listing]:
        """What is known of the objects of each node before anything was asked."""
        without = mandatory_and(self.permits.named)
        return {
            node_id: replace(self.listings.get(node_id, without), to_scan=self.scan)
            for node_id in self.node_ids
        }


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
        opener: Callable[[BusSettings], can.BusABC] = open_bus,
    ) -> None:
        """``hosts`` are devices to run beside the suite; ``listener`` is handed every frame."""
        self.sessions: dict[int, DeviceSession] = {}
        self._settings = settings
        self._hosts = hosts
        self._listener = listener
        self._open_bus = opener
        self._stack = ExitStack()

    def open(self) -> None:
        """Open the bus and get to know every device; raises BenchError."""
        settings = self._settings
        link = Link(self._open_bus(settings.bus), str(settings.bus))
        self._stack.callback(link.close)
        link.watch(settings.node_ids, self._further_ids())
        link.listen(self._listener)
        for host in self._hosts:
            self._stack.enter_context(host)
        for node_id in settings.node_ids:
            self.sessions[node_id] = self._session(link, node_id)

    def _further_ids(self) -> list[int]:
        """Return the 11-bit CAN-IDs beside those of the default channels that have to pass."""
        used = [
            *TEST_CHANNELS,
            *([self._settings.sdo_channel] if self._settings.sdo_channel else []),
        ]
        cob_ids = [cob_id for ids in used for cob_id in (ids.request, ids.response)]
        return [cob_id.can_id for cob_id in cob_ids if not cob_id.extended]

    def _session(self, link: Link, node_id: int) -> DeviceSession:
        settings = self._settings
        channel = Channel(link, node_id, settings.response_timeout, settings.sdo_channel)
        listing = settings.listings.get(node_id, Listing())
        objects = known_objects(settings.permits.named, listing)
        permits = settings.permits
        device = Device(
            node_id,
            objects,
            policy=WritePolicy(permits.allowed(objects), permits.permissions),
            listing=settings.all_listings[node_id],
            permits=permits,
            server_timeout=settings.server_timeout,
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
