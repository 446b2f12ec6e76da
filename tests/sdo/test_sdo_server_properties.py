"""What holds for the reference server whatever a client sends."""

from hypothesis import given
from hypothesis import strategies as st
from sdo_server_bench import ANSWER_1000, READ_1000, Bench
from support.sdo_strategies import FRAMES, MUX, REQUESTS, UNHURRIED
from support.sdo_vectors import mux

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.decoding import decode_response
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    UploadInitiate,
    UploadInitiateResponse,
)
from conformance.sdo.layout import Message, Multiplexer

NAMES = ["1000", "1008", "1018:01", "2000", "2001", "2002", "2003", "2004", "2005", "2006"]
KNOWN = st.sampled_from([mux(name) for name in NAMES])
# Frames of any kind, among them many that lead into transfers.
INITIATES = st.one_of(
    st.builds(UploadInitiate, KNOWN | MUX),
    st.builds(DownloadInitiate.with_size, KNOWN | MUX, st.none() | st.integers(0, 40)),
)
SOUP = st.lists(
    st.one_of(
        FRAMES,
        st.binary(max_size=8),
        st.one_of(*REQUESTS.values(), INITIATES).map(Message.encode),
    ),
    max_size=40,
)


def is_known_mux(found: Multiplexer) -> bool:
    return found in [mux(name) for name in NAMES]


@UNHURRIED
@given(SOUP)
def test_answers_are_well_formed(soup: list[bytes]) -> None:
    bench = Bench()
    for request in soup:
        answers = bench.server.receive(request)
        assert len(answers) <= 1
        for answer in answers:
            message = decode_response(answer)
            assert isinstance(message, Message)
            assert message.reserved_fields() == []
            assert not isinstance(message, Abort) or message.code in set(AbortCode)
            if isinstance(message, UploadInitiateResponse):
                assert is_known_mux(message.mux)


@UNHURRIED
@given(SOUP)
def test_aborts_and_short_frames_are_not_answered(soup: list[bytes]) -> None:
    bench = Bench()
    for request in soup:
        answers = bench.server.receive(request)
        assert not answers or len(request) == 8
        assert not answers or request[0] != 0x80


@UNHURRIED
@given(SOUP)
def test_the_next_read_is_always_served(soup: list[bytes]) -> None:
    bench = Bench()
    for request in soup:
        bench.server.receive(request)
    assert bench.ask(READ_1000) == [ANSWER_1000]


@UNHURRIED
@given(SOUP)
def test_read_only_values_stay_and_lengths_fit_the_types(soup: list[bytes]) -> None:
    bench = Bench()
    for request in soup:
        bench.server.receive(request)
    assert bench.value("1000") == bytes.fromhex("91010F00")
    assert bench.value("1008") == b"Tiny Node - Mega Domains !"
    lengths = {name: len(bench.value(name)) for name in ("2000", "2002", "2003", "2005", "2006")}
    assert lengths == {"2000": 4, "2002": 4, "2003": 2, "2005": 8, "2006": 1}
    assert len(bench.value("2001")) <= 32
