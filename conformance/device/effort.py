"""How much a run reads, writes and tries: all thresholds in one table.

A run is bounded by its user alone: ``--sdo-quick``, which is in haste here, ``--sdo-budget``, or a
selection. No case is left out because a device has many objects or long values. Sizes of the
protocol stand with it, in ``sdo/limits.py``.
"""

from collections.abc import Sequence
from enum import Enum, auto
from math import ceil, inf
from typing import TypeVar

from conformance.sdo.client import MOST_UPLOADED

Item = TypeVar("Item")

# Bytes of a value. Where the protocol is not the point, one with more than SHORT_VALUE goes in
# blocks: fewer take about as many requests in segments. Where another object will do, one with more
# than LONG_VALUE is left alone, and one with more than THOUSANDS_OF_SEGMENTS is the last choice.
SHORT_VALUE = 64
LONG_VALUE = 1000
THOUSANDS_OF_SEGMENTS = 1 << 14
# A longer value is not read to its end, and so never written: a device that carries 65,544 bytes
# has shown how far it counts.
LONGEST_READ = 100_000
# A device has to bring as many before the size that it announces is believed.
BELIEVED = 5_000
# More than a sub-block can have: nearly all transfers have less.
MUCH_ROOM = 897
# Where this size or less is refused, the suite finds out how many bytes are taken.
MOST_MEASURED = 300
# Uploads without an end are cut off. A device may have one length for its strings, and fill up with
# 00h what is shorter: an object may bring so many bytes more than were written to it, and few more
# where the device has brought data without an end ENDLESS times.
PADDING, LITTLE_PADDING = 1024, 64
ENDLESS = 3
# What a text is allowed that was not read yet, where the EDS states a value and where it does not;
# and anything else, behind none, up to ENDLESS, and more uploads without an end.
LONGEST_STATED_TEXT, LONGEST_TEXT = 1 << 14, 1 << 17
UPLOADED = ((0, MOST_UPLOADED), (ENDLESS, 1 << 14), (1 << 32, 1 << 10))
# The segments of a long value that are compared with the same in blocks.
SEGMENTS_COMPARED = 16

# Objects that stand for all where none of them is the point; in haste as many are read before the
# first case, whatever they cost, and the others for so many requests.
OBJECTS_IN_HASTE = 100
FURTHER_REQUESTS_IN_HASTE = 200
# Objects that are read in each NMT state to see in which they are served.
OBJECTS_PER_STATE = 3
# Strings and domains that a random conversation writes to, and the most bytes that it writes: long
# transfers are most of the cost of a conversation.
TEXTS_OF_CONVERSATION = 8
LONGEST_OF_CONVERSATION = 200
# Indices beside those that are listed.
INDICES_BESIDE = 24

# Requests that a quick run sends at most, counted when they are answered. A case of more than
# REQUESTS_OF_SMALL_CASE is in it only for the faults that it catches.
REQUESTS_IN_HASTE = 3000
REQUESTS_OF_SMALL_CASE = 100
# Random conversations of a case, and the seconds and answers of its search for a short one.
USUAL_EXAMPLES, THOROUGH_EXAMPLES = 20, 500
SEARCH_SECONDS = 60.0
SHRINK_SECONDS = 30.0
# Most conversations are as short as they get by then; the last transfers would cost as much again.
SHRINK_ANSWERS = 1000

# Tries. Of a transfer that the server aborts, which it may do at any time.
TRIES_OF_TRANSFER = 4
# Of one that a lost frame spoils: what spoils as many one after another is due to the device.
TRIES_OF_LENGTH = 2
# Of a case that fails each time at another place: then nothing can be said of it.
TRIES_OF_CASE = 5
# Of a case that fails at the same place, until it is the device's failure. Two are too few: any
# segment of a sub-block may be lost, or any of many answers come twice, and the end be the same.
ALIKE_TRIES = 3
# Of a service that a busy device refuses, of a value that it refuses as too long, and of one that
# has to be put back.
TRIES_OF_REFUSED = 2
# Of an object that cannot be put back, as the device is silent: it may be busy.
SILENCES_OF_OBJECT = 5
# Of the first exchange with a device.
FIRST_TRIES = 3
# Reads of a value that the device measures, before two protocols are said to differ; and reads in
# which such a value has to change, with nothing written between them.
READS_OF_MEASURED = 4
READS_OF_CHANGING = 10
# Losses of the device by cases of one kind, or before the first case: then it is tried no more.
MOST_LOSSES = 2
# Starts of a program that is to bring a device back.
TRIES_OF_PROGRAM = 3
# Reads in a row without a right answer that end a search for objects: each may cost a time-out.
READS_WITHOUT_ANSWER = 3
# Reads in a row that show that each is answered one request later.
READS_ONE_BEHIND = 4
# How often the values are looked at behind the last case, as long as some are not as before.
AUDITS = 3


class Effort(Enum):
    """How much a user wants to spend: ``--sdo-quick``, a run without option, ``--sdo-thorough``."""

    HASTE = auto()
    USUAL = auto()
    THOROUGH = auto()

    @property
    def objects(self) -> float:
        """How many objects are read before the first case, whatever they cost."""
        return OBJECTS_IN_HASTE if self is Effort.HASTE else inf

    @property
    def longest_read(self) -> int:
        """How many bytes of a value are read in segments before the first case."""
        return LONG_VALUE if self is Effort.HASTE else LONGEST_READ

    @property
    def further_requests(self) -> float:
        """How many requests may read further objects."""
        return FURTHER_REQUESTS_IN_HASTE if self is Effort.HASTE else inf

    @property
    def examples(self) -> int:
        """How many random conversations each case tries."""
        return THOROUGH_EXAMPLES if self is Effort.THOROUGH else USUAL_EXAMPLES

    @property
    def search_seconds(self) -> float:
        """How long a random case may search: a thorough run tries all of its examples."""
        return inf if self is Effort.THOROUGH else SEARCH_SECONDS

    def sampled(self, items: Sequence[Item]) -> Sequence[Item]:
        """Return all items, or in haste some from all over their sequence.

        >>> Effort.HASTE.sampled(range(300))
        range(0, 300, 3)
        """
        return items[:: max(ceil(len(items) / self.objects), 1)]
