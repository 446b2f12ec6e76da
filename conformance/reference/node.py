"""The reference server as a node on the bus: its channels, its NMT state, what it sends by itself.

Without I/O and without a clock: ``advance`` is told what time it is, in seconds on any scale, and
``wake_at`` says when that has to happen next although no frame came.
"""

from collections.abc import Callable
from functools import partial

from conformance.reference.communication import Mapping
from conformance.reference.segmented_server import SegmentedServer
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.channel_parameters import ServerParameter
from conformance.sdo.cob_id import HIGHEST_NODE_ID, ChannelIds, CobId
from conformance.sdo.emergency import Errors, register_of
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import (
    ALL_NODES,
    COMMUNICATION_AREA,
    NMT_ID,
    TRANSITIONS,
    NmtCommand,
    NmtState,
    decode_nmt,
    emergency,
    error_control,
)
from conformance.sdo.objects import DataType, Entry, Refusal
from conformance.sdo.pdos import is_count_of_mapping
from conformance.sdo.storage_commands import (
    APPLICATION_PART,
    COMMANDS,
    COMMUNICATION_PART,
    LOAD_ALL,
    ON_COMMAND,
    SAVE_ALL,
    signature_of,
)

HEARTBEAT_TIME = Multiplexer(0x1017)
# Entries, whether a reset of the communication is about them, and their values.
Values = list[tuple[Entry, bool, bytes]]


class ServerChannel:
    """An SDO server and the record that says where it listens.

    ``deadline`` is when the client of the running transfer has been silent for too long.
    """

    def __init__(self, server: SegmentedServer, record: ServerParameter) -> None:
        """Start without a transfer."""
        self.server = server
        self.record = record
        self.deadline: float | None = None

    def forget(self) -> None:
        """Drop the running transfer without a word."""
        self.server.transfer = None
        self.deadline = None


