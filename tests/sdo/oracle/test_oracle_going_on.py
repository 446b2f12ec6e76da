"""A block upload that goes on instead of ending is named by the state that it is in."""

from conformance.sdo.oracle import Oracle
from conformance.sdo.rules import Violation


def reaction(*frames: str) -> list[Violation]:
    """Return what is wrong with the last frame; requests and responses alternate in ``> <``."""
    oracle = Oracle()
    found: list[Violation] = []
    for frame in frames:
        data = bytes.fromhex(frame[2:])
        if frame[0] == ">":
            oracle.request(data)
        else:
            found = oracle.response(data)
    return found


BEGUN = ("> A4 10 20 00 02 00 00 00", "< C6 10 20 00 14 00 00 00")
SENT = (*BEGUN, "> A3 00 00 00 00 00 00 00", "< 01 41 42 43 44 45 46 47", "< 02" + " 48" * 7)


def test_any_frame_that_starts_it_is_foreign_before_the_start() -> None:
    for request in ("> 40 00 10 00 00 00 00 00", "> 2F 00 20 00 77 00 00 00"):
        found = reaction(*BEGUN, request, "< 01 41 42 43 44 45 46 47")
        assert [violation.rule.id for violation in found] == ["block-upload.foreign-before-start"]


def test_a_last_segment_is_no_abort_with_reserved_bits() -> None:
    found = reaction(*SENT, "> 40 00 10 00 00 00 00 00", "< 81 41 42 43 44 45 46 47")
    assert [violation.rule.id for violation in found] == ["block-upload.foreign"]
    assert found[0].actual.startswith("block segment 1, last")


def test_so_is_one_where_the_end_is_to_be_confirmed() -> None:
    """An acknowledgement once more brought segments again."""
    begun = ("> A0 10 20 00 02 00 00 00", "< C2 10 20 00 06 00 00 00", "> A3 00 00 00 00 00 00 00")
    ended = ("< 81 31 4A 50 5F 21 24 00", "> A2 01 7F 00 00 00 00 00", "< C5 00 00 00 00 00 00 00")
    for first in ("81", "01"):
        again = ("> A2 01 02 00 00 00 00 00", f"< {first} 31 4A 50 5F 21 24 00")
        (found,) = reaction(*begun, *ended, *again)
        assert found.rule.id == "block-upload.acknowledged-again"
        assert found.actual.startswith("block segment 1")


def test_an_abort_of_it_is_one() -> None:
    assert not reaction(*SENT, "> E0 00 00 00 00 00 00 00", "< 80 10 20 00 01 00 04 05")


def test_silence_at_its_end_is_one_kind_of_silence() -> None:
    oracle = Oracle()
    for frame in ("A4 10 20 00 7F 00 00 00", "A3 00 00 00 00 00 00 00", "A2 01 7F 00 00 00 00 00"):
        oracle.request(bytes.fromhex(frame))
        for answer in {
            "A4": ("C2 10 20 00 07 00 00 00",),
            "A3": ("81 41 42 43 44 45 46 47",),
            "A2": ("C1 00 00 00 00 00 00 00",),
        }[frame[:2]]:
            oracle.response(bytes.fromhex(answer))
    oracle.request(bytes.fromhex("40 00 10 00 00 00 00 00"))
    (silent,) = oracle.settled()
    assert silent.rule.id == "response.answered"
    assert "the end of a block upload" in silent.asked_as
