"""What is read before the first case: all that is listed, and in haste some of very many objects.

What is not read is not written, as it could not be put back, and each reset of the node has all
that may change read again.
"""

from collections import Counter

from conformance.device.device import Device
from conformance.device.effort import LONG_VALUE, Effort
from conformance.device.known_objects import KnownObject
from conformance.sdo.limits import requests_of_upload


def in_order(device: Device) -> list[KnownObject]:
    """Return the listed objects that can be read.

    In haste those that the user has named come first, then one of each kind in turn: the first of
    them are of all kinds, from all parts of the dictionary.
    """
    listed = [one for one in device.objects if one.access.readable and not one.refuses_scan]
    if len(listed) <= device.permits.effort.objects:
        return listed
    named = {known.mux for known in device.permits.named}
    of_kind = Counter[object]()
    turns: dict[KnownObject, int] = {}
    for known in listed:
        kind = known.mux.index >> 8, known.data_type, known.access, known.is_limited
        turns[known] = of_kind[kind]
        of_kind[kind] += 1
    return sorted(listed, key=lambda known: (known.mux not in named, turns[known]))


class FirstReading:
    """Counts the requests of the objects that are read behind the first ones."""

    def __init__(self, effort: Effort) -> None:
        """Allow few requests in haste, else any number."""
        self._first = effort.objects
        self._left = effort.further_requests
        self._objects = 0

    def ends(self) -> bool:
        """Say whether no more is to be read."""
        return self._objects >= self._first and self._left <= 0

    def count(self, value: bytes) -> None:
        """Count an object; a long value counts as the part of it that has to be read."""
        self._objects += 1
        if self._objects > self._first:
            self._left -= requests_of_upload(min(len(value), LONG_VALUE))
