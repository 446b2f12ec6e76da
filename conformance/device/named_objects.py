"""Objects as the user names them: an entry, or all of an array or record."""

from dataclasses import dataclass

from conformance.device.eds_listing import Listing
from conformance.device.known_objects import KnownObject, parse_object


@dataclass(frozen=True, slots=True)
class NamedObject:
    """An entry that the user has named; without a sub-index and a type, all of its object.

    Of an array or record its writable entries are meant then.
    """

    known: KnownObject
    is_whole: bool

    @classmethod
    def parse(cls, text: str) -> "NamedObject":
        """Read a name, as ``parse_object`` does; raises ObjectNameError."""
        return cls(parse_object(text), ":" not in text and "=" not in text)

    def entries(self, listing: Listing) -> list[KnownObject]:
        """Return the entries of the object, by the listing of a device."""
        listed = listing.objects.get(self.known.mux.index)
        if not self.is_whole or listed is None or not listed.is_structured:
            return [self.known]
        writable = [entry for entry in listed.entries.values() if entry.access.writable]
        return writable or [self.known]
