"""The bench of a run: one bus, the devices on it, and the frames that went over it."""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import can

from conformance.beginning.discovery import discover, unseen
from conformance.beginning.first_request import FirstRequest
from conformance.beginning.repeating import Met, in_doubt, is_settled, met_with
from conformance.beginning.revival import Revival
from conformance.bus.channel import Channel
from conformance.bus.counters import counted_since, read_counters
from conformance.bus.error_states import read_error_states
from conformance.bus.errors import (
    BenchError,
    DeviceLost,
    ProcessFailed,
    SilentNode,
    TwoDevices,
)
from conformance.bus.link import Captured, Link
from conformance.bus.opening import BusSettings, connection_of, open_bus
from conformance.bus.stop import Stop
from conformance.device.device import Device
from conformance.device.eds_listing import Listing, mandatory_and
from conformance.device.known_objects import KnownObject, by_multiplexer
from conformance.device.options import RESPONSE_TIMEOUT, SEED, STORAGE_TIME
from conformance.device.permits import Permits, known_objects
from conformance.device.process import DeviceProcess, ProcessSettings
from conformance.device.safety import WritePolicy
from conformance.dialogue.causes import Causes
from conformance.dialogue.channels import TEST_CHANNELS
from conformance.run.before_first_case import Watch
from conformance.run.evidence import CANSEND_KNOWS
from conformance.run.session import DeviceSession
from conformance.sdo.cob_id import ChannelIds

# Takes a device, its channel, and a record of what is about to be changed or is back.
Remember = Callable[[Device, ChannelIds, dict[str, Any]], None]


@dataclass(slots=True)
class RunSettings:
    """What the user asked for; times are in seconds.

    ``server_timeout`` is when the device gives up a transfer whose client is silent, None if never;
    ``storage_time`` is how long it may take to store its parameters or to restore their defaults;
    ``sdo_channel`` is another channel of the device than the default one. ``listings`` holds by
    node-ID what an EDS, or the user, says of the objects; to ``scan`` is to read all indices.
    ``neighbours`` are devices on the same bus that another process tests at the same time.
    """

    node_ids: list[int]
    bus: BusSettings
    _: KW_ONLY
    response_timeout: float = RESPONSE_TIMEOUT.default
    seed: int = SEED.default
    server_timeout: float | None = None
    sdo_channel: ChannelIds | None = None
    listings: dict[int, Listing] = field(default_factory=dict)
    permits: Permits = field(default_factory=Permits)
    scan: bool = False
    neighbours: frozenset[int] = frozenset()
    process: ProcessSettings | None = None
    storage_time: float = STORAGE_TIME.default

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
    """Return the interface as cansend names it; empty for a bus that cansend does not know."""
    return bus.channel or "" if bus.interface == CANSEND_KNOWS else ""


