"""What a case sends is known before it runs, by its frames and not by its name."""

from collections.abc import Callable

import pytest

from conformance.model_cases.matrix.field_risks import risk_in
from conformance.model_cases.matrix.stimuli import STIMULI, SUB_BLOCK_STIMULI
from conformance.model_cases.server_states import BLOCK_DOWNLOAD_INSIDE, IDLE
from conformance.run.case import case_info, must
from conformance.run.risks import (
    ANYTHING,
    EXTENDED,
    LOST_SEGMENT,
    REMOTE,
    UNKNOWN_SPECIFIER,
    Kind,
    Risk,
    of_length,
    risk_of_frame,
    risk_of_request,
)
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import BlockAck, UploadInitiate
from conformance.sdo.layout import Multiplexer

READ = UploadInitiate(Multiplexer(0x1000)).encode()
REQUEST = 0x605


@pytest.mark.parametrize(
    ("frame", "risk"),
    [
        (CanFrame(REQUEST, remote=True, length=8), REMOTE),
        (CanFrame(REQUEST, READ, extended=True), EXTENDED),
        (CanFrame(REQUEST, READ[:4]), of_length(4)),
        (CanFrame(REQUEST, b""), of_length(0)),
        (CanFrame(REQUEST, b"\xe0" + bytes(7)), UNKNOWN_SPECIFIER),
        (CanFrame(REQUEST, READ), Risk(Kind.ORDINARY, "an upload initiate")),
    ],
)
def test_a_frame(frame: CanFrame, risk: Risk) -> None:
    assert risk_of_frame(frame) == risk


def test_a_message() -> None:
    assert risk_of_request(BlockAck(1, 127)).text == "an acknowledgement of segments"


def test_the_length_that_is_due_is_no_risk() -> None:
    assert of_length(8) is None


def test_lengths_are_told_apart() -> None:
    assert of_length(1) != of_length(4)


def test_a_stimulus_of_the_matrix() -> None:
    risk_of = risk_in(IDLE)
    assert risk_of(STIMULI["remote-0"]) == REMOTE
    assert risk_of(STIMULI["40h-dlc-4"]) == of_length(4)
    assert risk_of(STIMULI["23h"]) == risk_of(STIMULI["22h"])


def test_within_a_sub_block_a_number_out_of_sequence_is_a_lost_segment() -> None:
    risk_of = risk_in(BLOCK_DOWNLOAD_INSIDE)
    assert risk_of(SUB_BLOCK_STIMULI["segment-2-last"]) is None
    assert risk_of(SUB_BLOCK_STIMULI["segment-96-last"]) == LOST_SEGMENT, "E0h is no specifier here"
    assert risk_of(SUB_BLOCK_STIMULI["remote-8"]) == REMOTE
    abort = risk_of(SUB_BLOCK_STIMULI["80h"])
    assert abort is not None
    assert abort.text == "an abort"


def test_a_risk_is_met_when_such_a_frame_was_sent() -> None:
    assert REMOTE.was_met([CanFrame(REQUEST, READ), CanFrame(REQUEST, remote=True)])
    assert not REMOTE.was_met([CanFrame(REQUEST, READ)])
    assert LOST_SEGMENT.was_met([CanFrame(REQUEST, READ)]), "no frame says what is missing"


def risk_of(function: Callable[..., None], **arguments: object) -> Risk | None:
    info = case_info(function)
    assert info is not None
    return info.risk_of(arguments)


def test_a_case_states_its_risk() -> None:
    @must("frame.some", "frame.short", risk=ANYTHING)
    def some(sdo: object) -> None:
        """It holds."""

    @must("frame.any", "frame.short", risk=of_length, dlc=[3, 8])
    def each(sdo: object, dlc: int) -> None:
        """It holds."""

    assert risk_of(some) == ANYTHING
    assert risk_of(each, dlc=3) == of_length(3)
    assert risk_of(each, dlc=8) is None
