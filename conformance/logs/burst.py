"""Segments of a block download that a server takes for requests, behind its own abort."""

from conformance.sdo.decoding import decode_request, decode_response, is_abort
from conformance.sdo.frames import Abort, BlockAck, DownloadInitiate, DownloadInitiateResponse
from conformance.sdo.layout import FRAME_LENGTH

NUMBER = 0x7F


class Burst:
    """Follows one channel: the segments since the last acknowledgement, which may cross an abort.

    Frames behind the abort belong to them as long as their numbers go on.
    """

    __slots__ = ("_aborted", "_segments")

    def __init__(self) -> None:
        """Begin outside any sub-block."""
        self._segments: list[bytes] = []
        self._aborted = False

    def clear(self) -> None:
        """Forget all."""
        self._segments.clear()
        self._aborted = False

    def sent(self, frame: bytes, *, in_sub_block: bool) -> None:
        """Take a request."""
        segments = self._segments
        whole = len(frame) == FRAME_LENGTH and not is_abort(frame)
        goes_on = self._aborted and whole and bool(segments)
        goes_on = goes_on and frame[0] & NUMBER == (segments[-1][0] & NUMBER) + 1
        if whole and (in_sub_block or goes_on):
            segments.append(frame)
        elif segments:
            self.clear()

    def answered(self, frame: bytes, *, in_sub_block: bool) -> str | None:
        """Take a response; return in words which object a segment was written to, None for none."""
        response = decode_response(frame)
        if isinstance(response, Abort):
            self._aborted = in_sub_block or self._aborted
        elif isinstance(response, BlockAck):
            self.clear()
        elif self._aborted and isinstance(response, DownloadInitiateResponse):
            written = map(decode_request, self._segments)
            if any(
                isinstance(each, DownloadInitiate) and each.mux == response.mux for each in written
            ):
                return (
                    f"a segment behind the abort of a block download was taken for a download to "
                    f"{response.mux}, and is written there"
                )
        return None
