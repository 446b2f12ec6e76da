"""Whether a server differs from the reference server at all, by conversations without a bus.

Each script of the oracle's is played in the settings that a guard asks for: another NMT state, a
further channel, another transfer before. Both servers get the same frames, which the answers of the
server in question decide.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from itertools import chain, islice

from support.oracle_lockstep import started
from support.oracle_objects import NODE_ID, REFERENCE, TEXT, VENDOR_ID
from support.oracle_rejections import remembered
from support.oracle_sequences import Script, Silence, frame, left, scripts, stored

from conformance.faults.catalogue import build_node, find_deviation
from conformance.faults.guarded import guarded
from conformance.faults.guards import FIRST_OF_MANY, Factor, Guard
from conformance.model_cases.conversations.conversation import Service, Transfer
from conformance.model_cases.conversations.disturbed_client import (
    Action,
    DisturbedClient,
    Heard,
    Send,
    Settle,
    Then,
    drive,
)
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import CobId
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort, DownloadInitiate, UploadSegment
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NMT_ID
from conformance.sdo.objects import Entry

# So many scripts of the oracle's are tried, by chance; those that a guard asks for are tried all.
SAMPLE = 500
# So many scripts that show a fault are tried with its guard.
ENOUGH = 60
# What may be written to these lies beyond a check that faulty servers lack.
DELICATE = (0x1201, 0x1202, 0x2140)
LONG = 65_600
FURTHER = 0x1201
REQUEST, RESPONSE = 0x681, 0x682
READ = Transfer(Service.UPLOAD, VENDOR_ID)
START = CanFrame(NMT_ID, bytes([1, NODE_ID]))
FIRST = frame(DownloadInitiate.with_data(Multiplexer(FURTHER, 1), bytes(CobId(REQUEST))))
SECOND = frame(DownloadInitiate.with_data(Multiplexer(FURTHER, 2), bytes(CobId(RESPONSE))))
ABORT = frame(Abort(TEXT, AbortCode.GENERAL_ERROR))
BEFORE: dict[str, Script] = {
    "operational": (START,),
    "further-channel": (FIRST, SECOND),
    "behind-client-abort": (
        left(Transfer(Service.UPLOAD, TEXT), 1),
        frame(Abort(TEXT, AbortCode.GENERAL_ERROR)),
    ),
    "behind-server-abort": (Transfer(Service.UPLOAD, Multiplexer(0x2FFF)),),
    "behind-time-out": (left(Transfer(Service.DOWNLOAD, TEXT, 20), 2), Silence.TIME_OUT),
    "behind-other-service": (Transfer(Service.BLOCK_UPLOAD, TEXT),),
    "behind-stray-segment": (frame(UploadSegment(0)),),
    f"from-{FIRST_OF_MANY}th-transfer": [READ] * (FIRST_OF_MANY - 1),
}


class Duet:
    """Plays scripts to a server, and to the reference server beside it, until they differ."""

    def __init__(self, server: Node, right: Node, *, further: bool) -> None:
        self.servers = (started(server), started(right))
        self.further = further
        self.differs = False

    def play(self, script: Script) -> bool:
        """Return whether the servers answered differently."""
        client = DisturbedClient(REFERENCE)
        for step in script:
            if self.differs:
                break
            match step:
                case Transfer():
                    drive(client.perform(step), self._do)
                case CanFrame():
                    self._ask(step)
                case Silence():
                    self._compare([node.server.expire() for node in self.servers])
        return self.differs

    def _do(self, action: Action) -> Heard:
        if self.differs:
            return Heard((), Then.LEFT)
        match action:
            case Send():
                answers = [decode_response(data) for data in self._ask(action.frame)]
                aborted = any(isinstance(answer, Abort) for answer in answers)
                return Heard(answers, Then.LEFT if action.in_sub_block and aborted else Then.GO_ON)
            case Settle() if not action.aborted:
                self._ask(frame(Abort(action.target, AbortCode.GENERAL_ERROR)))
        return Heard()

    def _ask(self, request: CanFrame) -> list[bytes]:
        if self.further and request.can_id == 0x600 + NODE_ID and request not in (FIRST, SECOND):
            request = CanFrame(REQUEST, request.data)
        answers = [node.receive(request) for node in self.servers]
        self._compare(answers)
        return [answer.data for answer in answers[0]]

    def _compare(self, answers: Sequence[object]) -> None:
        self.differs |= answers[0] != answers[1]


def differs(name: str) -> Script | None:
    """Return a script that shows a faulty server, in the setting that its guard asks for."""
    fault, _, guard = name.partition("@")
    setting = BEFORE.get(guard, ())
    candidates = [*_showing(fault), *_asked_for(guard)] if guard else all_scripts()
    for script in candidates:
        duet = Duet(build_node(name, NODE_ID), build_node(None, NODE_ID), further=FIRST in setting)
        if not duet.play(setting) and duet.play(script):
            return script
    return None


def is_guardable(fault: str) -> bool:
    """Return whether a fault lies in methods alone, so that it is right while no guard holds."""
    found = find_deviation(fault)
    assert found is not None
    never = guarded(found, Guard(Factor.COUNT, "never", "never", lambda _: False))
    for script in _showing(fault):
        node = never.build(NODE_ID, reference_device(NODE_ID))
        if Duet(node, build_node(None, NODE_ID), further=False).play(script):
            return False
    return True


@lru_cache(maxsize=20)
def _showing(fault: str) -> list[Script]:
    """Return the scripts that show a fault without a guard."""
    known = [_of_oracle()[remembered()[fault]]] if fault in remembered() else []
    found = (script for script in chain(known, all_scripts()) if _shown(fault, script))
    return list(islice(found, ENOUGH))


def _shown(fault: str, script: Script) -> bool:
    return Duet(build_node(fault, NODE_ID), build_node(None, NODE_ID), further=False).play(script)


@cache
def _of_oracle() -> list[Script]:
    return list(scripts())


@cache
def all_scripts() -> list[Script]:
    sample = random.Random(1).sample(_of_oracle(), SAMPLE)
    return [*sample, *_each_object(), *_stored()]


def _asked_for(guard: str) -> Iterator[Script]:
    """Yield what takes long, where a guard is about that alone."""
    if guard == "beyond-65535":
        for service in (Service.DOWNLOAD, Service.BLOCK_DOWNLOAD):
            sized = replace(stored(LONG), service=service)
            yield (sized, Transfer(Service.UPLOAD, TEXT), READ)
            yield (replace(sized, sized=False), Transfer(Service.BLOCK_UPLOAD, TEXT))


def _each_object() -> Iterator[Script]:
    """Yield reads and writes of an entry of each kind, right ones and wrong ones."""
    seen = set()
    for mux, entry in build_node(None, NODE_ID).objects.items():
        kind = (entry.data_type, entry.access, entry.low is None, mux.sub_index == 0)
        if kind in seen or mux.index in DELICATE:
            continue
        seen.add(kind)
        read = Transfer(Service.UPLOAD, mux)
        yield (read, Transfer(Service.BLOCK_UPLOAD, mux), READ)
        for data in _values(entry):
            yield (frame(DownloadInitiate.with_data(mux, data)), read)
        for size in {len(entry.value) + 1, len(entry.value), max(len(entry.value) - 1, 1)}:
            for service in (Service.DOWNLOAD, Service.BLOCK_DOWNLOAD):
                for sized in (True, False):
                    yield (Transfer(service, mux, size, sized=sized), read)
                cut = left(Transfer(service, mux, size), 2)
                yield (cut, frame(Abort(mux, AbortCode.GENERAL_ERROR)), read)


def _values(entry: Entry) -> Iterator[bytes]:
    length = entry.data_type.length
    yield from (bytes(size) for size in range(1, 5))
    for limit in (entry.low, entry.high):
        if isinstance(limit, int) and length is not None and length <= 4:
            for value in (limit - 1, limit, limit + 1):
                yield (value % (1 << 8 * length)).to_bytes(length, "little")


def _stored() -> Iterator[Script]:
    """Yield resets behind writes, with the values stored or not."""
    number = Multiplexer(0x2004)
    write = Transfer(Service.EXPEDITED, number, 4, 3)
    read = (Transfer(Service.UPLOAD, number), Transfer(Service.UPLOAD, TEXT))
    for index, signature in ((0x1010, b"save"), (0x1011, b"load")):
        for sub_index in (1, 2, 3):
            command = frame(DownloadInitiate.with_data(Multiplexer(index, sub_index), signature))
            for reset in (129, 130):
                again = CanFrame(NMT_ID, bytes([reset, NODE_ID]))
                yield (write, stored(9), command, again, *read)
                yield (write, stored(9), again, *read)
