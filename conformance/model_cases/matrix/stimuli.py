"""What a server gets in each of its states: every command specifier in every variation.

The labels are the ids of cases: a byte 0 as the field writes it, then what varies. Where a frame
carries a multiplexer it is that of the object that the state is about, if nothing else is said.
"""

from collections.abc import Callable
from dataclasses import dataclass

from conformance.dialogue.payload import mux_bytes
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.frames import (
    Abort,
    BlockAck,
    BlockDownloadInitiate,
    BlockEnd,
    BlockEndResponse,
    BlockSegment,
    BlockUploadInitiate,
    BlockUploadStart,
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
    UploadSegment,
)
from conformance.sdo.layout import Message, Multiplexer

READ_ONLY = Multiplexer(0x1000)
OTHER = Multiplexer(0x1018, 1)
TEXT = b"ABCDEFG"
RESERVED = bytes(range(1, 5))
HUGE = 0xFFFF_FFFF


@dataclass(frozen=True, slots=True)
class Targets:
    """The objects that stimuli name: that of the state, and entries that the device lacks.

    ``device_type`` is what the device reads at 1000h: a wrong device takes what is written there.
    """

    node_id: int
    own: Multiplexer
    missing: Multiplexer
    missing_sub_index: Multiplexer
    device_type: bytes

    @property
    def there(self) -> tuple[Multiplexer, ...]:
        """What a stimulus may name and the device has."""
        return (self.own, READ_ONLY, OTHER)


Stimulus = Callable[[Targets], CanFrame]


def _request(data: bytes, targets: Targets) -> CanFrame:
    return CanFrame(REQUEST_BASE + targets.node_id, data)


def _always(message: Message | bytes) -> Stimulus:
    data = message if isinstance(message, bytes) else message.encode()
    return lambda targets: _request(data, targets)


def _about(make: Callable[[Targets], Message]) -> Stimulus:
    return lambda targets: _request(make(targets).encode(), targets)


def _raw(command: int, body: bytes = bytes(4)) -> Stimulus:
    """Put any byte 0 before the multiplexer of the state's object."""

    def make(targets: Targets) -> CanFrame:
        data = bytearray(UploadInitiate(targets.own).encode())
        data[0] = command
        data[4:] = body
        return _request(bytes(data), targets)

    return make


def _cut(stimulus: Stimulus, length: int) -> Stimulus:
    def make(targets: Targets) -> CanFrame:
        whole = stimulus(targets)
        return CanFrame(whole.can_id, whole.data[:length])

    return make


def _initiates() -> dict[str, Stimulus]:
    found: dict[str, Stimulus] = {
        "20h": _about(lambda targets: DownloadInitiate.with_size(targets.own, None)),
        "21h-size-20": _about(lambda targets: DownloadInitiate.with_size(targets.own, 20)),
        "21h-size-0": _about(lambda targets: DownloadInitiate.with_size(targets.own, 0)),
        "21h-size-FFFFFFFFh": _about(lambda targets: DownloadInitiate.with_size(targets.own, HUGE)),
        "22h": _about(lambda targets: DownloadInitiate.with_uncounted_data(targets.own, b"wxyz")),
        "20h-reserved": _raw(0x20, RESERVED),
        "40h": _about(lambda targets: UploadInitiate(targets.own)),
        "40h-1000h": _always(UploadInitiate(READ_ONLY)),
        "40h-other": _always(UploadInitiate(OTHER)),
        "40h-missing": _about(lambda targets: UploadInitiate(targets.missing)),
        "40h-missing-sub-index": _about(lambda targets: UploadInitiate(targets.missing_sub_index)),
        "40h-reserved": _raw(0x40, RESERVED),
        "23h-read-only": _about(
            lambda targets: DownloadInitiate.with_data(READ_ONLY, targets.device_type)
        ),
        "21h-read-only": _always(DownloadInitiate.with_size(READ_ONLY, 4)),
        "23h-missing": _about(lambda targets: DownloadInitiate.with_data(targets.missing, b"wxyz")),
    }
    for length in (1, 2, 3, 4):
        label = f"{DownloadInitiate.with_data(OTHER, TEXT[:length]).encode()[0]:02X}h"
        found[label] = _expedited(length)
        if length < len(RESERVED):
            # The bytes that n takes away are there all the same.
            found[f"{label}-filled"] = _raw(int(label[:2], 16), b"wxyz")
    for command in (0x24, 0x25, 0x26, 0x2E, 0x30, 0x31, 0x33, 0x3F):
        found[f"{command:02X}h"] = _raw(command, b"wxyz" if command & 2 else bytes(4))
    found |= {f"{command:02X}h": _raw(command) for command in (0x41, 0x48, 0x50, 0x5F)}
    return found


