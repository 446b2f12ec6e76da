"""A python-can bus as an SDO channel: send, expect, capture; what is wrong with the bench."""
