"""How conversations are drawn: sizes at the edges, events that a client or a bus can cause.

Everything shrinks to its first alternative, and numbers to 0.
"""

from collections.abc import Sequence

from hypothesis import strategies as st

from conformance.device.effort import LONGEST_OF_CONVERSATION
from conformance.model_cases.conversations.conversation import (
    Conversation,
    Disturbance,
    Event,
    Kind,
    Service,
    Transfer,
)
from conformance.model_cases.conversations.disturbed_client import FRAMES, Objects
from conformance.model_cases.variations import EDGE_SIZES
from conformance.sdo.layout import Multiplexer

Disturbances = st.SearchStrategy[tuple[Disturbance, ...]]
Conversations = st.SearchStrategy[Conversation]
BLOCK_SIZES = (127, 1, 2, 3, 4, 7, 126)
DOWNLOADS = (Service.DOWNLOAD, Service.EXPEDITED, Service.BLOCK_DOWNLOAD)
PLAIN = (Service.UPLOAD, Service.DOWNLOAD, Service.EXPEDITED)
BLOCKS = (Service.BLOCK_UPLOAD, Service.BLOCK_DOWNLOAD)
TOGGLE = 0x10
SINGLE_BITS = tuple(1 << bit for bit in range(8))
# Differences that make one more, one less or a limit of a counter.
MASKS = (TOGGLE, *SINGLE_BITS, 3, 6, 0x7F, 0x0E, 0xE0, 0xFF)
LAST_AT = 140
UNDISTURBED: Disturbances = st.just(())


def _segmented_transfers(objects: Objects) -> Conversations:
    """Draw expedited and segmented transfers, undisturbed."""
    return _conversations(_transfers(objects, PLAIN), most=3)


def _block_transfers(objects: Objects) -> Conversations:
    """Draw block transfers with losses, repetitions, delays and partial acknowledgements."""
    events = (Event.LOSE, Event.LOSE, Event.REPEAT, Event.LATE)
    return _conversations(_transfers(objects, BLOCKS, _disturbances(events, most=8)), most=2)


def _sequences(objects: Objects) -> Conversations:
    """Draw transfers of all kinds and sizes, one after another, undisturbed."""
    return _conversations(_transfers(objects, (*PLAIN, *BLOCKS)), least=2, most=5)


def _interrupted(objects: Objects) -> Conversations:
    """Draw transfers that end before their end, and others behind them."""
    events = (Event.ABORT, Event.LEAVE, Event.INSERT)
    one = _transfers(objects, (*PLAIN, *BLOCKS), _disturbances(events, least=1, most=1))
    return _conversations(one, most=5)


def _any_frames(objects: Objects) -> Conversations:
    """Draw transfers whose frames are altered, or joined by others, in any way."""
    likely = (Event.ALTER, Event.ALTER, Event.INSERT, Event.REPEAT)
    events = (*likely, Event.CUT, Event.LATE, Event.LOSE)
    one = _transfers(objects, (*PLAIN, *BLOCKS), _disturbances(events, least=1))
    return _conversations(one, most=3)


_DRAWS = {
    Kind.SEGMENTED_TRANSFERS: _segmented_transfers,
    Kind.BLOCK_TRANSFERS: _block_transfers,
    Kind.SEQUENCES: _sequences,
    Kind.INTERRUPTED: _interrupted,
    Kind.ANY_FRAMES: _any_frames,
}


def drawn(kind: Kind, objects: Objects) -> Conversations:
    """Return what draws conversations of a kind with a device that has these objects."""
    return _DRAWS[kind](objects)


def _conversations(
    transfers: st.SearchStrategy[Transfer], *, most: int, least: int = 1
) -> Conversations:
    return st.lists(transfers, min_size=least, max_size=most).map(tuple)


def _disturbances(events: Sequence[Event], *, least: int = 0, most: int = 4) -> Disturbances:
    one = st.one_of([_disturbance(event) for event in events])
    # One event of a kind at a request: a frame that is sent eight times is a flood.
    once = st.lists(
        one, min_size=least, max_size=most, unique_by=lambda found: (found.at, found.event)
    )
    return once.map(tuple)


def _disturbance(event: Event) -> st.SearchStrategy[Disturbance]:
    at = st.integers(0, 4) | st.integers(0, 12) | st.integers(0, LAST_AT)
    match event:
        case Event.ALTER:
            # Byte 0 says most; bytes 1 and 2 are counters, or the CRC.
            byte = st.sampled_from((0, 0, 0, 0, 1, 1, 2, 2, 3, 4, 5, 6, 7))
            masks = st.sampled_from(MASKS) | st.integers(1, 255)
            return st.builds(Disturbance, at, st.just(event), byte, masks)
        case Event.CUT:
            return st.builds(Disturbance, at, st.just(event), st.integers(0, 7))
        case Event.INSERT:
            return st.builds(Disturbance, at, st.just(event), label=st.sampled_from(sorted(FRAMES)))
    return st.builds(Disturbance, at, st.just(event))


def _transfers(
    objects: Objects,
    services: Sequence[Service],
    disturbances: Disturbances = UNDISTURBED,
) -> st.SearchStrategy[Transfer]:
    """Draw one transfer; numbers are written undisturbed, so that they stay what they should."""
    uploads = [service for service in services if service not in DOWNLOADS]
    kinds = [_of_text(objects, mux, services, disturbances) for mux in objects.rooms]
    if objects.numbers:
        kinds.append(_of_any(objects.numbers, services, UNDISTURBED))
    kinds.append(_of_any(objects.readable, uploads, disturbances))
    return st.one_of(kinds)


def _of_text(
    objects: Objects,
    mux: Multiplexer,
    services: Sequence[Service],
    disturbances: Disturbances,
) -> st.SearchStrategy[Transfer]:
    room = objects.rooms[mux]
    edges = [size for size in EDGE_SIZES if size <= room]
    sizes = (
        st.integers(0, min(room, 40))
        | st.sampled_from(edges)
        | st.integers(0, min(room, LONGEST_OF_CONVERSATION))
    )
    return st.builds(
        Transfer,
        st.sampled_from(services),
        st.just(mux),
        sizes,
        st.integers(0, 3),
        disturbances=disturbances,
        **_manners(),
    )


def _of_any(
    muxes: Sequence[Multiplexer],
    services: Sequence[Service],
    disturbances: Disturbances,
) -> st.SearchStrategy[Transfer]:
    return st.builds(
        Transfer,
        st.sampled_from(services),
        st.sampled_from(muxes),
        content=st.integers(0, 1),
        disturbances=disturbances,
        **_manners(),
    )


def _manners() -> dict[str, st.SearchStrategy[object]]:
    """Draw how a transfer is done, whatever it is about."""
    sizes = st.sampled_from(BLOCK_SIZES) | st.integers(1, 127)
    return {
        "sized": st.sampled_from((True, False)),
        "crc": st.sampled_from((True, False)),
        "threshold": st.sampled_from((0, 1, 4, 10, 255)),
        "block_sizes": st.lists(sizes, min_size=1, max_size=3).map(tuple),
        "withheld": st.lists(st.integers(0, 3) | st.integers(0, 127), max_size=3).map(tuple),
    }
