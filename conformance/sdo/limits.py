"""What a message holds at most (CiA 301, 7.2.4.3.3 to 7.2.4.3.15)."""

EXPEDITED_LENGTH = 4
"""The bytes of an expedited transfer."""
SEGMENT_LENGTH = 7
"""The bytes of a segment."""
LARGEST_BLOCK = 127
"""The segments of a sub-block."""


def requests_of_upload(length: int) -> int:
    """Return how many requests it takes to read so many bytes, in segments if they are many.

    >>> [requests_of_upload(length) for length in (0, 4, 5, 7, 8)]
    [1, 1, 2, 2, 3]
    """
    return 1 if length <= EXPEDITED_LENGTH else 1 + -(-length // SEGMENT_LENGTH)
