"""What users read, word by word: the block of a failure and the summary of a run."""

import pytest
from plugin_runs import between, printed, self_test

pytest_plugins = ["pytester"]

FAILURE = """\
download.too-long[2-into-1]: FAIL (MUST, CiA 301 clause 7.2.4.3.17, node 5)
  requirement: More bytes than the type has are refused for their length, and
    nothing is written.
  broken rule: download.too-long
  cause: download.too-long: taken
  expected: abort with 06070012h (length too high) or 06070010h (data type or
    length does not match)
  actual: download initiate response 2001h:00 [60 01 20 00 00 00 00 00]
  afterwards: idle
  frames (> sent, < received, * decisive):
 T ms > 605#4001200000000000 upload initiate 2001h:00
 T ms < 585#4F01200011000000 upload initiate response 2001h:00,
                                      expedited, 1 byte: 11
 T ms > 605#4001200000000000 upload initiate 2001h:00
 T ms < 585#4F01200011000000 upload initiate response 2001h:00,
                                      expedited, 1 byte: 11
 T ms > 605#2F01200010000000 download initiate 2001h:00, expedited, 1
                                      byte: 10
 T ms < 585#6001200000000000 download initiate response 2001h:00
 T ms > 605#40001A0300000000 upload initiate 1A00h:03
 T ms < 585#43001A0300000000 upload initiate response 1A00h:03,
                                      expedited, 4 bytes: 00 00 00 00
 T ms > 605#4002200000000000 upload initiate 2002h:00
 T ms < 585#4B02200011220000 upload initiate response 2002h:00,
                                      expedited, 2 bytes: 11 22
 T ms > 605#4001200000000000 upload initiate 2001h:00
 T ms < 585#4F01200010000000 upload initiate response 2001h:00,
                                      expedited, 1 byte: 10
 T ms > 605#2B01200011010000 download initiate 2001h:00, expedited, 2
                                      bytes: 11 01
  * T ms < 585#6001200000000000 download initiate response 2001h:00
  to repeat what was sent:
    conformance replay 'left behind/RUN/reproduce/01-download.too-long.log' --writes"""

SUMMARY = """\
================================= conformance ==================================
found by reading: 22 objects, by length in bytes 1: 10, 2: 1, 3: 1, 4: 8, more:
    2 (up to 28, 1008h:00); block upload: served
6 pass, 1 non-strict, 3 not testable
7 of 10 cases tested (70 %)
non-strict: frame.extended-ignored: upload initiate response 1018h:01,
    expedited, 4 bytes: 00 00 0C 5D [43 18 10 01 00 00 0C 5D]
not testable (1 case): needs a writable number of 2 bytes: name one of the
    device with its type, as in --sdo-object=2001=unsigned16 (2001h is an
    example; 'conformance init' looks for objects)
not testable (1 case): needs a writable number of 3 bytes: name one of the
    device with its type, as in --sdo-object=2001=unsigned24 (2001h is an
    example; 'conformance init' looks for objects)
not testable (1 case): needs a writable number of 4 bytes: name one of the
    device with its type, as in --sdo-object=2001=unsigned32 (2001h is an
    example; 'conformance init' looks for objects)
reports: FOLDER"""

BAD = """\
================================= conformance ==================================
1 fail
reports: FOLDER
=========================== causes, most cases first ===========================
 1. download.too-long: taken (1 case failed; first download.too-long[2-into-1])

fix this first: download.too-long: taken
    the only failure
    MUST, CiA 301 clause 7.2.4.3.17: An expedited download of more bytes than
    the type has is refused.
    to test it alone: add download.too-long[2-into-1] to the command line
    to see it again:
      conformance replay 'left behind/RUN/reproduce/01-download.too-long.log' --writes"""

SHORT_SUMMARY = """\
=========================== short test summary info ============================
FAILED cases/test_expedited_download.py::download.too-long[2-into-1] - expect..."""


@pytest.fixture(autouse=True)
def as_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the width of the terminal nor what pytest does in CI is looked at."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.delenv("CI", raising=False)


def test_a_failure(pytester: pytest.Pytester) -> None:
    chosen = ("-k", "download.too-long and 2-into-1")
    text = printed(self_test(pytester, "--sdo-fault=download-too-long-accepted", *chosen))
    assert between(text, FAILURE.splitlines()[0], "====") == FAILURE
    assert between(text, BAD.splitlines()[0], "=========================== short") == BAD
    assert between(text, SHORT_SUMMARY.splitlines()[0], "====") == SHORT_SUMMARY


def test_the_summary(pytester: pytest.Pytester) -> None:
    chosen = "extended-ignored or specifier.block-upload or test_expedited_download and stored"
    server = ("--sdo-fault=answers-extended", "--sdo-object=2001=unsigned8")
    result = self_test(pytester, *server, "-k", chosen)
    assert between(printed(result), SUMMARY.splitlines()[0], "====") == SUMMARY
