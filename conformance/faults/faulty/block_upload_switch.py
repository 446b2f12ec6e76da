"""Servers that are wrong about when to answer a block upload with an ordinary one."""

from conformance.faults.registry import Defect, fault
from conformance.reference.segmented_server import Upload
from conformance.reference.server import Server
from conformance.sdo.frames import BlockUploadInitiate, Response
from conformance.sdo.limits import SEGMENT_LENGTH


@fault("block-upload-threshold-0-switches", Defect.STATE, "block-upload.threshold[0]")
class Threshold0Switches(Server):
    """Sends up to 20 bytes as an ordinary upload though pst is 0."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        return (not request.threshold and size <= 20) or super().switches_protocol(request, size)


@fault("block-upload-threshold-not-compared", Defect.STATE, "block-upload.threshold[5]")
class ThresholdNotCompared(Server):
    """Sends everything as an ordinary upload when pst is not 0."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        return request.threshold > 0


@fault("block-upload-threshold-counts-segments", Defect.STATE, "block-upload.threshold[13]")
class ThresholdInSegments(Server):
    """Rounds pst up to whole segments."""

    def switches_protocol(self, request: BlockUploadInitiate, size: int) -> bool:
        return 0 < -(-size // SEGMENT_LENGTH) <= -(-request.threshold // SEGMENT_LENGTH)


@fault("block-upload-switched-stuck", Defect.STATE, "block-upload.threshold[14]")
class SwitchedStuck(Server):
    """Refuses the segments of an ordinary upload that a block upload became."""

    def on_block_upload_initiate(self, request: BlockUploadInitiate) -> list[Response]:
        responses = super().on_block_upload_initiate(request)
        if isinstance(self.transfer, Upload):
            self.transfer = None
        return responses
