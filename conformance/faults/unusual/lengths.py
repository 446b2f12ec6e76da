"""Servers that are right in which strings and domains they have, and how long these are."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About
from conformance.faults.unusual.abort import OtherCodes
from conformance.reference.dictionary import all_entries
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import BlockDownloadInitiate, DownloadInitiate, Request, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType, Entry, ObjectDictionary, Refusal

unusual = partial(registry.unusual, about=About.LENGTHS)
# A size whose upper half such a server looks at, and no size that nobody could have.
BEYOND_16_BITS = range(1 << 16, 1 << 24)
STRING, DOMAIN = Multiplexer(0x2010), Multiplexer(0x2011)
_VARYING = frozenset(
    mux
    for mux, entry in all_entries(1).items()
    if entry.data_type.length is None and entry.access.writable
)


class AlteredObjects(Server):
    """Changes the writable strings and domains before the first request."""

    def __init__(self, objects: ObjectDictionary) -> None:
        """Change them; each channel has a server on the same objects."""
        super().__init__(objects)
        for entry in objects:
            if entry.data_type.length is None and entry.access.writable:
                self.alter(entry)

    def alter(self, entry: Entry) -> None:
        """Leave it as it is."""


class SmallBuffer(AlteredObjects):
    """Has room for a few bytes in strings and domains."""

    capacity = 0

    def alter(self, entry: Entry) -> None:
        entry.capacity = self.capacity


@unusual("strings-of-4-bytes")
class StringsOf4(SmallBuffer):
    """Has room for 4 bytes in strings and domains: none is ever transferred in two segments."""

    capacity = 4


@unusual("strings-of-8-bytes")
class StringsOf8(SmallBuffer):
    """Has room for 8 bytes in strings and domains."""

    capacity = 8


@unusual("strings-of-13-bytes")
class StringsOf13(SmallBuffer):
    """Has room for 13 bytes in strings and domains."""

    capacity = 13


@unusual("strings-of-19-bytes")
class StringsOf19(SmallBuffer):
    """Has room for 19 bytes in strings and domains."""

    capacity = 19


@unusual("strings-of-20-bytes")
class StringsOf20(SmallBuffer):
    """Has room for 20 bytes in strings and domains."""

    capacity = 20


@unusual("strings-of-8-bytes-domains-of-4200")
class StringsOf8DomainsOf4200(SmallBuffer):
    """Has room for 8 bytes in strings, and for 4,200 in domains."""

    def alter(self, entry: Entry) -> None:
        entry.capacity = 4200 if entry.data_type is DataType.DOMAIN else 8


@unusual("domains-of-8-bytes-strings-of-300")
class DomainsOf8StringsOf300(SmallBuffer):
    """Has room for 8 bytes in domains, and for 300 in strings."""

    def alter(self, entry: Entry) -> None:
        entry.capacity = 8 if entry.data_type is DataType.DOMAIN else 300


class _FixedLength(AlteredObjects):
    """Takes strings and domains in one length only."""

    length = 0

    def alter(self, entry: Entry) -> None:
        """Fill the value up once, and keep to its length."""
        if entry.fewest != self.length:
            is_wide = entry.data_type is DataType.UNICODE_STRING
            value = "0".encode("utf-16-le") * self.length if is_wide else entry.value
            entry.value = value.ljust(self.length, b"0")[: self.length]
        entry.capacity = entry.fewest = self.length


@unusual("values-of-fixed-length")
class FixedLength(_FixedLength):
    """Takes 24 bytes in strings and domains, no more and no fewer."""

    length = 24


@unusual("values-of-fixed-length-8")
class FixedLength8(_FixedLength):
    """Takes 8 bytes in strings and domains, no more and no fewer."""

    length = 8


@unusual("values-of-fixed-length-300")
class FixedLength300(_FixedLength):
    """Takes 300 bytes in strings and domains, no more and no fewer."""

    length = 300


@unusual("values-of-fixed-length-64")
class FixedLength64(_FixedLength):
    """Takes 64 bytes in strings and domains, and says 06070010h of fewer as of more."""

    length = 64

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if code in (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_TOO_LOW):
            code = AbortCode.LENGTH_MISMATCH
        return super().refuse(request, code)


@unusual("strings-of-64-bytes-very-long-ones-incompatible")
class StringsOf64(SmallBuffer):
    """Has room for 64 bytes, and calls a size of more than 16 bits an internal incompatibility."""

    capacity = 64

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        if size in BEYOND_16_BITS and entry.data_type.length is None:
            raise Refusal(AbortCode.INTERNALLY_INCOMPATIBLE)
        super().check_announced_size(entry, size)


@unusual("values-of-fixed-length-650")
class FixedLength650(_FixedLength):
    """Takes 650 bytes in strings and domains: too many for each of hundreds of cases."""

    length = 650


@unusual("values-of-fixed-length-06070010")
class FixedLengthGeneric(_FixedLength):
    """Takes 14 bytes in strings and domains, and says "length does not match" of all else."""

    length = 14

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if code in (AbortCode.LENGTH_TOO_HIGH, AbortCode.LENGTH_TOO_LOW):
            code = AbortCode.LENGTH_MISMATCH
        return super().refuse(request, code)


@unusual("lengths-in-steps-of-4")
class LengthsInSteps(AlteredObjects):
    """Takes OCTET_STRINGs and domains of 4, 8, 12 and so on bytes only: what takes 20 takes no 19.

    How long a value is it may learn with its last byte only.
    """

    kinds = (DataType.OCTET_STRING, DataType.DOMAIN)

    def alter(self, entry: Entry) -> None:
        if entry.data_type in self.kinds:
            entry.value += bytes(-len(entry.value) % 4)

    def check_announced_size(self, entry: Entry, size: int | None) -> None:
        super().check_announced_size(entry, size)
        self.check_step(entry, size or 0)

    def store(self, entry: Entry, data: bytes) -> None:
        self.check_step(entry, len(data))
        super().store(entry, data)

    def check_step(self, entry: Entry, size: int) -> None:
        """Refuse other lengths of what is neither a number nor a text."""
        if entry.data_type in self.kinds and size % 4:
            raise Refusal(AbortCode.LENGTH_MISMATCH)


@unusual("octet-strings-of-fixed-length")
class FixedOctets(_FixedLength):
    """Takes 16 bytes in OCTET_STRINGs, no more and no fewer."""

    length = 16

    def alter(self, entry: Entry) -> None:
        if entry.data_type is DataType.OCTET_STRING:
            super().alter(entry)


@unusual("one-domain", lacking=_VARYING - {DOMAIN})
class OneDomain(Server):
    """Has a domain and no string that may be written."""


@unusual("one-octet-string", lacking=_VARYING - {STRING})
class OneOctetString(AlteredObjects):
    """Has an OCTET_STRING, and neither another string nor a domain that may be written."""

    def alter(self, entry: Entry) -> None:
        entry.data_type = DataType.OCTET_STRING


@unusual("one-octet-string-of-fixed-length", lacking=_VARYING - {STRING})
class OneFixedOctetString(_FixedLength):
    """Has an OCTET_STRING that takes 20 bytes, no more and no fewer, and nothing else like it."""

    length = 20

    def alter(self, entry: Entry) -> None:
        super().alter(entry)
        entry.data_type = DataType.OCTET_STRING


@unusual("no-strings-nor-domains", lacking=_VARYING)
class NoStrings(Server):
    """Has numbers only: no string and no domain may be written."""


@unusual("strings-of-300-bytes-out-of-memory")
class StringsOf300(SmallBuffer, OtherCodes):
    """Has room for 300 bytes in strings and domains, and calls more out of memory."""

    capacity = 300
    codes = {AbortCode.LENGTH_TOO_HIGH: AbortCode.OUT_OF_MEMORY}

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        if isinstance(request, DownloadInitiate) and (request.size or 0) > self.capacity:
            entry = self.objects.find(request.mux) if code is AbortCode.LENGTH_TOO_HIGH else None
            if entry and entry.data_type.length is None:
                return super().refuse(request, code)
        return Server.refuse(self, request, code)


@unusual("strings-of-100-bytes")
class StringsOf100(Server):
    """Has room for 100 bytes in strings and domains, in segments and in blocks."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        entry = super().entry_to_write(request)
        entry.capacity = 100
        return entry

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        entry = super().entry_to_write_in_blocks(request)
        entry.capacity = 100
        return entry


