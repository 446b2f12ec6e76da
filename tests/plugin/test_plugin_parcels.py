"""What a report says is the same on either side of the way to the controller."""

import pytest
from plugin_runs import QUICK, reports

from conformance.parcels import KEY

pytest_plugins = ["pytester"]

OTHER = ("-p", "other_plugin", "-n", "1", "-s")
BOTH_SIDES = f"""
    import os
    import pytest

    MINE = {{"tuple": ("a", 1), "list": [None, 2.5], "text": "\\u20ac"}}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport():
        report = yield
        report.mine = MINE
        return report

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_report_to_serializable():
        values = yield
        assert set(values) == {{{KEY!r}}}
        return values

    def pytest_runtest_logreport(report):
        if "PYTEST_XDIST_WORKER" not in os.environ:
            assert report.mine == MINE
            assert type(report.longrepr) is (tuple if report.skipped else type(None))
            print("here:", report.when, report.outcome)
"""


def test_what_other_plugins_put_into_a_report(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(other_plugin=BOTH_SIDES)
    pytester.syspathinsert()
    chosen = (
        "-k",
        "upload.identity or block-upload-sub-block-sent",
        f"--report-dir={reports(pytester)}",
    )
    result = pytester.runpytest_subprocess(*QUICK, "--self-test", *chosen, *OTHER)
    result.assert_outcomes(passed=2, skipped=2)
    arrived = sorted(line for line in result.outlines if "here: " in line)
    assert len(arrived) == 10, arrived
