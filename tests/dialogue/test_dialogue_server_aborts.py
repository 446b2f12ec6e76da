"""What tells an abort that came by chance from a service that is refused."""

from dataclasses import replace

import pytest

from conformance.dialogue.server_aborts import EarlyAborts, Way, is_early, is_systematic
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.checks import ServerAborted
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import Abort, UploadInitiate, UploadSegment
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import NOT_REFUSED, SIZE, Violation
from conformance.sdo.seen import Received

TEXT, OTHER = Multiplexer(0x2010), Multiplexer(0x2011)
ABORT = Abort(TEXT, AbortCode.DEVICE_STATE)
FRAME = ABORT.encode()
WAY = Way(NOT_REFUSED.id, ABORT, "upload segment request", 3)
ASKED = UploadSegment(toggle=0)


@pytest.mark.parametrize(
    ("frame", "running", "early"),
    [
        (FRAME, TEXT, True),
        (FRAME, OTHER, False),
        (FRAME, None, False),
        (Abort(TEXT, 0x12345678).encode(), TEXT, False),
        (b"\x81" + FRAME[1:], TEXT, False),
        (UploadInitiate(TEXT).encode(), TEXT, False),
    ],
)
def test_early_is_a_proper_abort_of_what_runs(
    frame: bytes, running: Multiplexer | None, early: bool
) -> None:
    assert is_early(decode_response(frame), running) is early


@pytest.mark.parametrize(
    ("places", "systematic"),
    [
        ([3], False),
        ([3, 3, 3], False),
        ([3, 3, 3, 3], True),
        ([9, 3, 3, 3], True),
        ([3, 3, 3, 4], False),
        ([3, 4, 4, 3], False),
    ],
)
def test_systematic_is_the_same_place_each_time(places: list[int], systematic: bool) -> None:
    assert is_systematic([replace(WAY, transfers=place) for place in places]) is systematic


def test_another_abort_is_another_way() -> None:
    other = replace(WAY, abort=Abort(TEXT, AbortCode.GENERAL_ERROR))
    assert not is_systematic([other, WAY, WAY, WAY])


def test_way_says_what_ended_a_try() -> None:
    early = EarlyAborts()
    early.sent(UploadInitiate(TEXT))
    early.received(ABORT, TEXT)
    way = early.way(ServerAborted(ABORT), ASKED)
    assert way is not None
    assert (way.abort, way.transfers) == (ABORT, 1)
    assert early.way(None, ASKED) is None
    assert early.way(ServerAborted(Abort(OTHER, AbortCode.DEVICE_STATE)), ASKED) is None


def test_breach_behind_the_next_initiate_is_another_matter_unless_it_tells_of_the_abort() -> None:
    early = EarlyAborts()
    early.received(ABORT, TEXT)
    early.sent(UploadInitiate(OTHER))
    assert early.way(Violation(SIZE, expected="14 bytes", actual="13 bytes"), ASKED) is None
    told = Violation(SIZE, expected="both served", actual=Received(ABORT))
    assert early.way(told, ASKED) is not None
