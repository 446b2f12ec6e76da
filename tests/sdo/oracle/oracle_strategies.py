"""Hypothesis strategies for scripts: the suite's own conversations, single frames and silences."""

from itertools import chain

from hypothesis import strategies as st
from support.oracle_objects import NODE_ID, REFERENCE, TARGETS
from support.oracle_sequences import Script, Silence

from conformance.model_cases.conversations.conversation import Kind
from conformance.model_cases.conversations.disturbed_client import FRAMES
from conformance.model_cases.conversations.strategies import drawn
from conformance.sdo.can_frame import CanFrame

LIKELY = [make(TARGETS).data for _, make in sorted(FRAMES.items())]
DATA = st.one_of(
    st.sampled_from(LIKELY),
    st.tuples(st.integers(0, 255), st.sampled_from(LIKELY)).map(
        lambda pair: bytes([pair[0]]) + pair[1][1:]
    ),
    st.binary(min_size=8, max_size=8),
)
SINGLE_FRAME = DATA.map(lambda data: (CanFrame(0x600 + NODE_ID, data),))
CONVERSATIONS = st.one_of([drawn(kind, REFERENCE) for kind in Kind])
PARTS: st.SearchStrategy[Script] = st.one_of(
    CONVERSATIONS, CONVERSATIONS, SINGLE_FRAME, st.just((Silence.TIME_OUT,))
)
SCRIPTS: st.SearchStrategy[Script] = st.lists(PARTS, min_size=1, max_size=3).map(
    lambda parts: tuple(chain.from_iterable(parts))
)
