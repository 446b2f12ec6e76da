"""What a message holds at most (CiA 301, 7.2.4.3.3 to 7.2.4.3.15)."""

EXPEDITED_LENGTH = 4
"""The bytes of an expedited transfer."""
SEGMENT_LENGTH = 7
"""The bytes of a segment."""
LARGEST_BLOCK = 127
"""The segments of a sub-block."""
