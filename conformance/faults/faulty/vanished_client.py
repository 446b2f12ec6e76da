"""Servers that do not get over a client that vanishes in the middle of a transfer."""

from conformance.faults.registry import Defect, fault
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockUploadInitiate,
    DownloadInitiate,
    Request,
    Response,
    UploadInitiate,
)
from conformance.sdo.objects import Refusal


@fault("busy-after-vanished-client", Defect.TIMING, "vanished-client.next-transfer")
class BusyAfterVanishedClient(Server):
    """Refuses every initiate while a transfer is running, which goes on."""

    def react(self, request: Request) -> list[Response]:
        initiate = isinstance(
            request, UploadInitiate | DownloadInitiate | BlockUploadInitiate | BlockDownloadInitiate
        )
        if initiate and self.transfer is not None:
            raise Refusal(AbortCode.LOCAL_CONTROL)
        return super().react(request)

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        running = self.transfer
        responses = super().refuse(request, code)
        if code is AbortCode.LOCAL_CONTROL:
            self.transfer = running
        return responses
