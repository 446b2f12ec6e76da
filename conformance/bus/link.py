"""One python-can bus: frames out, frames in, each captured with its direction and time."""

import time
from collections.abc import Callable, Iterable
from enum import StrEnum
from typing import NamedTuple

import can
from can.interfaces.socketcan import SocketcanBus
from can.interfaces.socketcand import SocketCanDaemonBus
from can.interfaces.udp_multicast import UdpMulticastBus
from can.interfaces.virtual import VirtualBus

from conformance.bus.arrivals import arrivals, own_clock, shortest_look
from conformance.bus.deadline import Deadline
from conformance.bus.echoes import UnmarkedEchoes
from conformance.bus.errors import (
    SecondClient,
    TransmitBufferFull,
    buffer_is_full,
    check_error_frame,
    lost,
)
from conformance.bus.messages import to_frame, to_message
from conformance.bus.patience import Patience
from conformance.bus.stop import Stop
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE, RESPONSE_BASE, CobId

SDO_BASES = (RESPONSE_BASE, REQUEST_BASE)
SEND_LIMIT = 1.0
RETRY_PAUSE = 0.002


class Direction(StrEnum):
    """Who sent a frame: the suite, or another node on the bus."""

    SENT = "sent"
    RECEIVED = "received"


class Captured(NamedTuple):
    """A frame with the time at which this process sent or received it, in seconds since 1970."""

    timestamp: float
    direction: Direction
    frame: CanFrame


