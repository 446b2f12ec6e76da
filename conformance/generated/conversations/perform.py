"""Performs a conversation: an ordinary client, disturbed as the conversation says.

The oracle judges each response. The client only decides how to go on: what it finds wrong with a
response, it takes as any client would, and ends the transfer with an abort.
"""

from collections import deque
from collections.abc import Callable, Generator, Sequence
from itertools import chain, repeat

from conformance.bus.errors import WriteNotPermitted
from conformance.dialogue.dialogue import Dialogue
from conformance.generated.conversations.ground import Ground
from conformance.generated.conversations.transfers import (
    Conversation,
    Disturbance,
    Event,
    Service,
    Transfer,
)
from conformance.generated.lockstep import Lockstep
from conformance.generated.matrix.stimuli import STIMULI, SUB_BLOCK_STIMULI
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import BlockClient, Burst, Step
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.checks import ResponseChecks, ServerAborted
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.frames import Abort, BlockSegment, Request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle import Awaited, Oracle
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.rules import NO_REBOOT, Violation

# One more request before an answer is a fair question to a server; many of them are a flood.
MOST_DOUBTFUL = 2
# What befalls segments on a bus, and a server has to put up with.
ON_THE_BUS = (Event.LOSE, Event.REPEAT, Event.LATE)
UPLOADS = (Service.UPLOAD, Service.BLOCK_UPLOAD)
FRAMES = {**STIMULI, **SUB_BLOCK_STIMULI}


def converse(conversation: Conversation, ground: Ground, sdo: Dialogue) -> None:
    """Perform all transfers, then read back what they were about.

    Raises Violation for the first response that fails a device, or when it boots on the way.
    """
    boot_ups = sdo.channel.boot_ups
    oracle = Oracle(ground.knowledge(), sdo.device.node_id)
    ground.values.clear()  # until this conversation has ended well
    lockstep = Lockstep(sdo, oracle)
    with lockstep.following():
        client = _Client(lockstep, ground)
        for transfer in conversation:
            client.perform(transfer)
        lockstep.settle(conversation[-1].target if conversation else ground.targets.own)
        for mux in dict.fromkeys(
            [*(transfer.target for transfer in conversation), ground.targets.own]
        ):
            client.perform(Transfer(Service.UPLOAD, mux))
    if sdo.channel.boot_ups > boot_ups:
        raise Violation(NO_REBOOT, expected="no boot-up message", actual="the device booted")
    ground.remember(oracle.values)


class _Client:
    """Performs transfers one after another."""

    def __init__(self, lockstep: Lockstep, ground: Ground) -> None:
        self._lockstep = lockstep
        self._ground = ground
        self._doubtful = 0
        self._client = BlockClient(ResponseChecks(lambda violation: None), ground.device.longest)

    def perform(self, transfer: Transfer) -> None:
        """Perform one transfer as far as it goes; write first what an upload is to read."""
        if transfer.service in UPLOADS and transfer.size and transfer.target in self._ground.rooms:
            value = Transfer(Service.DOWNLOAD, transfer.target, transfer.size, transfer.content)
            self.perform(value)
        steps = self._steps(transfer)
        step = next(steps)
        responses: deque[bytes] = deque()
        sent = 0
        while True:
            burst = step if isinstance(step, Burst) else Burst((step,))
            if burst.requests:
                responses.clear()
                in_sub_block = isinstance(burst.requests[0], BlockSegment)
                frames, gone = self._disturbed(transfer, burst.requests, sent)
                sent += len(burst.requests)
                odd = any(
                    found.event not in ON_THE_BUS and found.at < sent
                    for found in transfer.disturbances
                )
                for frame in frames:
                    if in_sub_block and self._lockstep.has_left():
                        responses += self._lockstep.arrived()
                        break
                    try:
                        responses += self._lockstep.send(frame)
                    except WriteNotPermitted:
                        continue  # it was meant as a segment, and would be a request here
                    if self._floods(odd):
                        return self._lockstep.settle(transfer.target)
                if gone:
                    return None
            if burst.awaited and not responses:
                responses += self._lockstep.behind_gap()
            try:
                if burst.awaited and not responses:
                    break
                step = steps.send(responses.popleft()) if burst.awaited else next(steps)
            except StopIteration:
                return None
            except ServerAborted:
                # What was on its way then may be answered yet: nothing is, where that is certain.
                if self._lockstep.oracle.idle:
                    return None
                break
            except Violation:
                break
        return self._lockstep.settle(transfer.target)

    def _floods(self, odd: bool) -> bool:
        """Say whether too many frames went out while an answer may come and need not.

        A sub-block of which segments get lost is sent as it is: only its end has to be answered.
        """
        oracle = self._lockstep.oracle
        lossy = not odd and oracle.states == {SubBlock.name}
        clear = oracle.awaited is not Awaited.MAYBE or lossy
        self._doubtful = 0 if clear else self._doubtful + 1
        return self._doubtful > MOST_DOUBTFUL

    def _steps(self, transfer: Transfer) -> Generator[Step, bytes, object]:
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
        data, sized = self._ground.data(transfer), transfer.sized
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
                        return [*frames, *held_back, self._frame(_abort(transfer.target))], True
                    case Event.LEAVE:
                        return [*frames, *held_back], True
                    case Event.LATE:
                        late, sent = [self._frame(data) for data in sent], []
                    case Event.INSERT:
                        inserted = self._inserted(disturbance.label)
                        frames += [inserted] if self._lockstep.may_ask(inserted) else []
                    case _:
                        sent = [data for whole in sent for data in _changed(whole, disturbance)]
            frames += [self._frame(data) for data in sent]
            frames += held_back
        return frames + late, False

    def _inserted(self, label: str) -> CanFrame:
        frame = FRAMES[label](self._ground.targets)
        if frame.remote or frame.extended:
            return frame
        return CanFrame(frame.can_id, self._ground.harmless(frame.data))

    def _frame(self, data: bytes) -> CanFrame:
        return CanFrame(REQUEST_BASE + self._ground.targets.node_id, self._ground.harmless(data))


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
