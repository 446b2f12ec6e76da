"""What a request may change of the device: permitted before it goes out, and noted then."""

from conformance.device.device import Device
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.protected_objects import READ_ONLY_PROBES
from conformance.device.safety import written_by
from conformance.dialogue.case_record import CaseRecord
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadInitiateResponse,
    DownloadSegmentResponse,
    Request,
    Response,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Multiplexer

# What changes no value; nor does an abort where nothing was written.
READING = (
    UploadInitiate,
    UploadSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    BlockAck,
    BlockEndResponse,
)
# The first segment of a sub-block that a server without a transfer may take for an initiate.
FIRST_LIKE_INITIATE = 0x20


class Effects:
    """What the requests of one case may change, on one channel of a device.

    ``spelled`` are the objects to which segments of the latest block download would be writes, if
    the server had ended it.
    """

    def __init__(self, device: Device, record: CaseRecord) -> None:
        """Take the device, and what is known of the case."""
        self._device = device
        self._record = record
        self.spelled: set[Multiplexer] = set()
        # What was written within an initiate last, and what objects read before they were probed.
        self._expedited: Multiplexer | None = None
        self._before: dict[Multiplexer, bytes] = {}

    def permit(self, request: Request) -> Multiplexer | None:
        """Return what a request begins to write, if it does.

        Raises WriteNotPermitted or NotTestable for what the user has not allowed.
        """
        target = written_by(request)
        if target is None:
            return None
        if self._device.policy.needs_probes(target):
            raise NotTestable(
                f"needs permission to write to {target}, which a correct device refuses: "
                f"add --sdo-allow={READ_ONLY_PROBES}",
                Missing(Lack.PERMISSION, READ_ONLY_PROBES),
            )
        self._device.policy.check(request)
        return target

    def note(self, request: Request, target: Multiplexer | None) -> None:
        """Note what goes out next: what a device has read as may not be what it holds any more.

        ``target`` is what it begins to write, if it does.
        """
        contents, record = self._device.contents, self._record
        if isinstance(request, BlockDownloadInitiate):
            self.spelled.clear()
        if target is not None:
            self._note_written(request, target)
        contents.sent(request)
        if record.written or not isinstance(request, Abort):
            contents.current.clear()

    def _note_written(self, request: Request, target: Multiplexer) -> None:
        device, record = self._device, self._record
        is_expedited = isinstance(request, DownloadInitiate) and request.expedited
        self._expedited = target if is_expedited else None
        before = device.contents.read_last(target)
        if before is not None:
            self._before.setdefault(target, before)
        for mux in (target, *device.taken_for(target)):
            device.contents.will_change(mux)
            record.written.add(mux)
        record.reset.pop(target, None)

    def note_segment(self, segment: BlockSegment) -> None:
        """Note a segment of a block download that goes out behind others.

        Raises NotTestable for one that writes where it must not if the server has left meanwhile.
        """
        self._device.contents.sent(segment)
        if segment.sequence >= FIRST_LIKE_INITIATE:
            target = written_by(decode_request(segment.encode()))
            if target is None:
                return
            if self._device.would_lose(target):
                raise NotTestable(
                    f"a segment would be a write to {target} if the server had ended the transfer"
                )
            self.spelled.add(target)

    def note_taken_segment(self, mux: Multiplexer) -> None:
        """Note that a server that had ended a block download has taken a segment for a write.

        What it has written there is put back if it may be, or else is listed.
        """
        contents, record = self._device.contents, self._record
        record.notes.append(
            "the server has ended the block download, and has taken a segment that was on its way "
            f"for a write to {mux}"
        )
        contents.current.clear()
        if contents.kept(mux) is None:
            contents.takes(mux)
        else:
            contents.will_change(mux)
            record.written.add(mux)

    def answered(self, response: Response, ended: Multiplexer | None) -> None:
        """Take an answer: it may confirm a write that had to be refused.

        ``ended`` is the object of the transfer that it has ended, if it has.
        """
        match response:
            case DownloadInitiateResponse(mux=mux) if mux == self._expedited:
                self._device.was_taken(mux, self._before.get(mux))
            case DownloadSegmentResponse() | BlockEndResponse() if ended is not None:
                self._device.was_taken(ended, self._before.get(ended))
