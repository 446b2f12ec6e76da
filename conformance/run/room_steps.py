"""How much a string or domain takes: found out by writing, and remembered for the run."""

from conformance.device.device import NotTestable
from conformance.device.objects import KnownObject
from conformance.run.payload import MOST_PLAIN
from conformance.run.steps import Steps, shown
from conformance.run.stimuli import BEYOND_16_BITS
from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.describe import describe_response
from conformance.sdo.frames import Abort
from conformance.sdo.objects import DataType
from conformance.sdo.rules import NOT_REFUSED, Violation

MUCH_ROOM = 4096
NO_ROOM = (
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_LOW,
    AbortCode.OUT_OF_MEMORY,
)


class RoomSteps(Steps):
    """Writes to objects that may be too small for what is written."""

    def store(
        self,
        known: KnownObject,
        data: bytes,
        *,
        segmented: bool | None = None,
        sized: bool = True,
    ) -> None:
        """Write ``data`` to a string or domain that may be too small for it.

        Raises NotTestable when the object is too small. A device that refuses this length and
        takes a longer one is at fault.
        """
        abort = self.try_download(known, data, segmented=segmented, sized=sized)
        if abort is None:
            return
        if abort.code not in NO_ROOM or self._takes_otherwise(known, data):
            raise Violation(
                NOT_REFUSED,
                expected=f"a download of {len(data)} bytes to {known}, as another way",
                actual=describe_response(abort.encode()),
            )
        raise self.no_room(known, len(data), abort)

    def need_room(self, known: KnownObject, size: int) -> None:
        """Raise NotTestable unless a string or domain takes ``size`` bytes.

        Most devices are asked once in a run, for more room than most cases need. The object has
        its own value again then.
        """
        room = self.device.room
        if self.has_room(known, size):
            return
        if known.mux not in room:
            much = MUCH_ROOM if self.device.nowhere else MOST_PLAIN
            served = self.try_download(known, self.payload(much), segmented=True) is None
            room[known.mux] = much if served else 0
        if room[known.mux] < size:
            self.store(known, self.payload(size), segmented=True)
            room[known.mux] = size
        self.download(known, self.device.values[known.mux])

    def has_room(self, known: KnownObject, size: int) -> bool:
        """Say whether an object has taken ``size`` bytes or more in this run."""
        return self.device.room.get(known.mux, 0) >= size

    def no_room(self, known: KnownObject, size: int, abort: Abort) -> NotTestable | Violation:
        """Build what a refusal of so many bytes means: too small an object, or a breach."""
        if abort.code not in NO_ROOM:
            return Violation(
                NOT_REFUSED,
                expected=f"a download of {size} bytes to {known}, or that it is too small",
                actual=describe_response(abort.encode()),
            )
        return NotTestable(
            f"{known} has no room for {size} bytes (refused with "
            f"{describe_code(abort.code)}): name a larger string or domain"
        )

    def _takes_otherwise(self, known: KnownObject, data: bytes) -> bool:
        """Say whether an object that refused a download takes a longer one, or one without size."""
        longer = self.payload(len(data) + 1)
        return (
            self.try_download(known, longer, segmented=True) is None
            or self.try_download(known, data, segmented=True, sized=False) is None
        )

    def expect_empty(self, known: KnownObject, found: bytes, before: int) -> None:
        """Expect an empty value to read as nothing or as one byte 00h.

        A string may be filled up to its fixed length, no shorter than the ``before`` bytes that it
        read last.
        """
        filled = known.data_type is DataType.VISIBLE_STRING and len(found) >= before
        if found.strip(b"\0") or (len(found) > 1 and not filled):
            raise self.breach(f"{known} reads as nothing, or as one byte 00h", shown(found))

    def huge_object(self) -> tuple[KnownObject, bytes]:
        """Return an object of more bytes than 16 bits count, and its value.

        That is what reads so long by itself, else what takes so many bytes, in segments or in
        blocks; two segments begin behind the byte where a counter wraps.
        """
        size = BEYOND_16_BITS + 8
        for known in self.device.objects:
            data = self.device.values.get(known.mux, b"")
            if len(data) >= BEYOND_16_BITS and known.is_steady:
                return known, data
        known, data = self.device.variable(), self.payload(size)
        abort = self.try_download(known, data, segmented=True)
        if abort is not None:
            in_blocks = self.client.block_download(known.mux, data)
            if abort.code not in NO_ROOM or self.abort_of(in_blocks) is not None:
                raise self.no_room(known, size, abort)
        return known, data

    def long_object(self, segments: int = 3) -> tuple[KnownObject, bytes]:
        """Return an object whose upload takes so many segments or more, and its value.

        That is a string or domain that may be written, else what reads long enough by itself.
        """
        needed = 7 * (segments - 1) + 1
        try:
            known = self.device.variable()
            data = self.payload(7 * segments - 1)
            self.store(known, data)
        except NotTestable:
            for known in self.device.objects:
                data = self.device.values.get(known.mux, b"")
                if len(data) >= needed:
                    return known, data
            raise NotTestable(
                f"needs an object of {needed} bytes or more: name a string or domain, "
                "--object=2010=visible_string or in device.toml [objects] writable = "
                '["2010=visible_string"]'
            ) from None
        return known, data
