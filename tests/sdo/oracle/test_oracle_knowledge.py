"""What the oracle knows in the course of a conversation: what is due, values, choices."""

from oracle_notation import BLOCK_DOWNLOAD, DOWNLOAD, KNOWN, READ, judged
from support.sdo_vectors import mux

from conformance.sdo.layout import Multiplexer
from conformance.sdo.oracle import Awaited, Oracle


def test_a_refusal_of_what_may_exist_is_not_about_what_is_missing() -> None:
    refused = "> 40 00 30 00 00 00 00 00 \n < 80 00 30 00 00 00 03 05"
    assert [found.rule.id for found in judged(refused, Oracle())] == ["response.not-refused"]


def test_awaited_follows_what_is_due() -> None:
    oracle = Oracle(KNOWN)
    awaited = [oracle.awaited]
    oracle.request(bytes.fromhex("4000100000000000"))
    awaited.append(oracle.awaited)
    assert oracle.response(bytes.fromhex("4300100091010F00")) == []
    awaited.append(oracle.awaited)
    oracle.request(bytes(8))
    awaited.append(oracle.awaited)
    assert awaited == [Awaited.NOTHING, Awaited.ANSWER, Awaited.NOTHING, Awaited.MAYBE]


def test_values_follow_downloads() -> None:
    oracle = Oracle(KNOWN)
    assert oracle.may_hold(mux("2000")) == frozenset({b"\1\2\3\4"})
    assert judged("> 23 00 20 00 05 06 07 08 \n < 60 00 20 00 00 00 00 00", oracle) == []
    assert oracle.may_hold(mux("2000")) == frozenset({b"\5\6\7\x08"})
    read_old = "> 40 00 20 00 00 00 00 00 \n < 43 00 20 00 01 02 03 04"
    assert [found.rule.id for found in judged(read_old, oracle)] == ["response.not-refused"]


def test_an_ambiguous_frame_leaves_two_values() -> None:
    oracle = Oracle(KNOWN)
    # Whether the short frame was served, only its confirmation would say.
    oracle.request(bytes.fromhex("2F0120000200"))
    assert oracle.may_hold(mux("2001")) == frozenset({b"\1", b"\2"})
    assert oracle.settled() == []
    assert oracle.may_hold(mux("2001")) == frozenset({b"\1"})


def test_a_time_out_may_be_reported_after_silence_only() -> None:
    timed_out = "< 80 10 20 00 00 00 04 05"
    assert [found.rule.id for found in judged(f"{DOWNLOAD} \n {timed_out}")]
    oracle = Oracle(KNOWN)
    judged(DOWNLOAD, oracle)
    assert oracle.silence() == []
    assert judged(timed_out, oracle) == []
    assert oracle.idle


def test_after_a_breach_the_next_transfer_is_judged_again() -> None:
    oracle = Oracle(KNOWN)
    assert judged(f"{READ} \n < 60 00 10 00 00 00 00 00", oracle)
    assert oracle.lost
    assert judged(f"{READ} \n < 43 00 10 00 91 01 0F 00", oracle) == []
    assert not oracle.lost
    assert judged(f"{READ} \n < 43 01 10 00 91 01 0F 00", oracle)


def test_the_profile_names_choices() -> None:
    oracle = Oracle(KNOWN)
    judged(f"{BLOCK_DOWNLOAD} \n > 02 30 31 32 33 34 35 36 \n < A2 00 04 00 00 00 00 00", oracle)
    assert oracle.profile["acknowledges a gap"] == {"at once"}
    assert oracle.profile["block size of a download"] == {"4"}
    assert "acknowledges a gap: at once" in oracle.profile.lines()


def test_of_unknown_objects_only_the_protocol_is_judged() -> None:
    oracle = Oracle()
    assert oracle.may_hold(Multiplexer(0x2000)) is None
    assert judged("> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 00 00 02 06", oracle) == []
    assert judged("> 40 FF 1F 00 00 00 00 00 \n < 43 FF 1F 00 00 00 00 00", oracle) == []
    assert judged("> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 00 00 03 05", oracle)
