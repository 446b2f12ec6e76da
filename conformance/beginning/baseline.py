"""The first exchange with a device: the read of 1000h that is repeated throughout a run."""

from conformance.bus.channel import Channel
from conformance.bus.errors import SilentNode
from conformance.device.device import DEVICE_TYPE, Device
from conformance.device.effort import FIRST_TRIES
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    UploadInitiate,
    UploadInitiateResponse,
    UploadSegment,
    UploadSegmentResponse,
)
from conformance.sdo.layout import Message, whole_frame
from conformance.sdo.nmt import ERROR_CONTROL_BASE, NmtState, error_control

# Seconds that a device may need behind an abort before it takes a request, tried in turn.
RESTS = (0.002, 0.01, 0.05, 0.25)
# How much longer than it was seen to need it is left alone.
SURE = 2.0
MOST_SEGMENTS = 8


def record_baseline(channel: Channel, device: Device) -> bool:
    """Read 1000h and keep the exchange, byte by byte; raises SilentNode.

    Returns whether the first read was answered: of another, the answer may come twice.

    A device that loses what comes right behind an abort is left alone behind each from then on.
    """
    for attempt in range(FIRST_TRIES):
        if attempt % 2 == 0:
            if _reads_behind_abort(channel, device):
                return attempt == 0
        elif _exchange(channel, device, UploadInitiate(DEVICE_TYPE)):
            _learn_rest(channel, device)
            return False
    raise SilentNode(_silence(channel))


def _reads_behind_abort(channel: Channel, device: Device) -> bool:
    """Read right behind an abort: the run has to know whether the device takes that.

    The abort ends what an earlier client may have left running.
    """
    with channel.without_pause():
        channel.abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR)
        return _exchange(channel, device, UploadInitiate(DEVICE_TYPE))


def _learn_rest(channel: Channel, device: Device) -> None:
    """Find out how long a device needs behind an abort that has lost a read there and no other.

    Where another read is served there, a frame was lost.
    """
    for rest in (0.0, *RESTS):
        channel.rest_behind_abort = rest
        if _reads_behind_abort(channel, device):
            channel.rest_behind_abort = rest * SURE
            return
    _exchange(channel, device, UploadInitiate(DEVICE_TYPE))


def _exchange(channel: Channel, device: Device, request: Message) -> bool:
    device.baseline.clear()
    for position in range(MOST_SEGMENTS):
        sent = request.encode()
        channel.send(sent)
        frame = channel.receive()
        if frame is None:
            return False
        if isinstance(decode_response(frame.data), Abort):
            # Either the device has no 1000h, or it has answered the abort that went before.
            frame = channel.receive() or frame
        device.baseline.append((sent, whole_frame(frame.data)))
        match decode_response(frame.data):
            case UploadInitiateResponse(expedited=False) | UploadSegmentResponse(last=False):
                request = UploadSegment(toggle=position % 2)
            case _:
                break
    return True


def _silence(channel: Channel) -> str:
    timeout = channel.response_timeout * 1000
    heard = list(channel.overheard)
    own_format = [frame for frame in heard if not frame.extended and not frame.remote]
    alive = sorted(
        {
            frame.can_id - ERROR_CONTROL_BASE
            for frame in own_format
            if ERROR_CONTROL_BASE < frame.can_id < ERROR_CONTROL_BASE + 0x80
        }
    )
    booted = [
        frame.can_id - ERROR_CONTROL_BASE
        for frame in own_format
        if frame == error_control(frame.can_id - ERROR_CONTROL_BASE, NmtState.INITIALISING)
    ]
    lines = [
        f"Node {channel.node_id} does not answer.",
        f"  sent: {FIRST_TRIES} times a read of 1000h on {channel.ids.request} "
        f"({channel.ids.request.frame(UploadInitiate(DEVICE_TYPE).encode())}), "
        f"waiting {timeout:g} ms for {channel.ids.response} each time",
        f"  heard: {len(heard)} other frames"
        + (f"; nodes with heartbeat or boot-up: {', '.join(map(str, alive))}" if alive else "")
        + (f"; booted just now: {', '.join(map(str, booted))}" if booted else ""),
    ]
    lines += [f"    {frame}" for frame in heard[-5:]]
    lines.append(
        "  check: power and wiring, the bit rate (the same on all nodes), termination (60 ohm "
        "between CAN_H and CAN_L), the node-ID, and the NMT state (in Stopped a device must not "
        "answer)"
        if not alive
        else f"  check: is the node-ID {channel.node_id} right, is that node in NMT state Stopped?"
    )
    return "\n".join(lines)
