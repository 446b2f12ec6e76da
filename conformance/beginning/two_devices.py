"""Two devices with one node-ID: each request is answered twice, and each write done by both.

A device that sends every answer twice looks alike, unless what comes differs.
"""

from collections.abc import Iterator, Sequence

from conformance.beginning.plain_reads import end_read
from conformance.bus.channel import MOST_TALK, Channel
from conformance.bus.errors import TwoDevices
from conformance.device.device import DEVICE_TYPE, IDENTITY_COUNT, IDENTITY_NAMES, TEXTS, Device
from conformance.device.effort import READS_ONE_BEHIND
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import UploadInitiate, UploadInitiateResponse
from conformance.sdo.layout import Multiplexer

# Seconds within which a second answer follows the first: another device may be slower.
SECOND = 0.1
ASKED = (
    DEVICE_TYPE,
    IDENTITY_COUNT,
    *(Multiplexer(IDENTITY_COUNT.index, sub_index) for sub_index in IDENTITY_NAMES),
    *TEXTS,
)


def look_for_second(channel: Channel, device: Device) -> CanFrame | None:
    """Find out, behind a read of 1000h, whether that was answered once more.

    Returns the second answer of a device that has done so only there. Raises TwoDevices where there
    are two; where that cannot be told, the device is believed to answer twice.
    """
    channel.send(UploadInitiate(IDENTITY_COUNT))
    frame = channel.receive()
    if frame is None:
        return None
    if _is_about(frame, DEVICE_TYPE):
        examine(channel, device)
        learned = device.learned
        again = frame.data == device.baseline[0][1]
        return frame if again and not (learned.answers_twice or learned.is_behind) else None
    if not _names(frame, IDENTITY_COUNT):
        channel.until_quiet(SECOND)
    else:
        end_read(channel, frame, IDENTITY_COUNT)
    return None


def examine(channel: Channel, device: Device) -> None:
    """Read what tells devices apart, and take all answers; raises TwoDevices."""
    channel.until_quiet(SECOND)
    answers: list[list[CanFrame]] = []
    for mux in ASKED:
        frames = list(_answers(channel, mux))
        answers.append(frames)
        if len(answers) == READS_ONE_BEHIND and _are_behind(answers, device.baseline[0][1]):
            device.learned.is_behind = True
            return
        if not frames:
            break  # other reads will show that
        others = [frame for frame in frames if frame.data != frames[0].data]
        if others and all(_is_about(frame, mux) for frame in frames):
            raise TwoDevices(
                f"Two devices with node-ID {channel.node_id}? A read of {mux} has two "
                f"different answers: {frames[0]} and {others[0]}. Both devices would take each "
                "write. Give one of them another node-ID, or take it off the bus."
            )
    counts = [
        sum(_names(frame, mux) for frame in frames)
        for mux, frames in zip(ASKED, answers, strict=False)
    ]
    device.learned.answers_twice = min(counts) > 1


def _are_behind(answers: Sequence[Sequence[CanFrame]], of_first: bytes) -> bool:
    """Say whether each read was answered by what answers the one before it, ``of_first`` included.

    One that only repeats a multiplexer brings other data with it.
    """
    behind = answers[1:]
    return (
        all(len(frames) == 1 for frames in behind)
        and behind[0][0].data == of_first
        and all(_names(frames[0], mux) for mux, frames in zip(ASKED, behind, strict=False))
    )


def _answers(channel: Channel, mux: Multiplexer) -> Iterator[CanFrame]:
    channel.send(UploadInitiate(mux))
    wait = channel.response_timeout
    deadline = channel.link.deadline(wait + MOST_TALK)
    while not deadline.has_passed and (frame := channel.receive(wait)) is not None:
        wait = SECOND
        yield frame
        end_read(channel, frame, mux)


def _names(frame: CanFrame, mux: Multiplexer) -> bool:
    """Say whether a frame serves or refuses the read of an object."""
    return getattr(decode_response(frame.data), "mux", None) == mux


def _is_about(frame: CanFrame, mux: Multiplexer) -> bool:
    """Say whether a frame serves the read of an object."""
    response = decode_response(frame.data)
    return isinstance(response, UploadInitiateResponse) and response.mux == mux


def either(node_id: int) -> str:
    """Say what it may be that answers twice, where that cannot be told."""
    return (
        "every read has two identical answers: either the device sends both, or two devices have "
        f"node-ID {node_id}"
    )
