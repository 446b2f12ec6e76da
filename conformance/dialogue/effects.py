"""What a request may change of the device: permitted before it goes out, and noted then."""

from conformance.device.device import Device
from conformance.device.lacking import NotTestable
from conformance.device.protected_objects import READ_ONLY_PROBES
from conformance.device.safety import written_by
from conformance.dialogue.record import CaseRecord
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockEndResponse,
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
from conformance.sdo.storage_commands import COMMANDS

# What changes no value; nor does an abort where nothing was written.
READING = (
    UploadInitiate,
    UploadSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    BlockAck,
    BlockEndResponse,
)


class Effects:
    """What the requests of one case may change, on one channel of a device."""

    def __init__(self, device: Device, record: CaseRecord) -> None:
        """Take the device, and what is known of the case."""
        self._device = device
        self._record = record
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
                f"add --sdo-allow={READ_ONLY_PROBES}"
            )
        self._device.policy.check(request)
        return target

    def note(self, request: Request, target: Multiplexer | None) -> None:
        """Note what goes out next: what a device has read as may not be what it holds any more.

        ``target`` is what it begins to write, if it does.
        """
        device, record = self._device, self._record
        device.extents.request(request)
        if target is not None:
            self._note_written(request, target)
        if record.written or not isinstance(request, Abort):
            device.keeping.seen.clear()

    def _note_written(self, request: Request, target: Multiplexer) -> None:
        device, record = self._device, self._record
        is_expedited = isinstance(request, DownloadInitiate) and request.expedited
        self._expedited = target if is_expedited else None
        before = device.keeping.seen.get(target, device.values.get(target))
        if before is not None:
            self._before.setdefault(target, before)
        for mux in (target, *device.taken_for(target)):
            device.will_change(mux)
            record.written.add(mux)
        record.reset.pop(target, None)
        device.keeping.doubtful.discard(target)
        if target.index in COMMANDS and target.sub_index:
            device.keeping.brought_back.clear()
            device.keeping.stored = None

    def answered(self, response: Response, ended: Multiplexer | None) -> None:
        """Take an answer: it may confirm a write that had to be refused.

        ``ended`` is the object of the transfer that it has ended, if it has.
        """
        match response:
            case DownloadInitiateResponse(mux=mux) if mux == self._expedited:
                self._device.was_taken(mux, self._before.get(mux))
            case DownloadSegmentResponse() | BlockEndResponse() if ended is not None:
                self._device.was_taken(ended, self._before.get(ended))
