"""Hypothesis strategies for scripts: transfers of all kinds, and frames that are near to valid."""

from hypothesis import strategies as st
from oracle_scripts import KINDS, Disturbance, Noise, Transfer
from oracle_sequences import CONSTANTS, DOMAIN, MISSING, NUMBERS, TEXT, WRITE_ONLY, stimuli

OBJECTS = (TEXT, DOMAIN, *NUMBERS, WRITE_ONLY, *CONSTANTS, *MISSING)
WRITABLE = (TEXT, DOMAIN, *NUMBERS)
SIZES = (0, 1, 2, 3, 4, 5, 7, 8, 13, 14, 15, 20, 21, 50, 130)

FRAMES = st.one_of(
    st.sampled_from(stimuli(TEXT)),
    st.sampled_from(stimuli(DOMAIN)),
    st.tuples(st.integers(0, 255), st.sampled_from(stimuli(TEXT))).map(
        lambda pair: bytes([pair[0]]) + pair[1][1:]
    ),
    st.binary(min_size=8, max_size=8),
)
ONE_BIT = st.integers(0, 63).map(lambda bit: (1 << bit).to_bytes(8, "little"))


def _disturbance(noise: Noise) -> st.SearchStrategy[Disturbance]:
    frames = ONE_BIT if noise is Noise.CHANGED else FRAMES
    return st.builds(Disturbance, st.integers(0, 6), st.just(noise), frames, st.integers(0, 7))


DISTURBANCES = st.lists(st.sampled_from(Noise).flatmap(_disturbance), max_size=2).map(tuple)
DATA = st.sampled_from(SIZES).flatmap(lambda size: st.binary(min_size=size, max_size=size))
TRANSFERS = st.builds(
    Transfer,
    st.sampled_from(sorted(set(KINDS) - {"loose frame"})),
    st.sampled_from(WRITABLE) | st.sampled_from(OBJECTS),
    DATA,
    sized=st.booleans(),
    announced=st.none() | st.sampled_from((0, 1, 4, 7, 8, 14, 2**32 - 1)),
    crc=st.booleans(),
    block_size=st.sampled_from((127, 1, 2, 3, 0, 128)),
    threshold=st.sampled_from((0, 0, 4, 20, 255)),
    taken=st.sampled_from((127, 0, 1, 2)),
    disturbed=DISTURBANCES,
)
LOOSE = st.builds(Transfer, st.just("loose frame"), st.just(TEXT), FRAMES, disturbed=DISTURBANCES)
SCRIPTS = st.lists(TRANSFERS | LOOSE, min_size=1, max_size=5)
