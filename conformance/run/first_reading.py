"""What is read before the first case: all that is listed, unless that takes too many requests.

What is not read is not written, as it could not be put back, and each reset of the node has all
that may change read again.
"""

from math import inf

from conformance.device.device import VERY_LONG, Device
from conformance.device.known_objects import KnownObject
from conformance.device.permits import Permits
from conformance.run import further
from conformance.run.further import in_turn
from conformance.sdo.limits import requests_of_upload
from conformance.sdo.objects import Access

# How many requests the objects take at most that come behind the first hundred, which the cases
# count on; and in a run that takes some thousands as a whole.
MOST_FURTHER = 2_500
MOST_IN_HASTE = 200


def most_further(permits: Permits) -> float:
    """Return how many requests a run has for the further ones of very many objects."""
    if permits.at_length:
        return inf
    return MOST_IN_HASTE if permits.in_haste else MOST_FURTHER


def in_order(device: Device) -> list[KnownObject]:
    """Return what is listed and can be read, the first ones of very many first.

    These are what the user has named, and then objects of all kinds; behind them those come first
    that a reset may change.
    """
    listed = [one for one in device.objects if one.access.readable and not one.refuses_scan]
    if len(listed) <= further.ENOUGH:
        return listed
    named = {known.mux for known in device.permits.named}
    by_label = {str(known.mux): known for known in listed}
    in_order = [by_label[label] for label in in_turn(by_label)]
    in_order.sort(key=lambda known: known.mux not in named)
    first, others = in_order[: further.ENOUGH], in_order[further.ENOUGH :]
    return first + sorted(others, key=lambda known: known.access is not Access.RW)


class FurtherReading:
    """Counts the requests of what is read behind the first objects."""

    def __init__(self, most: float) -> None:
        """Allow so many requests."""
        self._left = most
        self._objects = 0

    def ends(self) -> bool:
        """Say whether no more is to be read."""
        return self._objects >= further.ENOUGH and self._left <= 0

    def count(self, value: bytes) -> None:
        """Count an object; one that is very long counts as what has to be read of it."""
        self._objects += 1
        if self._objects > further.ENOUGH:
            self._left -= requests_of_upload(min(len(value), VERY_LONG))
