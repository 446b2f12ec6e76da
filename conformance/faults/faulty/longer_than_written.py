"""Faulty servers of which strings read with more bytes than may be written to them."""

from functools import partial

from conformance.faults import registry
from conformance.faults.registry import About, Defect
from conformance.reference.server import Server
from conformance.sdo.objects import DataType, Entry, ObjectDictionary

fault = partial(registry.fault, about=About.LENGTHS)
TAKEN, READ = 20, 64


class _ReadLonger(Server):
    """Has room for few bytes in some strings, and reads them with more."""

    padding = b"\0"

    def __init__(self, objects: ObjectDictionary) -> None:
        """Cut them to the room; each channel has a server on the same objects."""
        super().__init__(objects)
        for entry in objects:
            if self.is_longer(entry):
                entry.capacity = TAKEN

    def value_to_read(self, entry: Entry) -> bytes:
        value = super().value_to_read(entry)
        return value.ljust(READ, self.padding) if self.is_longer(entry) else value

    def is_longer(self, entry: Entry) -> bool:
        """Say whether an entry is one of these strings."""
        return entry.data_type.length is None and entry.access.writable


@fault("strings-of-20-bytes-read-64", Defect.ACCESS_OR_SIZE, "download.text")
class ReadLonger(_ReadLonger):
    """Takes 20 bytes in strings and domains, and fills them up with 00h to 64 to be read."""


@fault("texts-of-20-bytes-read-64", Defect.ACCESS_OR_SIZE, "download.as-written", soft=True)
class TextsReadLonger(_ReadLonger):
    """Takes 20 bytes in texts, and fills them up with blanks to 64 to be read."""

    padding = b" "

    def is_longer(self, entry: Entry) -> bool:
        return super().is_longer(entry) and entry.data_type is DataType.VISIBLE_STRING


@fault("strings-too-long-to-be-put-back", Defect.ACCESS_OR_SIZE, "od.write-back")
class TooLongToBePutBack(_ReadLonger):
    """Takes 20 bytes in strings and domains, and holds 64 that nobody could write again."""

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        for entry in objects:
            if self.is_longer(entry) and len(entry.value) < TAKEN:
                entry.value = b"-" * READ
