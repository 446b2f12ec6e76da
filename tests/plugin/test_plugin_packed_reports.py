"""Reports of workers are packed on their way, and arrive as they were."""

from typing import Any

import pytest
from plugin_runs import QUICK, reports

from conformance.plugin.packed_reports import KEY, Packing

pytest_plugins = ["pytester"]

# Writes down what other plugins see of a report, where the run is reported.
OBSERVER = """
    NAMES = "nodeid location when outcome longrepr sections user_properties conformance".split()

    class Observer:
        def pytest_runtest_logreport(self, report):
            seen = {name: getattr(report, name) for name in NAMES if hasattr(report, name)}
            if "conformance" in seen:
                seen["conformance"] = {
                    name: type(value) if isinstance(value, float) else value
                    for name, value in seen["conformance"].items()
                }
            seen["user_properties"] = [p for p in seen["user_properties"] if p[0] != "latency-ms"]
            with open("seen.txt", "a", encoding="utf-8") as file:
                print(type(report).__name__, seen, file=file)

    def pytest_configure(config):
        if not hasattr(config, "workerinput"):
            config.pluginmanager.register(Observer())
"""
OWN = """
    import pytest

    def test_own(record_property, sdo):
        record_property("set", {1, 2})
        record_property("pairs", [(1, b"2"), (None, 3.5)])
        print("said")

    def test_skipped(sdo):
        pytest.skip("today")
"""


def packed(values: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return what goes to the controller where pytest has made these values of a report."""
    packing = Packing().pytest_report_to_serializable()
    next(packing)
    with pytest.raises(StopIteration) as stop:
        packing.send(values)
    result: dict[str, Any] | None = stop.value.value
    return result


def test_other_plugins_see_the_same_reports(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(OBSERVER)
    pytester.makepyfile(test_own=OWN)
    seen = []
    for workers in ("0", "1"):
        folder = f"--sdo-report-dir={reports(pytester)}"
        own = ("--self-test", "--sdo-simulated", "test_own.py", "-n", workers)
        result = pytester.runpytest_subprocess(*QUICK, folder, *own)
        result.assert_outcomes(passed=1, skipped=1)
        seen.append((pytester.path / "seen.txt").read_text(encoding="utf-8").splitlines())
        (pytester.path / "seen.txt").unlink()
    assert len(seen[0]) == 6
    assert seen[0] == seen[1]


def test_a_report_becomes_one_value() -> None:
    values = packed({"user_properties": [("a", 1)], "longrepr": ("file", 3, "why")})
    assert values is not None
    assert values.keys() == {KEY}
    assert isinstance(values[KEY], bytes)


def test_what_cannot_be_packed_goes_as_it_is() -> None:
    values = {"user_properties": [("a", object())]}
    assert packed(values) is values


def test_no_values_stay_none() -> None:
    assert packed(None) is None
