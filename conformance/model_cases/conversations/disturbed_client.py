"""An ordinary client, disturbed as a conversation says: a generator of frames, without a bus.

It yields what is to be done and is sent what was heard of it; ``drive`` lets a function do it, on a
bus or on none. The client only decides how to go on: where a response is wrong, it ends the
transfer with an abort, as any client would. Its driver judges the responses.
"""

from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from itertools import chain, repeat
from typing import Protocol

from conformance.model_cases.conversations.conversation import (
    Conversation,
    Disturbance,
    Event,
    Service,
    Transfer,
)
from conformance.model_cases.matrix.stimuli import STIMULI, SUB_BLOCK_STIMULI, Targets
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import BlockClient, Burst, Step
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ResponseChecks, ServerAborted
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.frames import Abort, BlockSegment, Request, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Violation

# What befalls segments on a bus, and a server has to put up with.
ON_THE_BUS = (Event.LOSE, Event.REPEAT, Event.LATE)
UPLOADS = (Service.UPLOAD, Service.BLOCK_UPLOAD)
FRAMES = {**STIMULI, **SUB_BLOCK_STIMULI}


@dataclass(frozen=True, slots=True)
class Send:
    """Send a frame, and hear what answers it.

    A server that has left its sub-block is sent nothing more ``in_sub_block``. ``odd`` says that
    more befell the transfer so far than frames that were lost, repeated or late.
    """

    frame: CanFrame
    in_sub_block: bool
    odd: bool


@dataclass(frozen=True, slots=True)
class Listen:
    """Hear what may come behind a gap in a sub-block."""


@dataclass(frozen=True, slots=True)
class Settle:
    """Abort what may be open, of an object, and make sure that nothing more comes.

    ``aborted`` says that the server has aborted: one that is certainly idle needs no abort.
    """

    target: Multiplexer
    aborted: bool = False


Action = Send | Listen | Settle


class Then(Enum):
    """How to go on behind an action."""

    GO_ON = auto()
    LEFT = auto()
    """The server has left the sub-block: the rest of it is not sent."""
    ENOUGH = auto()
    """Too much went out that need not be answered: the transfer ends here."""


@dataclass(frozen=True, slots=True)
class Heard:
    """What came of an action: the answers, and how to go on."""

    answers: Sequence[Response] = ()
    then: Then = Then.GO_ON


Actions = Generator[Action, Heard, None]


class Objects(Protocol):
    """What conversations are about."""

    @property
    def targets(self) -> Targets:
        """The objects that frames name which are inserted."""

    @property
    def rooms(self) -> Mapping[Multiplexer, int]:
        """How many bytes each string and domain takes; uploads read what is written before."""

    @property
    def numbers(self) -> Sequence[Multiplexer]:
        """The writable objects whose values have one length."""

    @property
    def readable(self) -> Sequence[Multiplexer]:
        """What can be read, and what the device does not have."""

    def data(self, transfer: Transfer) -> bytes:
        """Return what a download writes."""

    def harmless(self, data: bytes) -> bytes:
        """Return a request that, whatever a device takes it for, writes where it may."""

    def longest(self, mux: Multiplexer) -> int:
        """Return the most bytes that an upload of an object may bring."""


def conversing(conversation: Conversation, objects: Objects) -> Actions:
    """Perform all transfers, then read back what they were about."""
    client = DisturbedClient(objects)
    for transfer in conversation:
        yield from client.perform(transfer)
    own = objects.targets.own
    yield Settle(conversation[-1].target if conversation else own)
    for mux in dict.fromkeys([*(transfer.target for transfer in conversation), own]):
        yield from client.perform(Transfer(Service.UPLOAD, mux))


def drive(actions: Actions, do: Callable[[Action], Heard]) -> None:
    """Let a conversation go on until it is over; ``do`` does what it asks for."""
    heard: Heard | None = None
    while True:
        try:
            action = next(actions) if heard is None else actions.send(heard)
        except StopIteration:
            return
        heard = do(action)


