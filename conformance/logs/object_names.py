"""The names that an EDS gives the objects of a device, beside their numbers in a line of words."""

import re

from conformance.device.eds_listing import Listing
from conformance.sdo.printable_text import inert

_OBJECT = re.compile(r"\b([0-9A-F]{4})h:([0-9A-F]{2})\b")


class ObjectNames:
    """Adds names to lines."""

    def __init__(self, listing: Listing) -> None:
        """Take the objects of an EDS; an entry of a record is named after the record as well."""
        self._names: dict[tuple[int, int], str] = {}
        for index, listed in listing.objects.items():
            for sub_index, entry in listed.entries.items():
                parts = dict.fromkeys(filter(None, (listed.name, entry.name)))
                if parts:
                    self._names[index, sub_index] = inert(", ".join(parts))

    def in_line(self, line: str) -> str:
        """Return a line in which each object that has a name is followed by it."""
        return _OBJECT.sub(self._with_name, line)

    def _with_name(self, found: re.Match[str]) -> str:
        name = self._names.get((int(found[1], 16), int(found[2], 16)))
        return f"{found[0]} ({name})" if name else found[0]
