"""Nodes that react wrongly where they are odd: in an NMT state, or on some channels."""

from conformance.reference.node import Node, ServerChannel
from conformance.reference.segmented_server import Transfer, Upload
from conformance.reference.server import BlockDownload
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import Abort, BlockEnd
from conformance.sdo.layout import whole_frame

BYTE = 255


class OddServing(Node):
    """Changes the answers where ``is_odd`` says so."""

    def is_odd(self, channel: ServerChannel) -> bool:
        """Say whether requests are served wrongly on a channel now."""
        raise NotImplementedError

    def serve(self, channel: ServerChannel, frame: CanFrame) -> list[bytes]:
        """Pass each answer through ``spoilt``, with the transfer that was running."""
        transfer = channel.server.transfer
        answers = super().serve(channel, frame)
        return self.spoilt(transfer, frame, answers) if self.is_odd(channel) else answers

    def spoilt(
        self, transfer: Transfer | None, frame: CanFrame, answers: list[bytes]
    ) -> list[bytes]:
        """Return what is sent in the place of right answers."""
        raise NotImplementedError


class AnswersAborts(OddServing):
    """Sends each abort back."""

    def spoilt(
        self, transfer: Transfer | None, frame: CanFrame, answers: list[bytes]
    ) -> list[bytes]:
        """Know an abort by its specifier."""
        is_abort = isinstance(decode_request(whole_frame(frame.data)), Abort)
        return [frame.data] if is_abort else answers


class LosesLongUploads(OddServing):
    """Sends zeros beyond byte 255 of segmented uploads."""

    def spoilt(
        self, transfer: Transfer | None, frame: CanFrame, answers: list[bytes]
    ) -> list[bytes]:
        """Leave byte 0 as it is."""
        if isinstance(transfer, Upload) and transfer.offset > BYTE:
            return [answer[:1].ljust(len(answer), b"\0") for answer in answers]
        return answers


class WantsCrc(OddServing):
    """Aborts block downloads without a CRC at their end."""

    def spoilt(
        self, transfer: Transfer | None, frame: CanFrame, answers: list[bytes]
    ) -> list[bytes]:
        """Know the end by the transfer that it belongs to."""
        is_end = isinstance(decode_request(whole_frame(frame.data)), BlockEnd)
        if is_end and isinstance(transfer, BlockDownload) and transfer.ended and not transfer.crc:
            return [Abort(transfer.mux, AbortCode.CRC_ERROR).encode()]
        return answers