class _LongDomain(AlteredObjects):
    """Has a domain that holds much."""

    size: int

    def alter(self, entry: Entry) -> None:
        if entry.data_type is DataType.DOMAIN:
            entry.value = (bytes(range(251)) * (self.size // 251 + 1))[: self.size]


@unusual("domain-of-65536-bytes")
class DomainOf65536(_LongDomain):
    """Has a domain of 64 KB, as for a program."""

    size = 1 << 16


@unusual("domain-of-two-megabytes")
class DomainOfTwoMegabytes(_LongDomain):
    """Has a domain of 2 MB, more than anybody would read in segments."""

    size = 2_000_000


class _Adapting(AlteredObjects):
    """Keeps strings in a buffer: values are made to fit, not refused."""

    longest = 20

    def alter(self, entry: Entry) -> None:
        if entry.data_type is DataType.VISIBLE_STRING:
            entry.value = self.adapted(entry.value)

    def adapted(self, data: bytes) -> bytes:
        """Return what is kept of a value."""
        raise NotImplementedError

    def store(self, entry: Entry, data: bytes) -> None:
        if entry.data_type is DataType.VISIBLE_STRING:
            data = self.adapted(data)
        super().store(entry, data)


@unusual("strings-cut-to-20-bytes", soft=True)
class CutTo20(_Adapting):
    """Takes strings of any length, and keeps their first 20 bytes."""

    def adapted(self, data: bytes) -> bytes:
        return data[: self.longest]


@unusual("one-string-padded-with-blanks-and-cut", soft=True, lacking=_VARYING - {STRING})
class PaddedAndCut(_Adapting):
    """Has one string, fills it up with blanks to 20 bytes, and cuts what is longer."""

    def adapted(self, data: bytes) -> bytes:
        return data[: self.longest].ljust(self.longest)


@unusual("one-string-cut-and-empty-as-00h", soft=True, lacking=_VARYING - {STRING})
class CutAndEmptyAs00(_Adapting):
    """Has one string, cuts it to 20 bytes, and reads it as 00h while it is empty."""

    def adapted(self, data: bytes) -> bytes:
        return data[: self.longest] or b"\0"
