"""What was met before the first case: the device's, or perhaps a lost frame."""

import pytest

from conformance.beginning.repeating import Met, in_doubt, is_settled, met_with
from conformance.device.device import Device
from conformance.device.effort import TRIES_OF_CASE
from conformance.device.learned import Reason, Unread
from conformance.dialogue.causes import Causes
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import ANSWERED, Cause, Violation

A, B = ("a", "here"), ("b", "there")


@pytest.mark.parametrize(
    ("tries", "settled", "doubtful"),
    [
        ([{}], True, []),
        ([{A}], False, []),
        ([{A}, {}], True, ["a"]),
        ([{A}, {A}], True, []),
        ([{A, B}, {A}], True, ["b"]),
        ([{A}, {B}], False, ["a"]),
        ([{A}, {B}, {A}], True, ["b"]),
        ([{A}, {("a", "elsewhere")}], False, []),
        ([{A}, {("a", "elsewhere")}, {("a", "nowhere")}], True, []),
        ([{(str(number), "")} for number in range(TRIES_OF_CASE)], True, ["0", "1", "2", "3"]),
    ],
)
def test_what_was_met_before_the_first_case(
    tries: list[Met], settled: bool, doubtful: list[str]
) -> None:
    met = [frozenset(one) for one in tries]
    assert is_settled(met) is settled
    assert in_doubt(met) == doubtful


def test_what_counts_as_met() -> None:
    device, causes = Device(5), Causes()
    assert met_with(device, causes) == frozenset()
    device.learned.unread[Multiplexer(0x1008)] = Unread(Reason.BREACH)
    silence = Violation(ANSWERED, expected="an answer", actual="nothing")
    causes.add(Cause(ANSWERED.id, "no answer"), "before", silence, aside=True)
    assert met_with(device, causes) == {
        ("a read of 1008h:00", ""),
        ("response.answered: no answer", str(silence)),
    }