def _expedited(length: int) -> Stimulus:
    return _about(lambda targets: DownloadInitiate.with_data(targets.own, b"wxyz"[:length]))


def _segments() -> dict[str, Stimulus]:
    found: dict[str, Stimulus] = {}
    for toggle in (0, 1):
        for last in (False, True):
            for unused in (0, 1, 5, 7):
                message = DownloadSegment.with_data(TEXT[unused:], toggle=toggle, last=last)
                found[f"{message.encode()[0]:02X}h"] = _always(message)
    found["03h-filled"] = _always(b"\x03" + TEXT)
    for command in (0x60, 0x70, 0x61, 0x6F, 0x71, 0x7F):
        found[f"{command:02X}h"] = _always(bytes([command, *bytes(7)]))
    for toggle in (0, 1):
        filled = UploadSegment(toggle).encode()[:1]
        found[f"{filled[0]:02X}h-reserved"] = _always(filled + TEXT)
        found[f"{filled[0]:02X}h-multiplexer"] = _raw(filled[0])
    return found


def _block_segments(*sequences: int) -> dict[str, Stimulus]:
    """Within a sub-block byte 0 is a sequence number: 40h is segment 64, E0h the last, 96."""
    found: dict[str, Stimulus] = {}
    for sequence in sequences:
        for last in (False, True):
            if sequence or not last:  # 80h is an abort
                label = f"segment-{sequence}{'-last' if last else ''}"
                found[label] = _block_segment(sequence, last=last)
    return found


def _block_segment(sequence: int, *, last: bool) -> Stimulus:
    """Return a segment that names, where it could be an initiate, what the device lacks."""

    def make(targets: Targets) -> CanFrame:
        data = TEXT if sequence < 32 else mux_bytes(targets.missing) + TEXT[3:]
        return _request(BlockSegment.with_data(sequence, data, last=last).encode(), targets)

    return make


def _aborts() -> dict[str, Stimulus]:
    code = AbortCode.GENERAL_ERROR
    return {
        "80h": _about(lambda targets: Abort(targets.own, code)),
        "80h-code-0": _about(lambda targets: Abort(targets.own, 0)),
        "80h-other": _always(Abort(OTHER, code)),
        "80h-zeros": _always(bytes([0x80, *bytes(7)])),
        "81h": _raw(0x81, code.to_bytes(4, "little")),
        "9Fh": _raw(0x9F, code.to_bytes(4, "little")),
    }


def _block_downloads() -> dict[str, Stimulus]:
    found: dict[str, Stimulus] = {
        f"{0xC0 | crc << 2 | (size is not None) << 1:02X}h" + label: _block_initiate(size, crc=crc)
        for crc in (False, True)
        for size, label in ((None, ""), (20, "-size-20"))
    }
    found["C6h-size-0"] = _block_initiate(0, crc=True)
    found["C6h-size-FFFFFFFFh"] = _block_initiate(HUGE, crc=True)
    found |= {f"{command:02X}h": _raw(command) for command in (0xC8, 0xD0, 0xDE)}
    found["C4h-read-only"] = _always(BlockDownloadInitiate.with_size(READ_ONLY, None))
    found["C4h-missing"] = _about(
        lambda targets: BlockDownloadInitiate.with_size(targets.missing, None)
    )
    for unused in range(8):
        end = BlockEnd(unused)
        found[f"{end.encode()[0]:02X}h-crc-0"] = _always(end)
    found["C5h-crc-FFFFh"] = _always(BlockEnd(1, 0xFFFF))
    found["C3h"] = _always(bytes([0xC3, *bytes(7)]))
    found["C5h-reserved"] = _always(bytes([0xC5, 0, 0, *RESERVED, 5]))
    return found


def _block_initiate(size: int | None, *, crc: bool) -> Stimulus:
    return _about(
        lambda targets: BlockDownloadInitiate.with_size(targets.own, size, crc_supported=crc)
    )


