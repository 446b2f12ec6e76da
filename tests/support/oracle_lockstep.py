"""A server and the oracle in lockstep, without a bus."""

from dataclasses import dataclass, field

from conformance.faults.registry import About, Deviation, assemble
from conformance.model_cases.conversations.conversation import Transfer
from conformance.model_cases.conversations.disturbed_client import (
    Action,
    DisturbedClient,
    Heard,
    Send,
    Settle,
    Then,
    drive,
)
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort, Response
from conformance.sdo.objects import AS_WRITTEN, Access, DataType, Entry, Habits, ObjectDictionary
from conformance.sdo.oracle import Facts, Knowledge, Oracle, Presence
from conformance.sdo.rules import Violation
from support.oracle_objects import NODE_ID, REFERENCE
from support.oracle_sequences import Script, Silence


def facts_of(entry: Entry, *, roomy: bool, habits: Habits = AS_WRITTEN) -> Facts:
    is_text = entry.data_type is DataType.VISIBLE_STRING and entry.access.writable
    return Facts(
        Presence.PRESENT,
        entry.access,
        entry.data_type,
        entry.value,
        steady=entry.access is not Access.WO,
        low=entry.low,
        high=entry.high,
        any_value=True,
        capacity=entry.capacity if roomy else None,
        habits=habits if is_text else AS_WRITTEN,
    )


def started(node: Node) -> Node:
    """Let a node begin to serve."""
    node.advance(0.0)
    node.start()
    return node


def reference_node() -> Node:
    return started(
        assemble(Node, Server, NODE_ID, ObjectDictionary(reference_entries(NODE_ID)), None)
    )


def known_entries(
    node: Node | None = None, *, roomy: bool = True, habits: Habits = AS_WRITTEN
) -> Knowledge:
    """Tell what is known of a device; ``roomy``: how long its strings may get, too.

    Texts that may be written have the ``habits``.
    """
    entries = (node or reference_node()).objects.items()
    return Knowledge.complete(
        {mux: facts_of(entry, roomy=roomy, habits=habits) for mux, entry in entries}
    )


def of_the_protocol(
    deviations: list[Deviation], about: tuple[About, ...] = (About.TRANSFERS,)
) -> list[str]:
    """Return the names of those that differ in what the oracle follows: one channel's transfers.

    It knows nothing of other channels, of NMT, of clocks, and little of the object dictionary.
    """
    return [found.name for found in deviations if found.about in about and not found.timed]


@dataclass
class Lockstep:
    """Sends requests to a node and shows the oracle what comes of them."""

    node: Node = field(default_factory=lambda: reference_node())
    oracle: Oracle = field(default_factory=lambda: Oracle(known_entries(), NODE_ID))
    log: list[str] = field(default_factory=list)
    found: list[Violation] = field(default_factory=list)
    answers: list[bytes] = field(default_factory=list)

    def send(self, request: bytes | CanFrame) -> list[Violation]:
        """Send a request and judge all that comes back, until nothing more does."""
        frame = CanFrame(0x600 + NODE_ID, request) if isinstance(request, bytes) else request
        self.oracle.request(frame)
        self.log.append(f"> {frame}")
        return self._judge(self.node.receive(frame))

    def play(self, script: Script) -> list[Violation]:
        """Play a script to its end, whatever the server does; return all that was found."""
        client = DisturbedClient(REFERENCE)
        for step in script:
            match step:
                case Transfer():
                    drive(client.perform(step), self._do)
                case CanFrame():
                    self.send(step)
                case Silence():
                    self.wait()
        return self.found

    def _do(self, action: Action) -> Heard:
        match action:
            case Send():
                answers = self._ask(action.frame)
                left = action.in_sub_block and any(isinstance(one, Abort) for one in answers)
                return Heard(answers, Then.LEFT if left else Then.GO_ON)
            case Settle() if not (action.aborted and self.oracle.idle):
                self.send(Abort(action.target, AbortCode.GENERAL_ERROR).encode())
        return Heard()

    def _ask(self, request: CanFrame) -> list[Response]:
        start = len(self.answers)
        self.send(request)
        return [decode_response(answer) for answer in self.answers[start:]]

    def wait(self) -> list[Violation]:
        """Let the server's time-out pass."""
        found = self.oracle.silence()
        self.log.append("> ...")
        expired = self.node.server.expire()
        return found + self._judge([self.node.respond(data) for data in expired])

    def _judge(self, answers: list[CanFrame]) -> list[Violation]:
        found = []
        for answer in answers:
            self.log.append(f"< {answer}")
            self.answers.append(answer.data)
            found += self.oracle.response(answer)
        found += self.oracle.settled()
        self.found += found
        self.log += [f"  {violation.rule.level} {violation}" for violation in found]
        return found