class Bench:
    """Opened before the first case, closed after the last."""

    def __init__(
        self,
        settings: RunSettings,
        hosts: list[AbstractContextManager[object]],
        listener: Callable[[Captured], None],
        folder: Path,
        *,
        opener: Callable[[BusSettings], can.BusABC] = open_bus,
        stop: Stop | None = None,
        remember: Remember | None = None,
        before: Callable[[Channel], None] | None = None,
        progress: Callable[[int, KnownObject, int, int], None] | None = None,
    ) -> None:
        """``hosts`` are devices to run beside the suite; ``listener`` is handed every frame.

        ``folder`` takes what the programs of devices write. ``stop`` may ask the run to end. What
        is about to be changed of a device is handed to ``remember``; ``before`` a device is
        discovered, its channel. ``progress`` is told of each object that is read then: the
        node, the object, how many went before, and how many there are.
        """
        self._progress = progress
        self._remember = remember
        self._before = before
        self._stop = stop or Stop()
        self.sessions: dict[int, DeviceSession] = {}
        self.silent: dict[int, BenchError] = {}
        self._settings = settings
        self._hosts = hosts
        self._listener = listener
        self._folder = folder
        self._open_bus = opener
        self._stack = ExitStack()
        self._counters = read_counters(settings.bus)
        self._error_states = read_error_states(settings.bus)

    def open(self) -> None:
        """Open the bus and get to know every device that answers; raises BenchError.

        A device that does not answer, or not any more, is listed in ``silent``: it gets no cases.
        """
        settings = self._settings
        link = Link(self._open_bus(settings.bus), str(settings.bus), self._stop)
        self._stack.callback(link.close)
        connection = connection_of(settings.bus)
        if connection is not None:
            link.check = connection.check
        link.watch(settings.node_ids, self._further_ids(), settings.neighbours)
        link.listen(self._listener)
        for host in self._hosts:
            self._stack.enter_context(host)
        for node_id in settings.node_ids:
            try:
                self._meet(link, node_id)
            except (SilentNode, TwoDevices, ProcessFailed, DeviceLost) as error:
                self.silent[node_id] = error

    def _further_ids(self) -> list[int]:
        """Return the 11-bit CAN-IDs beside those of the default channels that have to pass."""
        used = [
            *TEST_CHANNELS,
            *([self._settings.sdo_channel] if self._settings.sdo_channel else []),
        ]
        cob_ids = [cob_id for ids in used for cob_id in (ids.request, ids.response)]
        return [cob_id.can_id for cob_id in cob_ids if not cob_id.extended]

    def _meet(self, link: Link, node_id: int) -> None:
        """Get to know a device."""
        settings = self._settings
        channel = Channel(link, node_id, settings.response_timeout, settings.sdo_channel)
        revival = self._revival(channel)
        first = None
        if revival is not None:
            revival.start()
            first = FirstRequest(channel, revival)
        if self._before is not None:
            self._before(channel)
        watch = Watch(channel, revival)
        try:
            session = self._begin(channel, revival)
        except DeviceLost as error:
            raise watch.lost(error) from error
        finally:
            watch.close()
        watch.keep(session.causes)
        if first is not None:
            first.keep(session.causes, session.doubts.add)

    def _begin(self, channel: Channel, revival: Revival | None) -> DeviceSession:
        """Read and survey a device; again where a frame may have been lost on the way."""
        node_id, link = channel.node_id, channel.link
        tries: list[Met] = []
        while True:
            self.sessions[node_id] = session = self._discovered(channel, revival)
            session.survey()
            session.restore_pending()  # what was read next would be taken for the value to keep
            tries.append(met_with(session.device, session.causes))
            if not link.may_lose or session.restorer.unrestored or is_settled(tries):
                break
            if any(standing.violation.is_certain for _, standing in session.causes):
                break
            session.close()
        for cause in in_doubt(tries):
            session.doubts.add("before the first case", cause)
        return session

    def _discovered(self, channel: Channel, revival: Revival | None) -> DeviceSession:
        settings = self._settings
        node_id = channel.node_id
        listing = settings.listings.get(node_id, Listing())
        objects = known_objects(settings.permits.named, listing)
        permits = settings.permits
        listed = settings.all_listings[node_id]
        allowed = permits.allowed(known_objects(permits.named, listed))
        device = Device(
            node_id,
            by_multiplexer(objects),
            policy=WritePolicy(allowed, permits.permissions),
            listing=listed,
            permits=permits,
            server_timeout=settings.server_timeout,
            storage_time=settings.storage_time,
            neighbours=settings.neighbours,
        )
        if self._remember is not None:
            device.contents.tell = partial(self._remember, device, channel.ids)
        causes = Causes()
        brings_back = None if revival is None else lambda: not revival.attempt()
        told = unseen if self._progress is None else partial(self._progress, channel.node_id)
        discover(channel, device, causes, told, brings_back)
        return DeviceSession(
            channel,
            device,
            seed=settings.seed,
            cansend_channel=_cansend_channel(settings.bus),
            revival=revival,
            causes=causes,
        )

    def _revival(self, channel: Channel) -> Revival | None:
        if self._settings.process is None:
            return None
        settings = self._settings.process.of(channel.node_id)
        log = self._folder / f"device-{channel.node_id}.log"
        process = self._stack.enter_context(DeviceProcess(settings, log))
        return Revival(settings, process, channel)

    def counted(self) -> dict[str, int]:
        """Return what the interface has counted of lost or disturbed frames since it was made."""
        return counted_since(self._counters, read_counters(self._settings.bus))

    def errors(self) -> str:
        """Say what the controller has told of errors on the bus since the bench was made."""
        return read_error_states(self._settings.bus).since(self._error_states)

    def close(self) -> None:
        """Take what came too late, put back what can be, stop the hosts and close the bus.

        Raises RunStopped where the user does not want to wait for the values.
        """
        try:
            with self._stop.putting_back():
                for session in self.sessions.values():
                    session.finish()
        finally:
            self._stack.close()
