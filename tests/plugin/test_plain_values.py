"""Reports as one text: what is read is what was written, and never more than data."""

import pickle
from enum import StrEnum

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conformance.plugin.plain_values import pack, unpack

KEYS = st.one_of(st.text(), st.integers(), st.sampled_from(["()", "{}"]))
PLAIN = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(allow_nan=False), st.text()),
    lambda inner: st.one_of(
        st.lists(inner), st.lists(inner).map(tuple), st.dictionaries(KEYS, inner)
    ),
    max_leaves=20,
)


@given(PLAIN)
def test_plain_values_are_what_they_were(values: object) -> None:
    assert unpack(pack(values)) == values
    assert repr(unpack(pack(values))) == repr(values)


class Colour(StrEnum):
    RED = "red"


def test_what_a_program_makes_of_text_is_text() -> None:
    assert type(unpack(pack([Colour.RED]))[0]) is str
    assert unpack(pack("\ud800 €\x1b")) == "\ud800 €\x1b"


@pytest.mark.parametrize("value", [b"bytes", {1, 2}, object(), [Exception()]])
def test_what_is_not_plain_is_refused(value: object) -> None:
    with pytest.raises(TypeError):
        pack(value)


class Code:
    """What pickle would call while it reads."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return pytest.fail, ("it was run",)


def test_what_a_worker_sends_is_not_run() -> None:
    for protocol in (0, 4):
        with pytest.raises((ValueError, TypeError)):
            unpack(pickle.dumps(Code(), protocol).decode("latin-1"))
