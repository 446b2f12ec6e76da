"""How long the answers of a case may take."""

import pytest
from support.run_bench import NUMBER, RULE, discovered, recording

from conformance.bus.pace import Pace
from conformance.device.not_testable import NotTestable
from conformance.dialogue.slow_device import FACTOR, KNOWN, LEAST, Allowance
from conformance.run.case_run import begin_case
from conformance.run.verdict import Afterwards, Verdict


def pace(seconds: float, answers: int = KNOWN) -> Pace:
    found = Pace()
    for _ in range(answers):
        found.answered(seconds)
    return found


@pytest.mark.parametrize("typical", [0.001, 0.9])
def test_a_device_that_keeps_its_pace_may_take_its_time(typical: float) -> None:
    allowance = Allowance(pace(typical))
    for _ in range(20_000):
        allowance.take(typical * FACTOR)


def test_a_device_that_has_become_slow() -> None:
    allowance = Allowance(pace(0.001))
    for _ in range(int(LEAST) + 1):
        allowance.take(1.0)
    with pytest.raises(NotTestable, match=r"become slow: 62 answers took 62 s, 1000 ms each"):
        allowance.take(1.0)


def test_without_a_pace_there_is_no_limit() -> None:
    allowance = Allowance(pace(0.001, KNOWN - 1))
    for _ in range(1000):
        allowance.take(0.9)


def test_a_case_on_a_device_that_has_become_slow_says_nothing_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("conformance.dialogue.slow_device.LEAST", -1.0)
    with discovered(recording()) as bench:
        session = bench.session()
        session.channel.pace = pace(0.0)
        run = begin_case(session, "upload.size", "upload", RULE)
        with pytest.raises(NotTestable) as slow:
            run.sdo.upload(NUMBER)
        result = run.conclude(slow.value)
    assert (result.verdict, result.afterwards) == (Verdict.NOT_TESTABLE, Afterwards.IDLE)
    assert result.actual.startswith("bench: the device has become slow: 1 answers took")
