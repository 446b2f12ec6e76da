"""How much a run reads and writes where quantity is not the point: the thresholds in one table.

A run is bounded by its user alone: ``--sdo-quick``, which is in haste here, ``--sdo-budget``, or a
selection. No case is left out because a device has many objects or long values.
"""

from collections.abc import Sequence
from math import ceil
from typing import TypeVar

Item = TypeVar("Item")

# Bytes. A value has at most SHORT_VALUE of them where its length is not the point, and FEW_SEGMENTS
# where each of its segments is looked at. Where another object will do, one with more than
# LONG_VALUE is left alone, and one with more than THOUSANDS_OF_SEGMENTS is the last choice.
FEW_SEGMENTS = 32
SHORT_VALUE = 64
LONG_VALUE = 1000
THOUSANDS_OF_SEGMENTS = 1 << 14
# A longer value is not read to its end, and so never written: a device that carries 65,544 bytes
# has shown how far it counts.
LONGEST_READ = 100_000

# In haste: so many objects are read before the first case, whatever they cost, and the others for
# so many requests. As many objects stand for all where none of them is the point.
OBJECTS_IN_HASTE = 100
FURTHER_REQUESTS_IN_HASTE = 200


def sampled(items: Sequence[Item], *, in_haste: bool) -> Sequence[Item]:
    """Return all items, or in haste some from all over their sequence.

    >>> sampled(range(300), in_haste=True)
    range(0, 300, 3)
    """
    step = ceil(len(items) / OBJECTS_IN_HASTE) if in_haste else 1
    return items[:: max(step, 1)]
