"""The idle server, and what all states have in common (CiA 301, 7.2.4.2 and 7.2.4.3.17)."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import ClassVar

from conformance.sdo.abort_codes import ACCUSATIONS, OF_UPLOADS
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    Request,
    Unknown,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import FRAME_LENGTH, Multiplexer
from conformance.sdo.oracle.answers import Codes, DueAbort
from conformance.sdo.oracle.branch import Branch, Due, Freedom, quiet
from conformance.sdo.oracle.knowledge import Memory
from conformance.sdo.oracle.short_frames import completed
from conformance.sdo.rules import (
    RESTART,
    Rule,
    Violation,
    freedoms,
    idle,
    short_requests,
    timing,
)
from conformance.sdo.rules import download_initiates as initiates

Initiate = DownloadInitiate | UploadInitiate | BlockDownloadInitiate | BlockUploadInitiate


@singledispatch
def begin(request: Request, memory: Memory) -> list[Branch]:
    """Return all that an idle server may do with a request of 8 bytes without reserved bits.

    The services register what begins with them. Any other frame belongs to a transfer, and there
    is none.
    """
    return _out_of_transfer(idle.OUT_OF_BLOCK, memory)


def _out_of_transfer(rule: Rule, memory: Memory) -> list[Branch]:
    topic = "a frame of a transfer when idle"
    refusal = DueAbort(rule)
    return [
        quiet(IDLE, memory, rule, Freedom(topic, "ignored")),
        refusal.branch(IDLE, IDLE, memory, Freedom(topic, "refused")),
    ]


@begin.register
def _(request: DownloadSegment, memory: Memory) -> list[Branch]:
    del request
    return _out_of_transfer(idle.DOWNLOAD_WITHOUT_INITIATE, memory)


@begin.register
def _(request: UploadSegment, memory: Memory) -> list[Branch]:
    del request
    return _out_of_transfer(idle.UPLOAD_WITHOUT_INITIATE, memory)


@begin.register
def _(request: Unknown, memory: Memory) -> list[Branch]:
    looks_like = DownloadInitiate.decode(request.frame).mux
    return [DueAbort(idle.UNKNOWN_SPECIFIER, looks_like=looks_like).branch(IDLE, IDLE, memory)]


class Answering(ABC):
    """What every state of a server that can be followed does with a request.

    Its own are ``on``, ``on_abort`` and ``pass_time``.
    """

    name: ClassVar[str]

    def decode(self, frame: bytes) -> Request:
        """Read a request of 8 bytes."""
        return decode_request(frame)

    def receive(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Return all that a server may do with the data bytes of a request."""
        if len(frame) != FRAME_LENGTH:
            return self.on_wrong_length(frame, memory)
        request = self.decode(frame)
        if isinstance(request, Abort):
            return self.on_abort(request, memory)
        odd = tuple(oddities(request))
        branches = self.on(plain(request) if odd else request, memory)
        for topic, refusal in odd:
            branches = [branch.choosing(Freedom(topic, "ignored")) for branch in branches]
            branches.append(refusal.branch(self, IDLE, memory, Freedom(topic, "refused")))
        return branches

    @abstractmethod
    def on(self, request: Request, memory: Memory) -> list[Branch]:
        """Return all that a server may do with a request that has no reserved bits or bytes."""

    @abstractmethod
    def on_abort(self, request: Abort, memory: Memory) -> list[Branch]:
        """Return all that a server may do with an abort."""

    @abstractmethod
    def pass_time(self, memory: Memory) -> list[Branch]:
        """Return all that a server may do when its client is silent for long."""

    def on_wrong_length(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Ignore it, refuse it, or serve what has all the bytes that it needs (not defined)."""
        topic = "a frame of a wrong length"
        refusal = DueAbort(short_requests.SHORT)
        branches = [
            quiet(self, memory, short_requests.SHORT, Freedom(topic, "ignored")),
            quiet(IDLE, memory, short_requests.SHORT, Freedom(topic, "ends the transfer")),
            refusal.branch(self, IDLE, memory, Freedom(topic, "refused")),
        ]
        request = completed(self.decode, frame, memory)
        if request is not None and not isinstance(request, Abort):
            served = Freedom(topic, "served")
            branches += [branch.choosing(served) for branch in self.on(plain(request), memory)]
        return branches


@dataclass(frozen=True, slots=True)
class Idle(Answering):
    """No transfer runs."""

    name: ClassVar[str] = "idle"

    def receive(self, frame: bytes, memory: Memory) -> list[Branch]:
        """Take a block frame with reserved bits for an initiate of no valid sub-command, too."""
        if len(frame) == FRAME_LENGTH:
            request = decode_request(frame)
            inner = BlockAck | BlockEnd | BlockEndResponse | BlockUploadStart
            if isinstance(request, inner) and request.reserved_bits:
                return _out_of_transfer(idle.SUB_COMMAND, memory)
        return Answering.receive(self, frame, memory)

    def on(self, request: Request, memory: Memory) -> list[Branch]:
        """Begin what the request begins."""
        return begin(request, memory)

    def on_abort(self, request: Abort, memory: Memory) -> list[Branch]:
        """Keep silent; what an abort with reserved bits is, is open."""
        if not request.reserved_bits:
            return [quiet(IDLE, memory, idle.ABORT_NOT_ANSWERED)]
        return [
            quiet(IDLE, memory, idle.ABORT_RESERVED_BITS),
            DueAbort(idle.ABORT_RESERVED_BITS).branch(IDLE, IDLE, memory),
        ]

    def pass_time(self, memory: Memory) -> list[Branch]:
        """Stay idle."""
        return [quiet(IDLE, memory, timing.SERVER_TIME_OUT)]


IDLE = Idle()


@dataclass(frozen=True, slots=True)
class Running(Answering):
    """A transfer runs.

    ``abort_rule`` says that an abort ends it, ``foreign_rule`` that a frame does which does not
    belong there; ``gives_way``: a server that refuses a new initiate misses a SHOULD.
    ``senseless`` are codes with which no server ends this transfer while its client is right.
    """

    mux: Multiplexer
    abort_rule: ClassVar[Rule]
    foreign_rule: ClassVar[Rule]
    gives_way: ClassVar[bool] = False
    senseless: ClassVar[Codes] = (*ACCUSATIONS, *OF_UPLOADS)

    def on(self, request: Request, memory: Memory) -> list[Branch]:
        """Go on with the transfer, or begin another."""
        if isinstance(request, Initiate):
            return self.restart(request, memory)
        return self.go_on(request, memory)

    def go_on(self, request: Request, memory: Memory) -> list[Branch]:
        """Return what a server may do with a request that is no initiate: states override it."""
        return self.foreign(memory)

    def foreign(self, memory: Memory, rule: Rule | None = None) -> list[Branch]:
        """Refuse a frame that does not belong here, and end the transfer."""
        return [DueAbort(rule or self.foreign_rule).named(self.mux).branch(self, IDLE, memory)]

    def restart(self, request: Initiate, memory: Memory) -> list[Branch]:
        """Serve a new initiate, or refuse it; the running transfer is over in both cases."""
        topic = f"a new initiate in a {self.name}"
        missed: tuple[Violation, ...] = ()
        if self.gives_way:
            expected = f"the transfer of {request.mux} to begin"
            missed = (Violation(RESTART, expected=expected, actual="an abort"),)
        refusal = DueAbort(RESTART, (self.mux, request.mux), findings=missed)
        served = begin(request, memory)
        return [
            *(branch.choosing(Freedom(topic, "served")) for branch in served),
            self._superseded(served, memory).choosing(Freedom(topic, "served behind an abort")),
            refusal.branch(self, IDLE, memory, Freedom(topic, "refused")),
        ]

    def _superseded(self, served: list[Branch], memory: Memory) -> Branch:
        """Abort the running transfer on the bus, and serve the new one all the same."""
        refusal = DueAbort(RESTART, (self.mux,))

        def take(frame: bytes) -> list[Branch]:
            abort = refusal.read(frame)
            return [branch.noting(*refusal.breaches(abort, frame)) for branch in served]

        words = f"an abort of {self.mux}, and then the answer to the new initiate"
        return Branch(self, memory, RESTART, Due(RESTART, words, take))

    def on_abort(self, request: Abort, memory: Memory) -> list[Branch]:
        """End the transfer in silence; whether an odd abort is one, is open."""
        if request.mux == self.mux and not request.reserved_bits:
            return [quiet(IDLE, memory, self.abort_rule)]
        rule = freedoms.FOREIGN_MULTIPLEXER
        topic = "an abort with reserved bits" if request.reserved_bits else "an abort of another"
        return [
            quiet(IDLE, memory, rule, Freedom(topic, "ends the transfer")),
            quiet(self, memory, rule, Freedom(topic, "ignored")),
            DueAbort(rule).branch(self, IDLE, memory, Freedom(topic, "refused")),
        ]

    def pass_time(self, memory: Memory) -> list[Branch]:
        """Wait for ever, or give up."""
        refusal = DueAbort(timing.SERVER_TIME_OUT, (self.mux,))
        return [
            quiet(self, memory, timing.SERVER_TIME_OUT),
            refusal.branch(self, IDLE, memory, Freedom("server time-out", "aborts")),
        ]


def plain(request: Request) -> Request:
    """Return a request without what a server may ignore: reserved bits and bytes, a vain n."""
    match request:
        case DownloadSegment() | BlockSegment() | Abort() | Unknown():
            return request
        case DownloadInitiate():
            unused = 0 if _vain_count(request) else request.unused
            payload = bytes(4) if _reserved_bytes(request) else request.payload
            return replace(request, reserved_bits=0, unused=unused, payload=payload)
        case BlockDownloadInitiate():
            payload = bytes(4) if _reserved_bytes(request) else request.payload
            return replace(request, reserved_bits=0, payload=payload)
        case _:
            return replace(request, reserved_bits=0, reserved=bytes(len(request.reserved)))


def _vain_count(request: Request) -> bool:
    """Say whether n is not 0 where it has no meaning."""
    if not isinstance(request, DownloadInitiate):
        return False
    return bool(request.unused) and not (request.expedited and request.sized)


def _reserved_bits(request: Request) -> int:
    match request:
        case DownloadSegment() | BlockSegment() | Unknown():
            return 0
        case _:
            return request.reserved_bits


def _reserved_bytes(request: Request) -> bytes:
    """Return the bytes that carry nothing; in an initiate that is where no size or data are."""
    match request:
        case DownloadInitiate(expedited=False, sized=False) | BlockDownloadInitiate(sized=False):
            return request.payload
        case DownloadInitiate() | BlockDownloadInitiate():
            return b""
        case DownloadSegment() | BlockSegment() | Abort() | Unknown():
            return b""
        case _:
            return request.reserved


def oddities(request: Request) -> Iterable[tuple[str, DueAbort]]:
    """Yield the refusals that reserved bits and bytes of a request allow."""
    if _reserved_bits(request):
        yield "reserved bits in a request", DueAbort(freedoms.RESERVED_BITS)
    if any(_reserved_bytes(request)):
        yield "reserved bytes in a request", DueAbort(freedoms.RESERVED_BYTES)
    if _vain_count(request):
        yield "n where it has no meaning", DueAbort(initiates.UNUSED_WITHOUT_SIZE)
