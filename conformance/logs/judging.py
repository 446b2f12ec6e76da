"""Judges the SDO conversations in a recorded log, of any client with any device."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from conformance.logs.findings import Found
from conformance.logs.judged_channel import Effort, JudgedChannel
from conformance.logs.reading import Seen
from conformance.logs.stopped_nodes import NODE_IDS, StoppedNodes
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE
from conformance.sdo.nmt import (
    ALL_NODES,
    ERROR_CONTROL_BASE,
    NMT_ID,
    NmtCommand,
    NmtState,
    decode_nmt,
)

STATE_BITS = 0x7F
RESETS = (NmtCommand.RESET_NODE, NmtCommand.RESET_COMMUNICATION)


@dataclass(slots=True)
class Network:
    """The nodes of one bus: their channels, which are stopped, and which were told to reset."""

    channels: dict[int, JudgedChannel] = field(default_factory=dict)
    stopped: StoppedNodes = field(default_factory=StoppedNodes)
    resetting: set[int] = field(default_factory=set)

    def owes(self, node_id: int) -> bool:
        """Say whether an answer of a node may be on its way."""
        channel = self.channels.get(node_id)
        return channel is not None and not channel.rests


@dataclass(slots=True)
class LogJudge:
    """Follows all default SDO channels of a log, frame by frame, each by its bus and its node.

    Of the devices' objects nothing is known but what CiA 301 says of its own. A log may begin in
    the middle of a transfer, unless it ``begins_idle``. ``patience`` is the time in seconds within
    which a device has to answer, where one is agreed on.
    """

    begins_idle: bool = False
    patience: float | None = None
    _networks: dict[str, Network] = field(default_factory=dict)
    _effort: Effort = field(default_factory=Effort)
    _now: float = 0.0

    @property
    def channels(self) -> dict[tuple[str, int], JudgedChannel]:
        """The channels by bus and node-ID."""
        return {
            (bus, node_id): channel
            for bus, network in self._networks.items()
            for node_id, channel in network.channels.items()
        }

    def take(self, seen: Seen) -> Iterator[Found]:
        """Take the next frame; yield its breaches, and those of the time before it."""
        self._now = seen.time
        frame = seen.frame
        node_id, function = frame.can_id & 0x7F, frame.can_id & ~0x7F
        plain = not frame.extended and not frame.remote
        if frame.can_id == NMT_ID:
            if plain:
                yield from self._command(seen)
        elif not node_id:
            return
        elif function == ERROR_CONTROL_BASE and frame.dlc == 1 and plain:
            yield from self._error_control(node_id, seen)
        elif function == REQUEST_BASE:
            yield from self._request(node_id, seen)
        elif function == RESPONSE_BASE:
            yield from self._response(node_id, seen)

    def end(self, now: float = 0.0) -> Iterator[Found]:
        """Yield which answers have not come though the log goes on for long enough, or until now.

        That is a time in seconds on the clock of the log.
        """
        for channel in self.channels.values():
            yield from channel.end(max(self._now, now))

    def _request(self, node_id: int, seen: Seen) -> Iterator[Found]:
        network = self._network(seen.bus)
        channel = self._channel(network, node_id)
        if network.stopped.asks(node_id, seen.time):
            channel.requests += 1
        else:
            yield from channel.request(seen)

    def _response(self, node_id: int, seen: Seen) -> Iterator[Found]:
        network = self._network(seen.bus)
        channel = self._channel(network, node_id)
        if network.stopped.is_left(node_id, seen.time):
            channel.lost()
        if node_id not in network.stopped:
            yield from channel.response(seen)
            return
        channel.responses += 1
        broken = list(network.stopped.judged(node_id, seen))
        if not broken:
            channel.not_judged.append(seen.number)
        yield from broken

    def _network(self, bus: str) -> Network:
        if bus not in self._networks:
            self._networks[bus] = Network()
        return self._networks[bus]

    def _channel(self, network: Network, node_id: int) -> JudgedChannel:
        if node_id not in network.channels:
            network.channels[node_id] = JudgedChannel.of(
                node_id, self._effort, self.patience, begins_idle=self.begins_idle
            )
        return network.channels[node_id]

    # Network management: what a node may send depends on the state that it was told to enter

    def _command(self, seen: Seen) -> Iterator[Found]:
        """Follow an NMT command; of a frame that is none it is open what a node makes of it."""
        network = self._network(seen.bus)
        message = decode_nmt(seen.frame)
        everybody = message is None or message.node_id == ALL_NODES
        node_ids: Iterable[int] = NODE_IDS if message is None or everybody else (message.node_id,)
        for node_id in node_ids:
            channel = network.channels.get(node_id)
            if message is not None and message.command is NmtCommand.STOP:
                owing = network.owes(node_id)
                # A master that stops all others does not stop itself.
                network.stopped.stop(node_id, seen.time, owing=owing, certain=not everybody)
            elif network.stopped.go_on(node_id, seen.time) and channel is not None:
                channel.lost()
            if message is None or message.command in RESETS:
                network.resetting.add(node_id)
            if channel is None:
                continue
            if node_id in network.resetting:
                yield from channel.told_to_reset(seen.time)
            else:
                channel.interrupted()

    def _error_control(self, node_id: int, seen: Seen) -> Iterator[Found]:
        """Follow the state that a node reports."""
        network = self._network(seen.bus)
        state = seen.frame.data[0] & STATE_BITS
        channel = network.channels.get(node_id)
        owing = network.owes(node_id)
        changed = network.stopped.says(node_id, state, seen.time, owing=owing)
        if state == NmtState.INITIALISING:
            commanded = node_id in network.resetting
            network.resetting.discard(node_id)
            channel = self._channel(network, node_id)
            yield from channel.booted(commanded=commanded)
        elif channel is not None:
            yield from channel.heard()
            if changed:
                channel.lost()
