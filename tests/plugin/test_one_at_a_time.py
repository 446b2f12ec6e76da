"""A device may have room for one request: the suite sends the next one when it has served that."""

import pytest
from one_at_a_time import OneAtATime
from plugin_runs import NODE_ID, self_test, the_report

from conformance.logs.reading import RecordedLog, Seen
from conformance.reporting.recorded import read_run
from conformance.sdo.can_frame import CanFrame

pytest_plugins = ["pytester"]
# A run begins with an abort and a read behind it, to know whether the device takes that; these
# cases are about just that.
FIRST_EXCHANGE = 2
ABOUT_IT = {"upload.behind-another", "block-upload.early-acknowledgement"}


def frames(*texts: str) -> list[Seen]:
    """Read lines: a time in milliseconds, an identifier, data bytes."""
    found = []
    for number, text in enumerate(texts, 1):
        time, can_id, data = text.split(maxsplit=2)
        frame = CanFrame(int(can_id, 16), bytes.fromhex(data))
        found.append(Seen(number, float(time) / 1000, "can0", frame))
    return found


INITIATED = ("0 605 C6 00 20 00 1C 00 00 00", "1 585 A4 00 20 00 7F 00 00 00")
SEGMENTS = ("1 605 01 41 42 43 44 45 46 47", "1 605 82 41 42 43 44 45 46 47")


@pytest.mark.parametrize(
    ("texts", "early"),
    [
        (("0 605 40 00 10 00", "0.2 585 43 00 10 00", "0.3 605 40 18 10 01"), []),
        (("0 605 40 00 10 00", "0.2 605 40 18 10 01"), [2]),
        (("0 605 40 00 10 00", "1000 605 40 18 10 01"), []),
        (("0 605 80 00 10 00", "0.1 605 40 18 10 01"), [2]),
        ((*INITIATED, *SEGMENTS, "2 585 A2 02 7F", "2 605 C1 00 00"), []),
        ((*INITIATED, *SEGMENTS, "1 605 80 00 20 00"), [5]),
        ((*INITIATED, *SEGMENTS, "2 585 A2 02 7F", "2 605 C1", "2 605 40 00 10 00"), [7]),
        ((*INITIATED, *SEGMENTS, "2 585 80 00 20 00", "2 605 C1", "2 605 40 00 10 00"), [7]),
        (("0 605 40 00 10 00", "0.1 606 40 00 10 00", "0.1 605 40 00 10 00"), [3]),
    ],
)
def test_what_comes_before_the_one_in_front_is_over(
    texts: tuple[str, ...], early: list[int]
) -> None:
    found = OneAtATime(NODE_ID).too_early(frames(*texts))
    assert [seen.number for _, seen in found] == early


def test_a_whole_self_test_asks_one_thing_at_a_time(pytester: pytest.Pytester) -> None:
    self_test(pytester, "--sdo-simulated")
    folder = the_report(pytester)
    recorded = read_run(folder)
    case_of = {
        number: result.case_id.partition("[")[0]
        for result, place in zip(recorded.results, recorded.places, strict=True)
        if place is not None
        for number in range(place.first, place.last + 1)
    }
    early = [
        (case_of.get(seen.number, "outside of the cases"), str(before.frame), str(seen.frame))
        for before, seen in OneAtATime(NODE_ID).too_early(RecordedLog(str(folder / "bus.log")))
        if seen.number > FIRST_EXCHANGE
    ]
    assert len(case_of) > 50_000
    assert {case_id for case_id, *_ in early} == ABOUT_IT, early[:20]
