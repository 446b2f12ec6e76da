"""Servers that are wrong about the block size in block uploads."""

from dataclasses import replace

from conformance.faults.block_servers import ReadsAcknowledgements
from conformance.faults.registry import DefectClass, fault
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import BlockAck, BlockUploadInitiate, Request, Response
from conformance.sdo.server import LARGEST_BLOCK, BlockUpload, Server

BLOCK_SIZE = DefectClass.BLOCK_SIZE


class _BlockSizes(ReadsAcknowledgements):
    """Reads the block size of an acknowledgement otherwise, where it is one."""

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Ask ``size``."""
        if not 1 <= request.block_size <= LARGEST_BLOCK:
            return request
        repeated = request.sequence < transfer.sent
        size = self.size(transfer.block_size, request.block_size, repeated=repeated)
        return replace(request, block_size=size)

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Return the size of the next sub-block."""
        del new, repeated
        return old


@fault("block-upload-new-block-size-ignored", BLOCK_SIZE, "block-upload.block-size-changes")
class NewSizeIgnored(_BlockSizes):
    """Keeps to the block size of the initiate."""


@fault("block-upload-smaller-block-size-ignored", BLOCK_SIZE, "block-upload.block-size-changes")
class SmallerIgnored(_BlockSizes):
    """Ignores a block size in an acknowledgement that is smaller than the last."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Keep the larger."""
        return max(old, new)


@fault("block-upload-larger-block-size-ignored", BLOCK_SIZE, "block-upload.block-size-changes")
class LargerIgnored(_BlockSizes):
    """Ignores a block size in an acknowledgement that is larger than the last."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Keep the smaller."""
        return min(old, new)


@fault(
    "block-upload-block-size-of-retransmission-ignored",
    BLOCK_SIZE,
    "block-upload.block-size-with-retransmission",
)
class SizeIgnoredWithLoss(_BlockSizes):
    """Ignores the block size of an acknowledgement that reports a loss."""

    def size(self, old: int, new: int, *, repeated: bool) -> int:
        """Keep the old one for what is sent again."""
        return old if repeated else new


@fault("block-upload-one-segment-more", BLOCK_SIZE, "block-upload.block-size")
class OneMore(Server):
    """Sends one segment more than the client asked for in the first sub-block."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Be off by one."""
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload):
            self.transfer.block_size = min(request.block_size + 1, LARGEST_BLOCK)
        return responses


class _InitiateSizes(Server):
    """Makes a block size that is none right in the initiate."""

    wrong: tuple[int, ...] = ()

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Take 127 for it."""
        if request.block_size in self.wrong:
            request = replace(request, block_size=LARGEST_BLOCK)
        return super().on_block_upload_initiate(request)


@fault("block-upload-block-size-0-accepted", BLOCK_SIZE, "block-upload.invalid-block-size[0]")
class Size0Accepted(_InitiateSizes):
    """Takes block size 0 of an initiate for 127."""

    wrong = (0,)


@fault("block-upload-block-size-128-accepted", BLOCK_SIZE, "block-upload.invalid-block-size[128]")
class Size128Accepted(_InitiateSizes):
    """Takes block sizes beyond 127 of an initiate for 127."""

    wrong = tuple(range(128, 256))


@fault("block-upload-block-size-code-wrong", BLOCK_SIZE, "block-upload.invalid-block-size")
class SizeCodeWrong(Server):
    """Calls a block size that is none an invalid value."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        """Replace the code."""
        wrong = code is AbortCode.INVALID_BLOCK_SIZE
        return super().refuse(request, AbortCode.VALUE_INVALID if wrong else code)


class _AckSizes(ReadsAcknowledgements):
    """Makes a block size that is none right in an acknowledgement."""

    wrong: tuple[int, ...] = ()

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Keep the old one for it."""
        wrong = request.block_size in self.wrong
        return replace(request, block_size=transfer.block_size) if wrong else request


@fault(
    "block-upload-acknowledged-block-size-0-accepted",
    BLOCK_SIZE,
    "block-upload.acknowledges-block-size[0]",
)
class AckSize0Accepted(_AckSizes):
    """Keeps the old block size when an acknowledgement states 0."""

    wrong = (0,)


@fault(
    "block-upload-acknowledged-block-size-128-accepted",
    BLOCK_SIZE,
    "block-upload.acknowledges-block-size[128]",
)
class AckSize128Accepted(_AckSizes):
    """Keeps the old block size when an acknowledgement states more than 127."""

    wrong = tuple(range(128, 256))


@fault("block-upload-threshold-in-block-size", BLOCK_SIZE, "block-upload.threshold-and-block-size")
class ThresholdInBlockSize(Server):
    """Reads the block size of an initiate as 16 bits, with pst for the high byte."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        """Send up to 127 segments at once where pst is not 0."""
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, BlockUpload) and request.threshold:
            self.transfer.block_size = LARGEST_BLOCK
        return responses
