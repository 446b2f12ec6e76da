"""Strings that are empty behind a download which the client has aborted at once."""

import pytest
from judged_logs import told_of

IDLE = "0.0 705#00"
HELLO = ("0.1 > 40 10 20 00", "0.101 < 43 10 20 00 41 42 43 44")
BEGUN = ("0.2 > 20 10 20 00", "0.201 < 60 10 20 00")
SEGMENT = ("0.21 > 00 41 42 43 44 45 46 47", "0.211 < 20")
ABORTED = ("0.3 > 80 10 20 00 00 00 00 08",)
REFUSED = ("0.2 > 20 10 20 00", "0.201 < 80 10 20 00 22 00 00 08")
EMPTY = ("0.4 > 40 10 20 00", "0.401 < 41 10 20 00", "0.402 > 60", "0.403 < 0F")
ONLY_ITS_END = ("0.4 > 40 10 20 00", "0.401 < 4F 10 20 00 00")
WRITTEN = ("0.35 > 2F 10 20 00 00", "0.351 < 60 10 20 00")
ANOTHER = ("0.35 705#00",)


def remarks(*lines: str) -> list[str]:
    told = told_of(IDLE, *lines)
    assert told[-1].endswith("allowed")
    return [line for line in told if "remark" in line]


@pytest.mark.parametrize("empty", [EMPTY, ONLY_ITS_END], ids=["no-byte", "00h"])
def test_it_is_remarked(empty: tuple[str, ...]) -> None:
    (remark,) = remarks(*HELLO, *BEGUN, *ABORTED, *empty)
    assert "2010h:00 was not empty before a download to it" in remark
    assert remarks(*HELLO, *BEGUN, *ABORTED, *empty, *empty) == [remark]


@pytest.mark.parametrize(
    "lines",
    [
        (*BEGUN, *ABORTED, *EMPTY),
        (*HELLO, *EMPTY),
        (*HELLO, *REFUSED, *EMPTY),
        (*HELLO, *BEGUN, *SEGMENT, *ABORTED, *EMPTY),
        (*HELLO, *BEGUN, *ABORTED, *WRITTEN, *EMPTY),
        (*HELLO, *BEGUN, *ABORTED, *ANOTHER, *EMPTY),
    ],
    ids=["never-read", "no-download", "refused", "a-segment", "written", "started-again"],
)
def test_what_may_be_empty_is_not(lines: tuple[str, ...]) -> None:
    assert remarks(*lines) == []
