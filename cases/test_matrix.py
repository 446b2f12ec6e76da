"""Each frame in each state of the server: its answer, the value left behind, the next transfer.

What is allowed is not written here: the oracle follows each conversation and knows.
"""

from conformance.device.device import Device
from conformance.device.objects import KnownObject
from conformance.dialogue.dialogue import Dialogue
from conformance.generated.matrix.perform import perform
from conformance.generated.matrix.risks import in_sub_block, of_stimulus
from conformance.generated.matrix.stimuli import (
    NEXT_SUB_BLOCK_STIMULI,
    STIMULI,
    SUB_BLOCK_STIMULI,
    Stimulus,
)
from conformance.run.case import must

# What holds for each answer, and behind it.
ABOUT = (
    "response.specifier",
    "response.answered",
    "response.unsolicited",
    "server.idle-afterwards",
)


@must("matrix.idle", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_idle(sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus) -> None:
    """Without a transfer, each frame gets one of the answers that are allowed there."""
    perform("idle", stimulus, sdo, device, text)


@must("matrix.segmented-download-first", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_segmented_download_first(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the first segment of a download is due, each frame gets an answer allowed there."""
    perform("segmented-download-first", stimulus, sdo, device, text)


@must("matrix.segmented-download-middle", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_segmented_download_middle(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """In the middle of a segmented download, each frame gets an answer allowed there."""
    perform("segmented-download-middle", stimulus, sdo, device, text)


@must("matrix.segmented-download-last", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_segmented_download_last(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the last segment of a download is due, each frame gets an answer allowed there."""
    perform("segmented-download-last", stimulus, sdo, device, text)


@must("matrix.segmented-upload-first", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_segmented_upload_first(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the first segment of an upload is due, each frame gets an answer allowed there."""
    perform("segmented-upload-first", stimulus, sdo, device, text)


@must("matrix.segmented-upload-middle", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_segmented_upload_middle(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """In the middle of a segmented upload, each frame gets an answer allowed there."""
    perform("segmented-upload-middle", stimulus, sdo, device, text)


@must("matrix.segmented-upload-last", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_segmented_upload_last(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the last segment of an upload is due, each frame gets an answer allowed there."""
    perform("segmented-upload-last", stimulus, sdo, device, text)


@must("matrix.block-download-first", *ABOUT, risk=in_sub_block(1), stimulus=SUB_BLOCK_STIMULI)
def test_block_download_first(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the first segment of a sub-block is due, each frame counts as segment or abort."""
    perform("block-download-first", stimulus, sdo, device, text)


@must("matrix.block-download-inside", *ABOUT, risk=in_sub_block(2), stimulus=SUB_BLOCK_STIMULI)
def test_block_download_inside(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Inside a sub-block of a download, each frame counts as segment or abort."""
    perform("block-download-inside", stimulus, sdo, device, text)


@must(
    "matrix.block-download-between",
    *ABOUT,
    risk=in_sub_block(1),
    stimulus=NEXT_SUB_BLOCK_STIMULI,
)
def test_block_download_between(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Behind an acknowledged sub-block, each frame counts as segment or abort."""
    perform("block-download-between", stimulus, sdo, device, text)


@must("matrix.block-download-end", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_block_download_end(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the end of a block download is due, each frame gets an answer allowed there."""
    perform("block-download-end", stimulus, sdo, device, text)


@must("matrix.block-upload-initiated", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_block_upload_initiated(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the start of a block upload is due, each frame gets an answer allowed there."""
    perform("block-upload-initiated", stimulus, sdo, device, text)


@must("matrix.block-upload-between", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_block_upload_between(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where a sub-block waits for its acknowledgement, each frame gets an answer allowed there."""
    perform("block-upload-between", stimulus, sdo, device, text)


@must("matrix.block-upload-sent", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_block_upload_sent(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the last sub-block waits for its acknowledgement, each frame gets its answer."""
    perform("block-upload-sent", stimulus, sdo, device, text)


@must("matrix.block-upload-end", *ABOUT, risk=of_stimulus, stimulus=STIMULI)
def test_block_upload_end(
    sdo: Dialogue, device: Device, text: KnownObject, stimulus: Stimulus
) -> None:
    """Where the end of a block upload waits for its confirmation, each frame gets its answer."""
    perform("block-upload-end", stimulus, sdo, device, text)
