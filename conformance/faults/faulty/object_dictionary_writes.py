"""Servers that check wrongly what is written: lengths, limits, and who may write at all."""

from functools import partial

from conformance.device.numbers import encode_number
from conformance.faults import registry
from conformance.faults.faulty.expedited_download import SameValueRefused
from conformance.faults.registry import About, Defect
from conformance.reference.dictionary import MEASURED
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import BlockDownloadInitiate, DownloadInitiate, Request, Response
from conformance.sdo.objects import Entry, Refusal

fault = partial(registry.fault, about=About.OBJECTS)
SHORT = 4


@fault("present-value-refused", Defect.ACCESS_OR_SIZE, "od.write-back[2001h:00]")
class PresentValueRefused(SameValueRefused):
    """Refuses to write back what was read, by any protocol."""


@fault("strings-take-nothing", Defect.ACCESS_OR_SIZE, "od.write-back-in-segments")
class StringsTakeNothing(Server):
    """Refuses whatever is written to a string or domain as if the command were unknown."""

    def store(self, entry: Entry, data: bytes) -> None:
        if entry.data_type.length is None:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        super().store(entry, data)


@fault("short-values-refused-in-segments", Defect.ACCESS_OR_SIZE, "od.write-back-in-segments")
class ShortRefusedInSegments(Server):
    """Refuses segmented downloads of up to 4 bytes."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if size is not None and size <= SHORT:
            raise Refusal(AbortCode.COMMAND_NOT_VALID)
        super().check_announced_size(entry, size)


@fault("short-values-refused-in-blocks", Defect.ACCESS_OR_SIZE, "od.write-back-in-blocks")
class ShortRefusedInBlocks(Server):
    """Refuses block downloads of up to 4 bytes with another code than a server without blocks."""

    def on_block_download_initiate(self, request: BlockDownloadInitiate) -> list[Response]:
        if request.size is not None and request.size <= SHORT:
            raise Refusal(AbortCode.LENGTH_TOO_LOW)
        return super().on_block_download_initiate(request)


class _Lengths(Server):
    """Makes the length of numbers fit."""

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        """Take any."""


@fault("short-numbers-padded", Defect.FIELD_WIDTH, "od.too-short")
class ShortPadded(_Lengths):
    """Fills numbers up that come too short."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data.ljust(entry.shortest, b"\0"))


@fault("long-numbers-cut", Defect.FIELD_WIDTH, "od.too-long")
class LongCut(_Lengths):
    """Takes the low bytes of numbers that come too long."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data[: entry.longest])


@fault("long-numbers-kept", Defect.FIELD_WIDTH, "od.too-long")
class LongKept(_Lengths):
    """Stores all bytes of a number that come, however many its type has, and uploads them."""

    def store(self, entry: Entry, data: bytes) -> None:
        if entry.longest is None or len(data) <= entry.longest:
            super().store(entry, data)
        else:
            entry.value = data


class _Limits(Server):
    """Checks the limits of numbers in another way."""

    def store(self, entry: Entry, data: bytes) -> None:
        entry.check_length(len(data))
        self.store_number(entry, data)

    def store_number(self, entry: Entry, data: bytes) -> None:
        """Check what is to be checked and write."""
        entry.value = data


@fault("limits-not-checked", Defect.ACCESS_OR_SIZE, "od.above-limit")
class LimitsNotChecked(_Limits):
    """Takes any number, whatever the limits."""


@fault("low-limits-not-checked", Defect.ACCESS_OR_SIZE, "od.below-limit")
class LowLimitsNotChecked(_Limits):
    """Looks at high limits only."""

    def store_number(self, entry: Entry, data: bytes) -> None:
        if entry.high is not None and entry.number(data) > entry.high:
            raise Refusal(AbortCode.VALUE_TOO_HIGH)
        entry.value = data


@fault("limits-exclusive", Defect.ACCESS_OR_SIZE, "od.low-limit")
class LimitsExclusive(_Limits):
    """Refuses the limits themselves."""

    def store_number(self, entry: Entry, data: bytes) -> None:
        entry.check_limits(data)
        if entry.number(data) in (entry.low, entry.high):
            raise Refusal(AbortCode.VALUE_INVALID)
        entry.value = data


@fault("high-limit-one-too-low", Defect.ACCESS_OR_SIZE, "od.high-limit")
class HighLimitLow(_Limits):
    """Refuses the high limit."""

    def store_number(self, entry: Entry, data: bytes) -> None:
        if entry.high is not None and entry.number(data) >= entry.high:
            raise Refusal(AbortCode.VALUE_TOO_HIGH)
        entry.check_limits(data)
        entry.value = data


@fault("limits-clamp", Defect.ACCESS_OR_SIZE, "od.above-limit")
class LimitsClamp(_Limits):
    """Stores the limit instead of what lies beyond, and confirms."""

    def store_number(self, entry: Entry, data: bytes) -> None:
        number = before = entry.number(data)
        if entry.high is not None:
            number = min(number, entry.high)
        if entry.low is not None:
            number = max(number, entry.low)
        entry.value = data if number == before else encode_number(entry.data_type, number)


@fault("limits-checked-after-storing", Defect.ACCESS_OR_SIZE, "od.above-limit")
class LimitsCheckedLate(_Limits):
    """Refuses what lies beyond a limit, and has stored it all the same."""

    def store_number(self, entry: Entry, data: bytes) -> None:
        entry.value = data
        entry.check_limits(data)


@fault("limit-codes-swapped", Defect.ACCESS_OR_SIZE, "od.below-limit")
class LimitCodesSwapped(Server):
    """Says too low for too high, and the other way round."""

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        swapped = {
            AbortCode.VALUE_TOO_HIGH: AbortCode.VALUE_TOO_LOW,
            AbortCode.VALUE_TOO_LOW: AbortCode.VALUE_TOO_HIGH,
        }
        return super().refuse(request, swapped.get(code, code))


@fault("signed-limits-checked-unsigned", Defect.FIELD_WIDTH, "od.low-limit[2100h:02]")
class SignedAsUnsigned(_Limits):
    """Compares negative numbers with their limits as if they were large ones."""

    def store_number(self, entry: Entry, data: bytes) -> None:
        number = int.from_bytes(data, "little")
        if entry.high is not None and number > entry.high:
            raise Refusal(AbortCode.VALUE_TOO_HIGH)
        entry.check_limits(data)
        entry.value = data


@fault("read-only-entries-written", Defect.ACCESS_OR_SIZE, "od.read-only[1001h:00]")
class ReadOnlyWritten(Server):
    """Does not look at who may write."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        return self.objects.find(request.mux)

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        return self.objects.find(request.mux)


@fault("read-only-checked-in-one-frame-only", Defect.ACCESS_OR_SIZE, "od.read-only-in-segments")
class CheckedWhenExpedited(Server):
    """Looks at who may write in expedited downloads only."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        if request.expedited:
            return super().entry_to_write(request)
        return self.objects.find(request.mux)


@fault("read-only-not-checked-in-blocks", Defect.ACCESS_OR_SIZE, "od.read-only-in-blocks")
class NotCheckedInBlocks(Server):
    """Looks at who may write in all but block downloads."""

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        return self.objects.find(request.mux)


@fault("measured-value-written", Defect.ACCESS_OR_SIZE, "od.read-only[2130h:00]")
class MeasuredWritten(Server):
    """Protects constants, and lets measured values be written."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        if request.mux.index == MEASURED:
            return self.objects.find(request.mux)
        return super().entry_to_write(request)
