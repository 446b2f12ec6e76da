"""Command specifiers that have no meaning, and services that a server may lack (7.2.4.3)."""

from dataclasses import replace

from conformance.device.device import DEVICE_TYPE, VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Unimplemented
from conformance.dialogue.blocks import Blocks
from conformance.dialogue.dialogue import Dialogue
from conformance.model_cases.variations import BLOCK_FRAMES, UNKNOWN_SPECIFIERS
from conformance.run.case import may, must
from conformance.run.risks import UNKNOWN_SPECIFIER, risk_of_request
from conformance.sdo.decoding import as_answer
from conformance.sdo.frames import (
    Abort,
    BlockDownloadInitiate,
    BlockDownloadInitiateResponse,
    BlockUploadInitiate,
    BlockUploadInitiateResponse,
)
from conformance.sdo.layout import Message, Multiplexer
from conformance.sdo.rules import MULTIPLEXER, Violation
from conformance.sdo.rules.download_initiates import BLOCK_DOWNLOAD_RESERVED_BITS
from conformance.sdo.rules.idle import BLOCK_UNSUPPORTED
from conformance.sdo.rules.idle import UNKNOWN_SPECIFIER as UNKNOWN
from conformance.sdo.rules.upload_initiates import BLOCK_UPLOAD_RESERVED_BITS
from conformance.sdo.seen import Received


@must("specifier.unknown", risk=UNKNOWN_SPECIFIER, request=UNKNOWN_SPECIFIERS)
def test_unknown(sdo: Dialogue, request: bytes) -> None:
    """A command specifier that is not defined is aborted with 05040001h."""
    sdo.send(request)
    sdo.expect_abort(*UNKNOWN.codes, of=None)


@must(
    "specifier.unknown-is-over",
    "specifier.unknown",
    "server.idle-afterwards",
    risk=UNKNOWN_SPECIFIER,
    request=UNKNOWN_SPECIFIERS,
)
def test_unknown_is_over(sdo: Dialogue, request: bytes) -> None:
    """After an undefined command specifier the next request is served."""
    due = sdo.upload(VENDOR_ID)
    sdo.send(request)
    sdo.expect_abort(*UNKNOWN.codes, of=None)
    sdo.expect_value(VENDOR_ID, due)


@may(
    "specifier.out-of-block",
    "request.out-of-transfer",
    "abort.any-multiplexer",
    risk=risk_of_request,
    request=BLOCK_FRAMES,
)
def test_out_of_block(sdo: Dialogue, request: Message) -> None:
    """A frame of a block transfer that was not started: abort or silence, no positive answer."""
    sdo.send(request)
    sdo.expect_silence_or_abort()


@must("specifier.sub-command", command={"A6h": 0xA6, "C7h": 0xC7})
def test_sub_command(sdo: Dialogue, variable: KnownObject, command: int) -> None:
    """A block initiate whose sub-command bits name none is not served.

    Silence is accepted: the frame may pass for an acknowledgement or an end out of place.
    """
    ordinary = BlockUploadInitiate(variable.mux, 127).encode()
    sdo.send(bytes([command]) + ordinary[1:])
    sdo.line.open = variable.mux  # the server may have begun a transfer
    sdo.expect_silence_or_abort()


@may(
    "specifier.block-download-reserved-bits",
    "block-download.request-reserved-bits",
    "request.reserved-bits",
    bits={"08h": 1, "10h": 2, "18h": 3},
)
def test_block_download_reserved_bits(
    sdo: Dialogue, blocks: Blocks, variable: KnownObject, bits: int
) -> None:
    """Bits 4 and 3 of a block download initiate may be ignored or refused; silence is neither."""
    size = len(sdo.device.values[variable.mux])
    blocks.initiate_download(variable, size)
    sdo.end_transfer()
    request = BlockDownloadInitiate.with_size(variable.mux, size)
    sdo.send(replace(request, reserved_bits=bits))
    response = sdo.receive()
    if isinstance(response, Abort):
        sdo.take_abort(response, BLOCK_DOWNLOAD_RESERVED_BITS.codes, None)
    else:
        sdo.checks.block_download_initiate(response, variable.mux)


@may(
    "specifier.block-upload-reserved-bits",
    "block-upload.request-reserved-bits",
    "request.reserved-bits",
    bits={"08h": 1, "10h": 2, "18h": 3},
)
def test_block_upload_reserved_bits(sdo: Dialogue, blocks: Blocks, bits: int) -> None:
    """Bits 4 and 3 of a block upload initiate may be ignored or refused; silence is neither."""
    blocks.initiate_upload(VENDOR_ID)
    sdo.end_transfer()
    sdo.send(BlockUploadInitiate(VENDOR_ID.mux, 127, reserved_bits=bits))
    response = as_answer(sdo.receive())
    if isinstance(response, Abort):
        sdo.take_abort(response, BLOCK_UPLOAD_RESERVED_BITS.codes, None)
    else:
        sdo.checks.block_upload_initiate(response, VENDOR_ID.mux)


@must(
    "specifier.block-upload",
    "block.unsupported",
    "response.not-refused",
    "response.multiplexer",
    "block-upload.no-switch",
    clause="7.2.4.3.13",
    crc=[True, False],
)
def test_block_upload(sdo: Dialogue, crc: bool) -> None:
    """A block upload is served, or refused with 05040001h as not implemented; never silence.

    With pst = 0 the server must not switch to another protocol.
    """
    sdo.send(BlockUploadInitiate(DEVICE_TYPE, 127, crc_supported=crc))
    _served_or_unimplemented(sdo, DEVICE_TYPE, BlockUploadInitiateResponse)


@must(
    "specifier.block-download",
    "block.unsupported",
    "response.not-refused",
    "response.multiplexer",
    clause="7.2.4.3.9",
    sized=[True, False],
)
def test_block_download(sdo: Dialogue, variable: KnownObject, sized: bool) -> None:
    """A block download is served, or refused with 05040001h as not implemented; never silence."""
    size = len(sdo.device.values[variable.mux]) if sized else None
    sdo.send(BlockDownloadInitiate.with_size(variable.mux, size))
    _served_or_unimplemented(sdo, variable.mux, BlockDownloadInitiateResponse)


def _served_or_unimplemented(
    sdo: Dialogue,
    mux: Multiplexer,
    kind: type[BlockUploadInitiateResponse] | type[BlockDownloadInitiateResponse],
) -> None:
    response = sdo.receive()
    if isinstance(response, Abort):
        sdo.take_abort(response, BLOCK_UNSUPPORTED.codes, mux)
        raise Unimplemented(Received(response))
    if not isinstance(response, kind):
        raise sdo.breach(
            f"a block initiate response for {mux}, or abort 05040001h", Received(response)
        )
    if response.mux != mux:
        raise Violation(MULTIPLEXER, expected=f"multiplexer {mux}", actual=Received(response))