class DisturbedClient:
    """A client to whose requests happens what a transfer says."""

    def __init__(self, objects: Objects) -> None:
        """Take the objects that transfers may be about."""
        self._objects = objects
        self._client = BlockClient(ResponseChecks(lambda violation: None), objects.longest)

    def perform(self, transfer: Transfer) -> Actions:
        """Perform one transfer as far as it goes; write first what an upload is to read."""
        if transfer.service in UPLOADS and transfer.size and transfer.target in self._objects.rooms:
            value = Transfer(Service.DOWNLOAD, transfer.target, transfer.size, transfer.content)
            yield from self.perform(value)
        steps = self._steps(transfer)
        step = next(steps)
        responses: deque[Response] = deque()
        sent = 0
        while True:
            burst = step if isinstance(step, Burst) else Burst((step,))
            if burst.requests:
                responses.clear()
                frames, gone = self._disturbed(transfer, burst.requests, sent)
                sent += len(burst.requests)
                odd = any(
                    found.event not in ON_THE_BUS and found.at < sent
                    for found in transfer.disturbances
                )
                in_sub_block = isinstance(burst.requests[0], BlockSegment)
                for frame in frames:
                    heard = yield Send(frame, in_sub_block, odd)
                    responses += heard.answers
                    if heard.then is Then.LEFT:
                        break
                    if heard.then is Then.ENOUGH:
                        yield Settle(transfer.target)
                        return
                if gone:
                    return
            if burst.awaited and not responses:
                heard = yield Listen()
                responses += heard.answers
            try:
                if burst.awaited and not responses:
                    break
                step = steps.send(responses.popleft()) if burst.awaited else next(steps)
            except StopIteration:
                return
            except ServerAborted:
                yield Settle(transfer.target, aborted=True)
                return
            except Violation:
                break
        yield Settle(transfer.target)

    def _steps(self, transfer: Transfer) -> Generator[Step, Response, object]:
        client, mux = self._client, transfer.target
        match transfer.service:
            case Service.UPLOAD:
                return client.upload(mux)
            case Service.BLOCK_UPLOAD:
                first, *others = transfer.block_sizes
                return client.block_upload(
                    mux,
                    block_size=first,
                    threshold=transfer.threshold,
                    crc=transfer.crc,
                    acknowledge=_acknowledging(transfer.withheld),
                    next_block_size=_in_turn(others),
                )
        data, sized = self._objects.data(transfer), transfer.sized
        if transfer.service is Service.BLOCK_DOWNLOAD:
            return client.block_download(mux, data, sized=sized, crc=transfer.crc)
        segmented = transfer.service is Service.DOWNLOAD or not 1 <= len(data) <= 4
        return client.download(mux, data, segmented=segmented, sized=sized)

    def _disturbed(
        self, transfer: Transfer, requests: Sequence[Request], first: int
    ) -> tuple[list[CanFrame], bool]:
        """Return the frames that are sent for some requests, and whether the client is gone."""
        frames: list[CanFrame] = []
        late: list[CanFrame] = []
        for number, request in enumerate(requests, first):
            sent = [request.encode()]
            held_back, late = late, []
            for disturbance in transfer.disturbances:
                if disturbance.at != number:
                    continue
                match disturbance.event:
                    case Event.ABORT:
                        abort = self._frame(_abort(transfer.target))
                        return [*frames, *held_back, abort], True
                    case Event.LEAVE:
                        return [*frames, *held_back], True
                    case Event.LATE:
                        late, sent = [self._frame(data) for data in sent], []
                    case Event.INSERT:
                        frames.append(self._inserted(disturbance.label))
                    case _:
                        sent = [data for whole in sent for data in _changed(whole, disturbance)]
            frames += [self._frame(data) for data in sent]
            frames += held_back
        return frames + late, False

    def _inserted(self, label: str) -> CanFrame:
        frame = FRAMES[label](self._objects.targets)
        if frame.remote or frame.extended:
            return frame
        return CanFrame(frame.can_id, self._objects.harmless(frame.data))

    def _frame(self, data: bytes) -> CanFrame:
        return CanFrame(REQUEST_BASE + self._objects.targets.node_id, self._objects.harmless(data))


def _abort(mux: Multiplexer) -> bytes:
    return Abort(mux, AbortCode.GENERAL_ERROR).encode()


def _changed(data: bytes, disturbance: Disturbance) -> list[bytes]:
    match disturbance.event:
        case Event.LOSE:
            return []
        case Event.REPEAT:
            return [data, data]
        case Event.CUT:
            return [data[: disturbance.byte]]
        case Event.ALTER if disturbance.byte < len(data):
            changed = bytearray(data)
            changed[disturbance.byte] ^= disturbance.mask
            return [bytes(changed)]
    return [data]


def _acknowledging(withheld: Sequence[int]) -> Callable[[int], int]:
    """Return what a block upload acknowledges of its sub-blocks in turn, at last everything."""
    missing = chain(withheld, repeat(0))
    return lambda received: max(received - next(missing), 0)


def _in_turn(block_sizes: Sequence[int]) -> Callable[[int], int]:
    """Return the block sizes of a block upload, the last of them for ever."""
    sizes = iter(block_sizes)
    return lambda present: next(sizes, present)
