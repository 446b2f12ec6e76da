"""Each frame in each state of the server: its answer, the value left behind, the next transfer.

What is allowed is not written here: the oracle follows each conversation and knows.
"""

from collections.abc import Callable

from conformance.device.known_objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.model_cases.matrix.field import perform_stimulus
from conformance.model_cases.matrix.field_risks import risk_in
from conformance.model_cases.matrix.stimuli import Stimulus
from conformance.model_cases.server_states import (
    BLOCK_DOWNLOAD_BETWEEN,
    BLOCK_DOWNLOAD_END,
    BLOCK_DOWNLOAD_FIRST,
    BLOCK_DOWNLOAD_INSIDE,
    BLOCK_UPLOAD_BETWEEN,
    BLOCK_UPLOAD_END,
    BLOCK_UPLOAD_INITIATED,
    BLOCK_UPLOAD_SENT,
    IDLE,
    SEGMENTED_DOWNLOAD_FIRST,
    SEGMENTED_DOWNLOAD_LAST,
    SEGMENTED_DOWNLOAD_MIDDLE,
    SEGMENTED_UPLOAD_FIRST,
    SEGMENTED_UPLOAD_LAST,
    SEGMENTED_UPLOAD_MIDDLE,
    State,
)
from conformance.run.case import Function, must
from conformance.sdo.frames import Request

# What holds for each answer, and behind it.
ABOUT = (
    "response.specifier",
    "response.answered",
    "response.unsolicited",
    "server.idle-afterwards",
)


def each_frame(state: State[Request | None]) -> Callable[[Function], Function]:
    """Mark the cases that send each of a state's stimuli there."""
    return must(
        f"matrix.{state.name}",
        *ABOUT,
        risk=risk_in(state),
        in_state=state.name,
        stimulus=state.stimuli,
    )


@each_frame(IDLE)
def test_idle(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Without a transfer, each frame gets one of the answers that are allowed there."""
    perform_stimulus(IDLE, stimulus, sdo, text)


@each_frame(SEGMENTED_DOWNLOAD_FIRST)
def test_segmented_download_first(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the first segment of a download is due, each frame gets an answer allowed there."""
    perform_stimulus(SEGMENTED_DOWNLOAD_FIRST, stimulus, sdo, text)


@each_frame(SEGMENTED_DOWNLOAD_MIDDLE)
def test_segmented_download_middle(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """In the middle of a segmented download, each frame gets an answer allowed there."""
    perform_stimulus(SEGMENTED_DOWNLOAD_MIDDLE, stimulus, sdo, text)


@each_frame(SEGMENTED_DOWNLOAD_LAST)
def test_segmented_download_last(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the last segment of a download is due, each frame gets an answer allowed there."""
    perform_stimulus(SEGMENTED_DOWNLOAD_LAST, stimulus, sdo, text)


@each_frame(SEGMENTED_UPLOAD_FIRST)
def test_segmented_upload_first(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the first segment of an upload is due, each frame gets an answer allowed there."""
    perform_stimulus(SEGMENTED_UPLOAD_FIRST, stimulus, sdo, text)


@each_frame(SEGMENTED_UPLOAD_MIDDLE)
def test_segmented_upload_middle(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """In the middle of a segmented upload, each frame gets an answer allowed there."""
    perform_stimulus(SEGMENTED_UPLOAD_MIDDLE, stimulus, sdo, text)


@each_frame(SEGMENTED_UPLOAD_LAST)
def test_segmented_upload_last(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the last segment of an upload is due, each frame gets an answer allowed there."""
    perform_stimulus(SEGMENTED_UPLOAD_LAST, stimulus, sdo, text)


@each_frame(BLOCK_DOWNLOAD_FIRST)
def test_block_download_first(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the first segment of a sub-block is due, each frame counts as segment or abort."""
    perform_stimulus(BLOCK_DOWNLOAD_FIRST, stimulus, sdo, text)


@each_frame(BLOCK_DOWNLOAD_INSIDE)
def test_block_download_inside(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Inside a sub-block of a download, each frame counts as segment or abort."""
    perform_stimulus(BLOCK_DOWNLOAD_INSIDE, stimulus, sdo, text)


@each_frame(BLOCK_DOWNLOAD_BETWEEN)
def test_block_download_between(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Behind an acknowledged sub-block, each frame counts as segment or abort."""
    perform_stimulus(BLOCK_DOWNLOAD_BETWEEN, stimulus, sdo, text)


@each_frame(BLOCK_DOWNLOAD_END)
def test_block_download_end(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the end of a block download is due, each frame gets an answer allowed there."""
    perform_stimulus(BLOCK_DOWNLOAD_END, stimulus, sdo, text)


@each_frame(BLOCK_UPLOAD_INITIATED)
def test_block_upload_initiated(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the start of a block upload is due, each frame gets an answer allowed there."""
    perform_stimulus(BLOCK_UPLOAD_INITIATED, stimulus, sdo, text)


@each_frame(BLOCK_UPLOAD_BETWEEN)
def test_block_upload_between(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where a sub-block waits for its acknowledgement, each frame gets an answer allowed there."""
    perform_stimulus(BLOCK_UPLOAD_BETWEEN, stimulus, sdo, text)


@each_frame(BLOCK_UPLOAD_SENT)
def test_block_upload_sent(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the last sub-block waits for its acknowledgement, each frame gets its answer."""
    perform_stimulus(BLOCK_UPLOAD_SENT, stimulus, sdo, text)


@each_frame(BLOCK_UPLOAD_END)
def test_block_upload_end(sdo: Dialogue, text: KnownObject, stimulus: Stimulus) -> None:
    """Where the end of a block upload waits for its confirmation, each frame gets its answer."""
    perform_stimulus(BLOCK_UPLOAD_END, stimulus, sdo, text)
