"""What a sight is for people, and of which kind it is."""

import pytest

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort, UploadInitiateResponse
from conformance.sdo.kinds import NO_ANSWER, OTHER_DATA, Kind, kind_of
from conformance.sdo.layout import Multiplexer
from conformance.sdo.seen import (
    MOST_LETTERS,
    Data,
    Misread,
    NoAnswer,
    OddFrame,
    Received,
    Said,
    Seen,
    abort_in,
    filled,
    other_data,
    said,
)

MUX = Multiplexer(0x1018, 1)
ABORT = Abort(MUX, AbortCode.COMMAND_NOT_VALID)
READ = UploadInitiateResponse.with_data(MUX, b"\1\2\3\4")


@pytest.mark.parametrize(
    ("seen", "words", "kind"),
    [
        (NoAnswer(), "no answer", NO_ANSWER),
        (NoAnswer("nothing within 50 ms"), "nothing within 50 ms", NO_ANSWER),
        (NoAnswer(responses=[ABORT]), f"no answer; {in_words(ABORT)}", NO_ANSWER),
        (Received(ABORT), in_words(ABORT), Kind("abort", AbortCode.COMMAND_NOT_VALID)),
        (Received(READ), in_words(READ), kind_of(UploadInitiateResponse)),
        (Misread(READ), in_words(READ), OTHER_DATA),
        (Data(b"\1\2"), "2 bytes: 01 02", OTHER_DATA),
        (Data(b"\1\2", MUX), "1018h:01 reads 2 bytes: 01 02", OTHER_DATA),
        (other_data("it reads 2"), "it reads 2", OTHER_DATA),
        (
            OddFrame(CanFrame(0x585, b"\x43\0\x10"), {"another length than 8": "DLC 3"}),
            "585#430010 (DLC 3)",
            Kind("another length than 8"),
        ),
        (Said("the end was confirmed"), "the end was confirmed", Kind("the end was confirmed")),
        (Said("n=3", "n=…"), "n=3", Kind("n=…")),
        (said("{} of {} segments", 3, 7), "3 of 7 segments", Kind("… of … segments")),
        (
            filled(b"\xa5", b"\x40"),
            "A5 in bytes without data [40]",
            Kind("… in bytes without data"),
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Seen) else "",
)
def test_words_and_kind(seen: Seen, words: str, kind: Kind) -> None:
    assert (seen.words, seen.kind) == (words, kind)
    more = seen.remarking(", twice")
    assert (more.words, more.kind) == (f"{words}, twice", kind)


def test_the_first_of_several_responses_says_the_kind() -> None:
    several = Received(ABORT, [READ] * 5)
    assert several.kind == Received(ABORT).kind
    assert several.words == "; ".join([in_words(ABORT), *[in_words(READ)] * 2, "3 more"])
    assert list(several.responses) == [ABORT, *[READ] * 5]


def test_a_kind_is_a_line_and_short() -> None:
    assert Said("it said\nmuch more").kind == Kind("it said")
    assert Said("word " * 40).kind == Kind(("word " * 40)[:MOST_LETTERS])


def test_the_abort_that_was_seen() -> None:
    assert abort_in(Received(ABORT)) == ABORT
    assert [abort_in(seen) for seen in (Received(READ), NoAnswer(), Said("an abort"))] == [None] * 3
