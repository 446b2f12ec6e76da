"""What a server that deviates in block uploads makes of the client's acknowledgements."""

from conformance.sdo.frames import BlockAck, Response
from conformance.sdo.server import BlockUpload, Server


class AcknowledgementReader(Server):
    """Reads acknowledgements otherwise."""

    def on_block_ack(self, request: BlockAck) -> list[Response]:
        """Pass each through ``read`` while segments are on their way."""
        transfer = self.transfer
        if isinstance(transfer, BlockUpload) and transfer.sent and not transfer.ended:
            request = self.read(transfer, request)
        return super().on_block_ack(request)

    def read(self, transfer: BlockUpload, request: BlockAck) -> BlockAck:
        """Return what is made of it."""
        del transfer
        return request
