"""A server that aborts inside a sub-block is sent no more of it than what is on its way."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from support.run_bench import BASELINE, DOMAIN, NODE_ID, READ, Scripted

from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.device.device import Device
from conformance.device.known_objects import by_multiplexer
from conformance.device.safety import WritePolicy
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.ended_transfers import SEGMENTS_PER_LOOK
from conformance.reference.simulated_bus import SimulatedBus
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, BlockAck, BlockDownloadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import UNSOLICITED, Level, Rule, Violation
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED

RULE = Rule("test.rule", "7.2.4", Level.MUST, "What the case is about.")
ABORT = Abort(DOMAIN.mux, AbortCode.LOCAL_CONTROL)
REFUSED = Abort(Multiplexer(0), AbortCode.COMMAND_NOT_VALID).encode()
CONFIRMED = bytes.fromhex("600A200000000000")
BEGUN = BlockDownloadInitiateResponse(DOMAIN.mux, 127, True).encode()
DATA = bytes(7 * 100)
AT = 5


class Aborting(Scripted):
    """Aborts at a segment and answers those behind it.

    Nothing is heard of that before it has got ``unheard`` of them.
    """

    def __init__(self, behind: bytes, unheard: int = 0) -> None:
        super().__init__(self._answer)
        self.segments = 0
        self._behind = behind
        self._unheard = unheard
        self._held_back: list[bytes] = []

    def _answer(self, data: bytes) -> list[bytes]:
        if data == READ:
            return [BASELINE]
        if data[0] in (0x80, 0xC6):
            return [BEGUN] if data[0] == 0xC6 else []
        self.segments += 1
        if self.segments == AT:
            self._held_back.append(ABORT.encode())
        elif self.segments > AT:
            self._held_back.append(self._behind)
        if self.segments < AT + self._unheard:
            return []
        answers, self._held_back = self._held_back, []
        return answers


@contextmanager
def talking_to(node: Scripted) -> Iterator[Dialogue]:
    """Return a conversation in which every answer is there when a request was sent."""
    link = Link(SimulatedBus([node]), "simulated")
    device = Device(
        NODE_ID,
        by_multiplexer([DOMAIN]),
        baseline=[(READ, BASELINE)],
        policy=WritePolicy([DOMAIN.mux]),
    )
    try:
        yield Dialogue(Channel(link, NODE_ID, 0.1), device, CaseRecord(RULE), seed=1)
    finally:
        link.close()


def test_nothing_follows_an_abort() -> None:
    node = Aborting(REFUSED)
    with talking_to(node) as sdo:
        assert Blocks(sdo).try_download(DOMAIN, DATA) == ABORT
    assert AT <= node.segments < AT + SEGMENTS_PER_LOOK


def test_nothing_follows_an_abort_in_a_script() -> None:
    node = Aborting(REFUSED)
    with talking_to(node) as sdo:
        Blocks(sdo).initiate_download(DOMAIN, len(DATA))
        for first in range(1, 41, 20):
            Blocks(sdo).send_segments([bytes(7)] * 20, first=first)
        sdo.expect_abort(AbortCode.LOCAL_CONTROL, of=DOMAIN)
    assert AT <= node.segments < AT + SEGMENTS_PER_LOOK


@pytest.mark.parametrize("unheard", [0, 10, 60])
def test_what_crosses_with_an_abort_may_be_refused(unheard: int) -> None:
    """Each segment that is on its way is a request to an idle server; then it is asked anew."""
    node = Aborting(REFUSED, unheard)
    with talking_to(node) as sdo:
        assert Blocks(sdo).try_download(DOMAIN, DATA) == ABORT
        sdo.send(READ)
        assert sdo.receive().encode() == BASELINE
        assert sdo.fence() == []
    assert node.requests.count(READ) == 3


def test_what_is_refused_before_the_case_ends() -> None:
    with talking_to(Aborting(REFUSED, 60)) as sdo:
        assert Blocks(sdo).try_download(DOMAIN, DATA) == ABORT
        assert sdo.fence() == []


def test_no_segment_is_confirmed() -> None:
    with talking_to(Aborting(CONFIRMED, 20)) as sdo:
        assert Blocks(sdo).try_download(DOMAIN, DATA) == ABORT
        with pytest.raises(Violation) as raised:
            sdo.send(READ)
    assert raised.value.rule is UNSOLICITED


@pytest.mark.parametrize(
    ("code", "stray"),
    [(AbortCode.LENGTH_TOO_HIGH, [REFUSED]), (AbortCode.LOCAL_CONTROL, [])],
    ids=["for-the-segment", "of-its-own-accord"],
)
def test_an_abort_for_the_one_segment_that_was_sent_has_crossed_with_none(
    code: AbortCode, stray: list[bytes]
) -> None:
    """A second refusal is one too many, unless the first abort may have come for no segment."""
    abort = Abort(DOMAIN.mux, code)

    def answers(data: bytes) -> list[bytes]:
        if data == READ:
            return [BASELINE]
        return [BEGUN] if data[0] == 0xC6 else [abort.encode(), REFUSED]

    with talking_to(Scripted(answers)) as sdo:
        assert Blocks(sdo).try_download(DOMAIN, bytes(7)) == abort
        assert [response.encode() for response in sdo.fence()] == stray


@pytest.mark.parametrize("code", [AbortCode.LOCAL_CONTROL, AbortCode.COMMAND_NOT_VALID])
def test_an_abort_of_its_own_accord_crosses_with_that_of_the_client(code: AbortCode) -> None:
    def answers(data: bytes) -> list[bytes]:
        if data == READ:
            return [BASELINE]
        return [BEGUN] if data[0] == 0xC6 else [Abort(DOMAIN.mux, code).encode()]

    with talking_to(Scripted(answers)) as sdo:
        Blocks(sdo).initiate_download(DOMAIN, 7)
        sdo.end_transfer()
        sdo.silence.calm()
        noted = [found.rule for found in sdo.record.minor]
    assert noted == ([] if code is AbortCode.LOCAL_CONTROL else [ABORT_NOT_ANSWERED])


def test_an_acknowledgement_does_not_stop_a_sub_block() -> None:
    """A gap may be told at once: the server waits for the end of the sub-block, or for number 1."""
    numbers: list[int] = []

    def answers(data: bytes) -> list[bytes]:
        if data[0] == 0xC6:
            return [BEGUN]
        numbers.append(data[0])
        return [BlockAck(0, 127).encode()] if len(numbers) == 1 else []

    with talking_to(Scripted(answers)) as sdo:
        Blocks(sdo).initiate_download(DOMAIN, len(DATA))
        Blocks(sdo).send_segments([bytes(7)] * 20, first=2)
    assert numbers == list(range(2, 22))