def _block_uploads() -> dict[str, Stimulus]:
    found: dict[str, Stimulus] = {}
    for block_size in (0, 1, 2, 127, 128, 255):
        for threshold in (0, 255):
            request = _block_upload(block_size, threshold)
            found[f"A4h-blksize-{block_size}-pst-{threshold}"] = request
    found["A0h"] = _about(lambda targets: BlockUploadInitiate(targets.own, 127, 0, False))
    found["A4h-missing"] = _about(lambda targets: BlockUploadInitiate(targets.missing, 127))
    found["A4h-other"] = _always(BlockUploadInitiate(OTHER, 127))
    for command in (0xA8, 0xB0, 0xBC):
        found[f"{command:02X}h"] = _raw(command, bytes([127, 0, 0, 0]))
    for command in (0xA5, 0xA7, 0xB3, 0xB6):
        found[f"{command:02X}h"] = _always(bytes([command, 1, 127, *bytes(5)]))
    for sequence in (0, 1, 2, 3, 127, 128, 255):
        found[f"A2h-ackseq-{sequence}"] = _always(BlockAck(sequence, 2))
    for block_size in (0, 1, 127, 128, 255):
        for sequence in (1, 2):
            ack = BlockAck(sequence, block_size)
            found[f"A2h-ackseq-{sequence}-blksize-{block_size}"] = _always(ack)
    found["A2h-reserved"] = _always(bytes([0xA2, 2, 2, *RESERVED, 5]))
    found["A1h"] = _always(BlockEndResponse())
    found["A1h-reserved"] = _always(b"\xa1" + TEXT)
    found["A3h"] = _always(BlockUploadStart())
    found["A3h-reserved"] = _always(b"\xa3" + TEXT)
    return found


def _block_upload(block_size: int, threshold: int) -> Stimulus:
    return _about(lambda targets: BlockUploadInitiate(targets.own, block_size, threshold))


def _unknown() -> dict[str, Stimulus]:
    return {f"{command:02X}h": _raw(command) for command in (0xE0, 0xE1, 0xEF, 0xF0, 0xFF)}


def _shapes() -> dict[str, Stimulus]:
    """Frames that are not of 8 bytes, or not for this server."""
    whole = {
        "40h": _about(lambda targets: UploadInitiate(targets.own)),
        "23h": _expedited(4),
        "21h": _about(lambda targets: DownloadInitiate.with_size(targets.own, 20)),
        "01h": _always(DownloadSegment.with_data(TEXT, toggle=0, last=True)),
        "10h": _always(DownloadSegment.with_data(TEXT, toggle=1)),
        "60h": _always(UploadSegment(0)),
        "80h": _about(lambda targets: Abort(targets.own, AbortCode.GENERAL_ERROR)),
        "A2h": _always(BlockAck(2, 2)),
    }
    found = {
        f"{label}-dlc-{length}": _cut(stimulus, length)
        for label, stimulus in whole.items()
        # A careless device may write to whatever it reads where the multiplexer is not.
        for length in ((4, 7) if label in ("21h", "23h") else (1, 4, 7))
    }
    found["dlc-0"] = _always(b"")
    found |= {f"40h-dlc-{length}": _cut(whole["40h"], length) for length in (2, 3, 5, 6)}
    for length in (0, 8):
        found[f"remote-{length}"] = _remote(length)
    for label in ("40h", "60h", "80h"):
        found[f"{label}-extended"] = _extended(whole[label])
    # Another node may well be there: it is only asked for what every node has.
    found["40h-other-node"] = lambda targets: CanFrame(
        REQUEST_BASE + (targets.node_id ^ 0x40 or 1), UploadInitiate(READ_ONLY).encode()
    )
    return found


def _remote(length: int) -> Stimulus:
    return lambda targets: CanFrame(REQUEST_BASE + targets.node_id, remote=True, length=length)


def _extended(stimulus: Stimulus) -> Stimulus:
    def make(targets: Targets) -> CanFrame:
        whole = stimulus(targets)
        return CanFrame(whole.can_id, whole.data, extended=True)

    return make


_AT_ALL_TIMES = {**_aborts(), **_shapes()}
STIMULI: dict[str, Stimulus] = {
    **_initiates(),
    **_segments(),
    **_block_downloads(),
    **_block_uploads(),
    **_unknown(),
    **_AT_ALL_TIMES,
}
SUB_BLOCK_STIMULI: dict[str, Stimulus] = {
    **_block_segments(0, 1, 2, 3, 4, 5, 32, 33, 64, 70, 96, 97, 126, 127),
    **_AT_ALL_TIMES,
}
# A server expects the same behind a sub-block as before the first, but the way there is long.
NEXT_SUB_BLOCK_STIMULI: dict[str, Stimulus] = {
    label: SUB_BLOCK_STIMULI[label] for label in (*_block_segments(0, 1), "segment-2-last", "80h")
}