class Link:
    """A bus in use. Listeners are handed every frame, in order, receivers what others sent."""

    def __init__(self, bus: can.BusABC, name: str, stop: Stop | None = None) -> None:
        """``name`` is what error messages call the bus; ``stop`` is looked at between frames."""
        self.name = name
        self.stop = stop or Stop()
        # Looks, in a silence, whether the bus is still reached; raises InterfaceLost.
        self.check: Callable[[], None] = lambda: None
        self._bus = bus
        self._own_clock = own_clock(bus)
        self._listeners: list[Callable[[Captured], None]] = []
        self._receivers: list[Callable[[CanFrame], None]] = []
        # When the frame that was received last arrived, by the clock ``now``, in seconds.
        self.arrived = 0.0
        self._arrival = arrivals(bus)
        self._shortest_look = shortest_look(bus)
        # SocketCAN marks frames of all processes on this machine as not received, and echoes
        # none of ours unless it was asked to.
        # python-can would send a remote frame to socketcand as a data frame that lacks its data.
        self.sends_remote_frames = not isinstance(bus, SocketCanDaemonBus)
        # Within one process no frame is lost, repeated or swapped.
        self.may_lose = not (isinstance(bus, VirtualBus) or getattr(bus, "loses_nothing", False))
        self._marks_echoes = not isinstance(bus, SocketcanBus)
        self._unmarked = UnmarkedEchoes() if isinstance(bus, UdpMulticastBus) else None

    def now(self) -> float:
        """Tell the time in seconds: that of the bus, or the monotonic one of the machine."""
        return time.monotonic() if self._own_clock is None else self._own_clock()

    def patience(self, seconds: float, *, plain: bool = False) -> Patience:
        """Begin a wait for frames."""
        return Patience(seconds, plain=plain, now=self._own_clock)

    def deadline(self, seconds: float) -> Deadline:
        """Return an end some seconds from now, which no frame moves."""
        return Deadline(seconds, self.now)

    def listen(self, listener: Callable[[Captured], None]) -> None:
        """Hand every frame from now on to ``listener``."""
        self._listeners.append(listener)

    def ignore(self, listener: Callable[[Captured], None]) -> None:
        """Hand no more frames to a listener."""
        self._listeners.remove(listener)

    def add_receiver(self, receiver: Callable[[CanFrame], None]) -> None:
        """Hand the frames of other nodes to ``receiver``, before any listener has them."""
        self._receivers.append(receiver)

    def remove_receiver(self, receiver: Callable[[CanFrame], None]) -> None:
        """Hand no more frames to a receiver."""
        self._receivers.remove(receiver)

    def send(self, frame: CanFrame) -> None:
        """Send one frame; raises TransmitBufferFull or InterfaceLost, or RunStopped instead."""
        message = to_message(frame)
        self.stop.enter()
        try:
            self._send(message, frame)
        finally:
            self.stop.leave()

    def _send(self, message: can.Message, frame: CanFrame) -> None:
        if self._unmarked is not None:
            self._unmarked.sent(frame)
        deadline: float | None = None
        while True:
            try:
                self._bus.send(message, timeout=SEND_LIMIT)
                break
            except (can.CanError, OSError) as error:
                if not buffer_is_full(error):
                    raise lost(self.name, error) from error
                now = time.monotonic()
                deadline = deadline or now + SEND_LIMIT
                if now > deadline:
                    raise TransmitBufferFull(
                        f"{self.name} did not take a frame for {SEND_LIMIT:g} s: its transmit "
                        "buffer is full. Is another node on the bus to acknowledge frames, at the "
                        "same bit rate? A longer queue helps against bursts (SocketCAN: "
                        "'ip link set can0 txqueuelen 1000')."
                    ) from error
                # The kernel has no event for room in the queue of the network device.
                time.sleep(RETRY_PAUSE)
        if self._listeners:
            self._publish(Direction.SENT, frame)

    def receive(self, timeout: float) -> CanFrame | None:
        """Return the next frame of another node within ``timeout`` seconds, or None.

        Raises InterfaceLost, BusOff or FramesDropped, or RunStopped instead.
        """
        return self.receive_with(self.patience(timeout))

    def receive_with(self, patience: Patience) -> CanFrame | None:
        """Return the next frame of another node while a wait lasts, or None.

        Raises what ``receive`` raises.
        """
        while not patience.over:
            message = self._next(patience.look(self._shortest_look))
            frame = None if message is None else self._passed_on(message)
            if frame is not None:
                return frame
            patience.looked(silent=message is None)
        return None

    def look(self, most: int = 1) -> list[CanFrame]:
        """Return the frames of other nodes that have arrived, without waiting.

        It looks at so many frames at the most: what it passes over, the next look may find. Raises
        as ``receive`` does.
        """
        passed_on = [self._passed_on(message) for message in self._arrived(most)]
        return [frame for frame in passed_on if frame is not None]

    def _arrived(self, most: int) -> list[can.Message]:
        messages = list[can.Message]()
        self.stop.enter()
        try:
            while len(messages) < most:
                message = self._bus.recv(0.0)
                if message is None:
                    break
                messages.append(message)
        except (can.CanError, OSError) as error:
            raise lost(self.name, error) from error
        finally:
            self.stop.leave()
        return messages

    def _next(self, timeout: float) -> can.Message | None:
        self.stop.enter()
        try:
            return self._bus.recv(timeout)
        except (can.CanError, OSError) as error:
            raise lost(self.name, error) from error
        finally:
            self.stop.leave()

    def _passed_on(self, message: can.Message) -> CanFrame | None:
        """Hand a frame of another node to all that want it, and return it."""
        if message.is_error_frame:
            check_error_frame(self.name, message)
        elif message.is_rx or not self._marks_echoes:
            frame = to_frame(message)
            if self._unmarked is None or not self._unmarked.is_echo(frame):
                self.arrived = self._arrival(message)
                for receiver in self._receivers:
                    receiver(frame)
                if self._listeners:
                    self._publish(Direction.RECEIVED, frame)
                return frame
        return None

    def watch(
        self,
        node_ids: list[int],
        can_ids: Iterable[int] = (),
        neighbours: frozenset[int] = frozenset(),
    ) -> None:
        """Let the interface pass only what the run may need, in the kernel where it can.

        That is SDO traffic of all nodes, NMT and error control, everything else that these nodes
        send by default, 11-bit frames with these CAN-IDs, and all 29-bit frames: an answer on a
        wrong identifier must be seen. Not the SDO traffic of ``neighbours``, which another process
        tests meanwhile. On the virtual bus, within this process, there are no others.
        """
        if isinstance(self._bus, VirtualBus):
            return
        filters: list[can.typechecking.CanFilter] = [
            {"can_id": base, "can_mask": 0x780, "extended": False} for base in (0x000, 0x700)
        ]
        if neighbours:
            filters += [
                {"can_id": base + node_id, "can_mask": 0x7FF, "extended": False}
                for base in SDO_BASES
                for node_id in range(0x80)
                if node_id not in neighbours
            ]
        else:
            filters += [
                {"can_id": base, "can_mask": 0x780, "extended": False} for base in SDO_BASES
            ]
        filters += [
            {"can_id": node_id, "can_mask": 0x07F, "extended": False} for node_id in node_ids
        ]
        filters += [{"can_id": can_id, "can_mask": 0x7FF, "extended": False} for can_id in can_ids]
        filters.append({"can_id": 0, "can_mask": 0, "extended": True})
        self._bus.set_filters(filters)

    def close(self) -> None:
        """Close the bus."""
        self._bus.shutdown()

    def _publish(self, direction: Direction, frame: CanFrame) -> None:
        # What is waited for on a bus with a clock of its own takes no time, and has passed.
        waited = 0.0 if self._own_clock is None else self._own_clock()
        captured = Captured(time.time() + waited, direction, frame)
        for listener in self._listeners:
            listener(captured)


def second_client(request: CobId) -> SecondClient:
    """Describe a frame on our own request identifier that we did not send."""
    return SecondClient(
        f"Another node sends SDO requests on {request} while the suite does: the device's "
        "answers cannot be told apart. Stop the other client (a configuration tool, a PLC)."
    )