class Node:
    """A node with the default SDO channel, 600h and 580h plus node-ID, and further ones.

    All servers work on the objects of the first. The node adds the objects that are its own, where
    they do not keep to a description: 1001h, 1017h, 1200h, and 1201h, 1202h, … for each further
    channel. Where an ``ErrorCode`` is
    among the objects, an emergency follows each change of it.

    A reset leads to the ``power_on`` values, that is to the ``defaults`` until others are stored.
    """

    def __init__(
        self,
        node_id: int,
        server: SegmentedServer,
        *further: SegmentedServer,
        server_timeout: float | None = None,
    ) -> None:
        """Take the node-ID, 1 to 127, and after how many seconds a silent client is given up."""
        self.node_id = node_id
        self.server = server
        self.objects = server.objects
        self.server_timeout = server_timeout
        self.state = NmtState.INITIALISING
        self.now = 0.0
        ids = ChannelIds.default(node_id)
        self.request_id = ids.request.can_id
        self.response_id = ids.response.can_id
        self.channels = [ServerChannel(server, ServerParameter.default(ids))]
        for number, other in enumerate(further, 1):
            self.channels.append(ServerChannel(other, self.further_record(number)))
        self.errors = Errors(self.objects)
        self.heartbeat_time = Entry(bytes(2), DataType.UNSIGNED16)
        self.objects.add({HEARTBEAT_TIME: self.heartbeat_time})
        for channel in self.channels:
            self.objects.add(channel.record.by_multiplexer())
        mappings = [mux.index for mux, _ in self.objects.items() if is_count_of_mapping(mux)]
        for index in mappings:
            Mapping(self.objects, index).attach()
        self.defaults = self.power_on = self.present()
        commands = self.commands()
        self._commands = [
            (entry, signature_of(mux), commands.get(mux, _nothing))
            for mux, entry in self.objects.items()
            if mux.index in COMMANDS and mux.sub_index
        ]
        self._heartbeat_period = 0.0
        self._heartbeat_due: float | None = None

    def further_record(self, number: int) -> ServerParameter:
        """Return 1200h plus ``number``; every second one has a sub-index 03h."""
        check_client = self.check_client if number % 2 == 0 else None
        return ServerParameter.further(number, self.check_cob_id, check_client)

    # What is kept without power: 1010h and 1011h, where the device has them

    def present(self) -> Values:
        """Return all entries, whether a reset of the communication is about them, their values."""
        return [
            (entry, mux.index in COMMUNICATION_AREA, entry.value)
            for mux, entry in self.objects.items()
        ]

    def commands(self) -> dict[Multiplexer, Callable[[], None]]:
        """Return what the signatures ask for that may be written."""
        commands = {SAVE_ALL: self.save, LOAD_ALL: self.load_defaults}
        for sub_index, in_area in ((COMMUNICATION_PART, True), (APPLICATION_PART, False)):
            save, load = (Multiplexer(index, sub_index) for index in COMMANDS)
            commands |= {
                save: partial(self.save_part, in_area=in_area),
                load: partial(self.load_part, in_area=in_area),
            }
        return commands

    def _follow_commands(self) -> None:
        """Do what a signature asks for that was written just now."""
        for entry, signature, follow in self._commands:
            if entry.value == signature:
                entry.value = ON_COMMAND
                follow()

    def save(self) -> None:
        """Store all values: a reset leads to them from now on."""
        self.power_on = self.present()

    def load_defaults(self) -> None:
        """Forget what was stored: the next reset leads to the defaults."""
        self.power_on = self.defaults

    def save_part(self, *, in_area: bool) -> None:
        """Store the values of the communication, or those of the application."""
        self.power_on = self._joined(self.present(), in_area=in_area)

    def load_part(self, *, in_area: bool) -> None:
        """Forget what was stored of the communication, or of the application."""
        self.power_on = self._joined(self.defaults, in_area=in_area)

    def _joined(self, part: Values, *, in_area: bool) -> Values:
        """Return the part of some values, and otherwise what is stored."""
        kept = [place for place in self.power_on if place[1] is not in_area]
        return [place for place in part if place[1] is in_area] + kept

    # Time

    @property
    def wake_at(self) -> float | None:
        """When ``advance`` has to be called at the latest; None as long as nothing is due."""
        if self.server_timeout is None:
            return self._heartbeat_due
        due = [channel.deadline for channel in self.channels if channel.deadline is not None]
        if self._heartbeat_due is not None:
            due.append(self._heartbeat_due)
        return min(due, default=None)

    def advance(self, now: float) -> list[CanFrame]:
        """Let it be ``now`` (seconds, never less than before); return what was due by then."""
        self.now = now
        frames: list[CanFrame] = []
        if self.server_timeout is not None:
            for channel in self.channels:
                if channel.deadline is not None and now >= channel.deadline:
                    channel.deadline = None
                    frames += self.answers(channel, channel.server.expire())
        if self._heartbeat_due is not None and now >= self._heartbeat_due:
            # Heartbeats for which the node was woken too late are left out, not made up for.
            missed = (now - self._heartbeat_due) // self._heartbeat_period
            self._heartbeat_due += (missed + 1) * self._heartbeat_period
            frames.append(self.heartbeat())
        return frames

    def heartbeat(self) -> CanFrame:
        """Tell the state."""
        return error_control(self.node_id, self.state)

    def heartbeat_seconds(self) -> float:
        """Return the time between heartbeats as 1017h has it; 0 for none."""
        return int.from_bytes(self.heartbeat_time.value, "little") / 1000

    def _set_heartbeat(self) -> None:
        period = self.heartbeat_seconds()
        if period != self._heartbeat_period:
            self._heartbeat_period = period
            self._heartbeat_due = self.now + period if period else None

    # Network management

    def start(self) -> list[CanFrame]:
        """Initialise; return what the node sends on its own then: the boot-up message."""
        self.state = NmtState.INITIALISING
        for channel in self.channels:
            channel.forget()
        boot_up = self.heartbeat()
        self.state = NmtState.PRE_OPERATIONAL
        self._heartbeat_period = 0.0
        self._heartbeat_due = None
        self._set_heartbeat()
        self.errors.forget()
        return [boot_up, *self.emergencies()]

    def on_nmt(self, frame: CanFrame) -> list[CanFrame]:
        """Follow a command to this node, or to all."""
        message = decode_nmt(frame)
        if message is None or message.node_id not in (ALL_NODES, self.node_id):
            return []
        return self.follow(message.command)

    def follow(self, command: NmtCommand) -> list[CanFrame]:
        """Enter the state to which a command leads."""
        state = TRANSITIONS[command]
        if state is NmtState.INITIALISING:
            self.restore(communication_only=command is NmtCommand.RESET_COMMUNICATION)
            return self.start()
        self.state = state
        if not state.serves_sdo:
            for channel in self.channels:
                channel.forget()
        return []

    def restore(self, *, communication_only: bool) -> None:
        """Give objects their power-on values: those at 1000h to 1FFFh, or all (7.3.2.2.1)."""
        for entry, in_area, value in self.power_on:
            if in_area or not communication_only:
                entry.value = value

    def emergencies(self) -> list[CanFrame]:
        """Tell of an error of the application, or that there is none any more, but only once."""
        code = self.errors.update()
        return [] if code is None else [emergency(self.node_id, code, register_of(code))]

    # SDO

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        """Take one frame from the bus; return the frames that answer it."""
        if frame.can_id == NMT_ID:
            return self.on_nmt(frame)
        if not self.state.serves_sdo:
            return []
        channel = self.channel_of(frame)
        if channel is None:
            return []
        frames = self.answers(channel, self.serve(channel, frame))
        if self.server_timeout is not None:
            running = channel.server.transfer is not None
            channel.deadline = self.now + self.server_timeout if running else None
        if not frames or channel.server.transfer is not None:
            return frames  # nothing was written: what is, is answered, and ends the transfer
        self._set_heartbeat()
        self._follow_commands()
        return frames + self.emergencies()

    def channel_of(self, frame: CanFrame) -> ServerChannel | None:
        """Return the channel on which a frame is a request."""
        if self.is_addressed(frame):
            return self.channels[0]
        return next((other for other in self.channels[1:] if self.is_on(other, frame)), None)

    def is_addressed(self, frame: CanFrame) -> bool:
        """Say whether a frame is a request on the default channel."""
        return frame.can_id == self.request_id and not frame.extended and not frame.remote

    def is_on(self, channel: ServerChannel, frame: CanFrame) -> bool:
        """Say whether a frame is a request on a further channel."""
        return channel.record.is_valid and channel.record.request.matches(frame)

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Let the server of a channel react."""
        return channel.server.receive(frame.data)

    def answers(self, channel: ServerChannel, responses: list[bytes]) -> list[CanFrame]:
        """Put responses into frames of their channel."""
        if channel is self.channels[0]:
            return [self.respond(data) for data in responses]
        return [self.respond_on(channel, data) for data in responses]

    def respond(self, data: bytes) -> CanFrame:
        """Put the data bytes of a response on the default channel into a frame."""
        return CanFrame(self.response_id, data)

    def respond_on(self, channel: ServerChannel, data: bytes) -> CanFrame:
        """Put the data bytes of a response on a further channel into a frame."""
        return channel.record.response.frame(data)

    # What may be written to the records of further channels (CiA 301, 7.5.2.33)

    def check_cob_id(self, old: bytes, new: bytes) -> None:
        """Refuse a COB-ID that a channel cannot have, or not now."""
        before, wanted = CobId.from_bytes(old), CobId.from_bytes(new)
        self.check_format(wanted)
        self.check_in_use(before, wanted)
        self.check_restricted(wanted)

    def check_format(self, wanted: CobId) -> None:
        """Refuse bits 28 to 11 of an 11-bit identifier."""
        if wanted.has_stray_bits:
            raise Refusal(AbortCode.VALUE_INVALID)

    def check_in_use(self, before: CobId, wanted: CobId) -> None:
        """Refuse another identifier as long as the old one is in use: it must be disabled first."""
        moved = (before.can_id, before.extended) != (wanted.can_id, wanted.extended)
        if before.valid and moved:
            raise Refusal(AbortCode.VALUE_INVALID)

    def check_restricted(self, wanted: CobId) -> None:
        """Refuse to use an identifier that belongs to another service."""
        if wanted.valid and wanted.is_restricted:
            raise Refusal(AbortCode.VALUE_INVALID)

    def check_client(self, old: bytes, new: bytes) -> None:
        """Refuse what is no node-ID."""
        if not 1 <= new[0] <= HIGHEST_NODE_ID:
            raise Refusal(AbortCode.VALUE_INVALID)


def _nothing() -> None:
    """Store or load nothing: the command is about parameters of which the node has none."""
