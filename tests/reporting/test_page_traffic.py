"""What equal devices say is read once, and counts for each; what only looks equal does not."""

from conformance.reporting.logged import CaseLines
from conformance.reporting.page.traffic import Traffic
from conformance.sdo.cob_id import ChannelIds

READ, ANSWER = "4000100000000000", "4300100091010F00"


def read(node_id: int, sent: str = "T") -> CaseLines:
    """Read 1000h, while heartbeats come; each frame stands in the log, a millisecond later."""
    frames = (
        (f"{0x600 + node_id:03X}#{READ}", sent),
        (f"{0x700 + node_id:03X}#05", "R"),
        (f"{0x580 + node_id:03X}#{ANSWER}", "R"),
    )
    fields = [
        (f"({number / 1000:f})", "can0", frame, direction)
        for number, (frame, direction) in enumerate(frames, start=1)
    ]
    return CaseLines(fields, range(1, len(fields) + 1))


def test_each_device_counts() -> None:
    traffic = Traffic()
    for case, node_id in enumerate((5, 6, 7)):
        ids = ChannelIds.default(node_id)
        traffic.take(case, node_id, ids, read(node_id), in_words=False)
    assert (traffic.requests, traffic.responses) == (3, 3)
    (times,) = traffic.times.values()
    assert [round(seconds, 6) for seconds in times.all] == [0.002] * 3


def test_who_sent_a_frame_counts() -> None:
    """A request of another client is none of ours, nor has it our answer."""
    traffic = Traffic()
    ids = ChannelIds.default(5)
    traffic.take(0, 5, ids, read(5), in_words=False)
    traffic.take(1, 5, ids, read(5, sent="R"), in_words=False)
    assert (traffic.requests, traffic.responses) == (1, 2)


def test_which_device_a_frame_is_of_counts() -> None:
    """What goes over the channel of a neighbour is not said by the device itself."""
    traffic = Traffic()
    traffic.take(0, 5, ChannelIds.default(5), read(5), in_words=False)
    traffic.take(1, 6, ChannelIds.default(6), read(5), in_words=False)
    assert (traffic.requests, traffic.responses) == (1, 1)
