"""Which object of a device suits a case: by what it is, what it holds and what may be written."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from math import inf

from conformance.device.device import THREE_SEGMENTS, Device
from conformance.device.effort import SHORT_VALUE, THOUSANDS_OF_SEGMENTS
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.protected_objects import group_of
from conformance.device.serving import Refused, Service
from conformance.device.suggestions import Fits, lacking
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType

_NOT_PLAIN = (DataType.BOOLEAN, DataType.REAL32, DataType.REAL64)


@dataclass(frozen=True, slots=True)
class Roles:
    """The objects of a device that cases ask for; each raises NotTestable where there is none."""

    device: Device

    def number(self, length: int | None = None) -> KnownObject:
        """Return a writable number of ``length`` bytes, or the first of 4, 2, 1, 8 bytes."""
        lengths = (4, 2, 1, 8, 3, 5, 6, 7) if length is None else (length,)
        found = self.all_writable(_may_be_plain)
        for wanted in lengths:
            for known in found:
                if _is_plain(known, wanted):
                    return known
        kind = f"unsigned{8 * (length or 4)}"
        size = "" if length is None else f" of {length} byte{'s' * (length > 1)}"
        raise self._lacking(
            f"a writable number{size}",
            f"2001={kind}",
            *(partial(_is_plain, length=wanted) for wanted in lengths),
        )

    def longest_number(self) -> KnownObject:
        """Return the writable number that has the most bytes."""
        found = [known for known in self.all_writable() if known.length in (2, 4, 8)]
        plain = [known for known in found if known.data_type not in _NOT_PLAIN]
        return max(plain, key=lambda known: known.length or 0) if plain else self.number()

    def variable(self, size: int = THREE_SEGMENTS) -> KnownObject:
        """Return a writable string or domain for values of ``size`` bytes, or of a few segments.

        If possible its bytes count to the last 00h. An object that was found to be shorter comes
        last, and a much longer one before it: if it always reads so, it costs its whole length with
        each value; if not, its own long value is put back.
        """
        found = self.all_writable(_takes_any_bytes)
        for known in sorted(found, key=partial(self._last_for_transfers, size=size)):
            if size > SHORT_VALUE:
                self.device.learned.lengths[known.mux].check_lasting(known, size)
            return known
        raise self._lacks_text()

    def _last_for_transfers(
        self, known: KnownObject, size: int
    ) -> tuple[bool, bool, float, bool, bool]:
        large = self.device.permits.large
        is_large = large is not None and known.mux == large.mux
        lengths = self.device.learned.lengths[known.mux]
        is_short = lengths.most is not None and lengths.most < size
        is_few = size <= SHORT_VALUE
        is_longer = self.is_long(known) if is_few else self._is_very_long(known) and not is_large
        shortness = -inf if lengths.most is None else -lengths.most
        is_text = known.data_type is DataType.VISIBLE_STRING
        return is_short, is_longer, shortness, not is_large, is_text

    def is_long(self, known: KnownObject) -> bool:
        """Say whether an object costs many requests, however short what is written to it."""
        return self.device.learned.lengths[known.mux].least > SHORT_VALUE or self._is_very_long(
            known
        )

    def _is_very_long(self, known: KnownObject) -> bool:
        return len(self.device.values[known.mux]) > THOUSANDS_OF_SEGMENTS

    def text(self) -> KnownObject:
        """Return a writable string: of a domain, an aborted write may leave a part behind.

        A domain has to do where there is no string, or none that takes three segments.
        """
        for known in self.varying():
            return known
        raise self._lacks_text()

    def varying(self) -> list[KnownObject]:
        """Return the writable strings and domains, strings first."""
        found = self.all_writable(_takes_any_bytes)
        return sorted(found, key=self._last_for_short_transfers)

    def _last_for_short_transfers(self, known: KnownObject) -> tuple[bool, bool, bool]:
        lengths = self.device.learned.lengths[known.mux]
        is_short = lengths.most is not None and lengths.most < THREE_SEGMENTS
        return is_short, self.is_long(known), known.data_type is DataType.DOMAIN

    def _lacks_text(self) -> NotTestable:
        lacks = self._lacking(
            "a writable string or domain",
            "2010=visible_string",
            lambda known: _takes_any_bytes(known) and known.access is Access.RW,
        )
        for mux, why in self.device.learned.unreadable.items():
            if self.device.learned.serving.refusal(Service.UPLOAD, mux):
                continue  # it was said
            known = self.device.known.get(mux)
            if known is not None and _takes_any_bytes(known) and self.device.policy.permits(mux):
                words = f"{lacks}; {mux} would do, but could not be read: {why}"
                return NotTestable(words, lacks.missing)
        return lacks

    def write_only(self) -> KnownObject:
        """Return a write-only object."""
        for known in self.device.objects:
            if known.access is Access.WO and self.device.policy.permits(known.mux):
                return known
        raise self._lacking(
            "a write-only object", "2020=unsigned32,wo", lambda known: known.access is Access.WO
        )

    def read_only_text(self) -> KnownObject:
        """Return a read-only object of more than 4 bytes."""
        for known in self.device.objects:
            value = self.device.values.get(known.mux, b"")
            # Only to write to it takes a permission.
            probed = not known.access.writable and (
                self.device.policy.permits(known.mux) or self.device.policy.needs_probes(known.mux)
            )
            if probed and len(value) > 4:
                return known
        raise self._lacking(
            "a read-only object longer than 4 bytes, as 1008h, 1009h and 100Ah are not",
            "2021=visible_string,ro",
            lambda known: (
                not known.access.writable and len(self.device.values.get(known.mux, b"")) > 4
            ),
        )

    def writable_variable(self) -> KnownObject:
        """Return a writable object that has sub-index 0 only, a number if there is one."""
        found = [known for known in self.all_writable() if self.device.is_variable(known)]
        for known in sorted(found, key=lambda known: known.varies):
            return known
        raise self._lacking(
            "a writable variable of more than a byte",
            "2004=unsigned32",
            lambda known: known.access is Access.RW and self.device.is_variable(known),
        )

    def writable(self) -> KnownObject:
        """Return any object that may be written and was read."""
        for known in self.all_writable():
            return known
        raise self._lacks_any("a writable object")

    def two_writable(self) -> tuple[KnownObject, KnownObject]:
        """Return two objects that may be written and were read, strings and domains first.

        Objects whose value is always long come last.
        """
        found = sorted(
            self.all_writable(), key=lambda known: (self.is_long(known), not known.varies)
        )
        if len(found) < 2:
            raise self._lacks_any(
                "two writable objects" if not found else "another writable object"
            )
        return found[0], found[1]

    def _lacks_any(self, what: str) -> NotTestable:
        return self._lacking(what, "2001=unsigned8", lambda known: known.access is Access.RW)

    def _lacking(self, what: str, example: str, *fits: Fits) -> NotTestable:
        refused = self._refused_by_state(fits)
        if refused is not None:
            way_out = self.device.learned.serving.way_out(refused, self.device.permissions)
            return NotTestable(f"needs {what}; {way_out}", way_out.missing)
        for known in self.device.objects:
            if self.device.learned.lengths[known.mux].irreplaceable and any(
                each(known) for each in fits
            ):
                return NotTestable(
                    f"needs {what}; {known} would do, but reads longer than may be written: what "
                    "it holds could not be put back"
                )
        return lacking(self.device, what, example, *fits)

    def _refused_by_state(self, fits: Iterable[Fits]) -> Refused | None:
        """Return the refusal of an object that would do otherwise."""
        for known in self.device.objects:
            if any(each(known) for each in fits) and self.device.policy.permits(known.mux):
                for service in Service:
                    if refused := self.device.learned.serving.refusal(service, known.mux):
                        return refused
        return None

    def all_writable(self, fits: Fits = lambda _: True) -> list[KnownObject]:
        """Return the objects that ``fits`` takes, may be written and were read; limited ones last.

        An object that only a permission makes writable is left out: it does more than keep a value.
        """
        found = [
            known
            for known in self.device.objects
            if known.access is Access.RW
            and fits(known)  # most are left out by it, and permissions take longer to look up
            and known.mux in self.device.values
            and self.device.policy.permits(known.mux)
            and self.device.learned.serving.refusal(Service.DOWNLOAD, known.mux) is None
            and group_of(known.mux.index) is None
            and not self.device.learned.lengths[known.mux].irreplaceable
        ]
        return sorted(found, key=lambda known: known.is_limited)

    def shortest_readable(self) -> Multiplexer:
        """Return the object with the shortest steady value: leaks would show there."""
        readable = self.device.steady()
        if not readable:
            raise self._lacking(
                "an object that can be read", "2001=unsigned8", lambda known: known.access.readable
            )
        return min(readable, key=lambda mux: (len(self.device.values[mux]), mux))


def _is_plain(known: KnownObject, length: int) -> bool:
    """Say whether it is a number of which each value is as good as any other."""
    return known.length == length and _may_be_plain(known)


def _may_be_plain(known: KnownObject) -> bool:
    return known.access is Access.RW and known.data_type not in _NOT_PLAIN


def _takes_any_bytes(known: KnownObject) -> bool:
    """Say whether it is a string or domain of any length; UNICODE_STRING may insist on pairs."""
    return known.varies and known.data_type is not DataType.UNICODE_STRING
