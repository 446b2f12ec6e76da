"""What has stopped a device twice by the same cause is not tried a third time."""

from conformance.run.risks import LOST_SEGMENT, REMOTE, Kind, Risk
from conformance.run.stopped_by import MOST_IN_A_ROW, Losses
from conformance.sdo.can_frame import CanFrame

PLAIN = CanFrame(0x605, bytes.fromhex("4000100000000000"))
REMOTE_FRAME = CanFrame(0x605, remote=True, length=8)
READ = Risk(Kind.ORDINARY, "an upload initiate")


def test_an_unusual_frame_counts_wherever_it_is_sent() -> None:
    losses = Losses()
    assert losses.add("frame.remote[0]", REMOTE, [PLAIN, REMOTE_FRAME]) == "a remote frame"
    assert losses.why_not("frame.remote[8]", REMOTE) == ""
    losses.add("matrix.idle[remote-0]", REMOTE, [REMOTE_FRAME])
    assert losses.why_not("matrix.block-upload-end[remote-8]", REMOTE) == (
        "a remote frame has stopped the device twice (in frame.remote[0] and matrix.idle[remote-0])"
    )
    assert losses.why_not("frame.short[4]", None) == ""


def test_what_was_survived_in_between_does_not_excuse_an_unusual_frame() -> None:
    losses = Losses()
    losses.add("frame.remote[0]", REMOTE, [REMOTE_FRAME])
    losses.survived("frame.remote[8]")
    losses.add("frame.remote-ignored", REMOTE, [REMOTE_FRAME])
    assert losses.why_not("matrix.idle[remote-0]", REMOTE)


def test_an_ordinary_frame_counts_in_its_own_state() -> None:
    losses = Losses()
    for label in ("40h", "40h-other"):
        losses.add(f"matrix.block-upload-end[{label}]", READ, [PLAIN])
    assert losses.why_not("matrix.block-upload-end[40h-missing]", READ).startswith(
        "an upload initiate in matrix.block-upload-end has stopped the device twice"
    )
    assert losses.why_not("matrix.idle[40h]", READ) == ""
    assert losses.why_not("matrix.block-upload-end[A1h]", Risk(Kind.ORDINARY, "another")) == ""


def test_where_it_did_not_come_to_that_it_is_the_case() -> None:
    """The way to the point is the same in all variations."""
    losses = Losses()
    for label in ("remote-0", "remote-8"):
        cause = losses.add(f"matrix.idle[{label}]", REMOTE, [PLAIN])
        assert cause == "matrix.idle"
    assert losses.why_not("matrix.idle[40h]", READ).startswith("matrix.idle has stopped")
    assert losses.why_not("frame.remote[0]", REMOTE) == ""


def test_a_case_that_is_survived_in_between_is_not_the_cause() -> None:
    """One object of a thousand may stop a device; the others are read all the same."""
    losses = Losses()
    losses.add("od.read[2001h:00]", None, [PLAIN])
    losses.survived("od.read[2002h:00]")
    losses.add("od.read[2003h:00]", None, [PLAIN])
    assert losses.why_not("od.read[2004h:00]", None) == ""
    assert losses.lines() == ["od.read stopped the device: od.read[2001h:00], od.read[2003h:00]"]


def test_a_device_that_is_always_gone_is_given_up() -> None:
    losses = Losses()
    for number in range(MOST_IN_A_ROW - 1):
        losses.add(f"case.{number}", None, [])
    losses.survived("case.other")
    for number in range(MOST_IN_A_ROW):
        assert not losses.is_hopeless
        losses.add(f"case.{number}", None, [])
    assert losses.is_hopeless


def test_a_device_that_answers_wrongly_is_brought_back_once() -> None:
    losses = Losses()
    wrong = [True, False, True, True, True, True, False, True, True]
    told = [losses.is_wedged(answers_wrongly=each) for each in wrong]
    assert told == [False, False, False, True, False, False, False, False, True]


def test_what_is_unusual_may_stop_it_as_often_as_it_likes() -> None:
    losses = Losses()
    for number in range(MOST_IN_A_ROW * 2):
        losses.add(f"case.{number}", LOST_SEGMENT, [])
    assert not losses.is_hopeless
