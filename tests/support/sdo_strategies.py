"""Hypothesis strategies: every message of both directions, with all that its fields can hold.

Which messages there are and how wide their fields are is taken from the messages themselves.
"""

from collections.abc import Iterable, Iterator
from typing import get_type_hints

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from conformance.sdo import decoding
from conformance.sdo.frames import Abort, BlockSegment
from conformance.sdo.layout import Message, Multiplexer

# A busy machine is no failure.
UNHURRIED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])

Strategies = dict[type[Message], SearchStrategy[Message]]

FRAMES = st.binary(min_size=8, max_size=8)
OTHER_LENGTHS = st.one_of(st.binary(max_size=7), st.binary(min_size=9, max_size=64))


def bits(count: int) -> SearchStrategy[int]:
    return st.integers(0, 2**count - 1)


def raw(length: int) -> SearchStrategy[bytes]:
    return st.binary(min_size=length, max_size=length)


MUX = st.builds(Multiplexer, bits(16), bits(8))


def fields_of(kind: type[Message]) -> Iterator[tuple[str, SearchStrategy[object]]]:
    """Yield the fields of a message, each with whatever fits into its place."""
    types = get_type_hints(kind)
    for name, mask in kind.LAYOUT.bits.items():
        yield name, st.booleans() if types[name] is bool else bits(mask.bit_count())
    for name, (start, stop) in kind.LAYOUT.body.items():
        if types[name] is Multiplexer:
            yield name, MUX
        else:
            yield name, raw(stop - start) if types[name] is bytes else bits(8 * (stop - start))


def all_of(kinds: Iterable[type[Message]]) -> Strategies:
    return {kind: st.builds(kind, **dict(fields_of(kind))) for kind in kinds}


REQUESTS = all_of(decoding.REQUESTS)
RESPONSES = all_of(decoding.RESPONSES)
# Sequence number 0 marked as last would be 80h, which is an abort; an abort has no bits to spare.
SEGMENTS: Strategies = {
    BlockSegment: st.builds(BlockSegment, bits(7), raw(7), st.booleans()).filter(
        lambda segment: segment.sequence > 0 or not segment.last
    ),
    Abort: st.builds(Abort, MUX, bits(32)),
}
