"""What is told of a case is the same on either side of the way to the controller."""

import pytest
from plugin_runs import QUICK, reports

from conformance.plugin.worker_reports import PARCEL

pytest_plugins = ["pytester"]

OTHER = ("-p", "other_plugin", "-n", "1", "-s")
BOTH_SIDES = f"""
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
        assert set(values) == {{{PARCEL!r}}}
        return values

    def pytest_configure(config):
        if not hasattr(config, "workerinput"):
            config.pluginmanager.register(AtTheController())

    class AtTheController:
        def pytest_runtest_logstart(self, nodeid):
            print("here: begin", nodeid)

        def pytest_runtest_logfinish(self, nodeid):
            print("here: end", nodeid)

        def pytest_runtest_logreport(self, report):
            assert report.mine == MINE
            if not report.failed:
                assert type(report.longrepr) is (tuple if report.skipped else type(None))
            print("here:", report.when, report.outcome, report.node.workerinput["workerid"])
"""


PASSES = "vanished-client.next-transfer[block-upload-between]"
SKIPPED = "server-timeout.once[block-upload-between]"
FAILS = "upload.identity"
TOLD = [
    (FAILS, ["begin", "setup passed gw0", "call failed gw0", "teardown passed gw0", "end"]),
    (SKIPPED, ["begin", "setup skipped gw0", "teardown passed gw0", "end"]),
    (PASSES, ["begin", "setup passed gw0", "call passed gw0", "teardown passed gw0", "end"]),
]


def test_the_controller_is_told_what_a_worker_was(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(other_plugin=BOTH_SIDES)
    pytester.syspathinsert()
    chosen = f"{FAILS} or next-transfer and upload-between or timeout.once and upload-between"
    arguments = ("--self-test", "--sdo-fault=identity-count-wrong", "-k", chosen, *OTHER)
    folder = f"--sdo-report-dir={reports(pytester)}"
    result = pytester.runpytest_subprocess(*QUICK, folder, *arguments)
    result.assert_outcomes(passed=1, skipped=1, failed=1)
    told = [line.partition("here: ")[2] for line in result.outlines if "here: " in line]
    begins = [at for at, line in enumerate(told) if line.startswith("begin")]
    by_case = [told[at:end] for at, end in zip(begins, [*begins[1:], len(told)], strict=True)]
    for (case, due), found in zip(TOLD, by_case, strict=True):
        assert found[0].endswith(f"::{case}")
        assert found[-1].endswith(f"::{case}")
        assert [found[0].split()[0], *found[1:-1], found[-1].split()[0]] == due
