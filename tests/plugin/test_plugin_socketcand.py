"""A bus of another machine, through socketcand: here on the loopback."""

import pytest
from plugin_runs import NO_HYPOTHESIS, NODE_ID, hosted_on, run
from socketcand_bus import socketcand
from support.selected_files import other_files

from conformance.bus.opening import SOCKETCAND_OPENINGS
from conformance.faults.catalogue import build_node
from conformance.plugin.exit_code import ExitCode

pytest_plugins = ["pytester"]

# The rest shows on other buses as well.
CHOSEN = (
    "not test_matrix and not test_random and not sequence and not vanished and not size[ "
    "and not beyond"
)


def test_a_run(pytester: pytest.Pytester) -> None:
    """All but cases with remote frames, which python-can cannot send there."""
    named = ("--sdo-object=2004=unsigned32", "--sdo-object=2010=visible_string")
    with socketcand() as bus, hosted_on(bus, build_node(None, NODE_ID)):
        result = run(pytester, f"--node-id={NODE_ID}", *bus, *named, "-v", "-k", CHOSEN)
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes()["passed"] > 400
    result.stdout.fnmatch_lines(["not testable (3 cases): needs remote frames, *socketcand*"])


def test_several_devices_on_one_bus(pytester: pytest.Pytester) -> None:
    """Workers meet on it: none takes another for a second client, each frame is logged once."""
    chosen = ("-k", "abort. or frame.other or frame.one or upload.identity", "-n", "2")
    with socketcand() as bus, hosted_on(bus, build_node(None, 4), build_node(None, 5)):
        result = pytester.runpytest_subprocess(
            *NO_HYPOTHESIS,
            *("-p", "no:cacheprovider", "--sdo-report-dir=left behind", "--node-id=4,5"),
            *bus,
            *chosen,
            *other_files(chosen),
        )
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(
        [
            "not testable (1 case): node 5 is under test as well: test node 4 alone",
            "not testable (1 case): node 4 is under test as well: test node 5 alone",
        ]
    )
    (log,) = (pytester.path / "left behind").glob("*/bus*.log")
    lines = log.read_text(encoding="utf-8").splitlines()
    requests = [line for line in lines if " 604#" in line or " 605#" in line]
    assert requests
    assert all(line.endswith(" T") for line in requests)


@pytest.mark.parametrize("crowded", [1, SOCKETCAND_OPENINGS - 1])
def test_a_bus_with_traffic(pytester: pytest.Pytester, crowded: int) -> None:
    """A frame comes together with the daemon's answer, and python-can takes it for a part of it."""
    with socketcand(crowded_openings=crowded) as bus, hosted_on(bus, build_node(None, NODE_ID)):
        result = run(pytester, f"--node-id={NODE_ID}", *bus, "-k", "upload.identity")
    assert result.ret == pytest.ExitCode.OK


def test_a_bus_that_is_too_crowded(pytester: pytest.Pytester) -> None:
    with socketcand(crowded_openings=2 * SOCKETCAND_OPENINGS) as bus:
        result = run(pytester, f"--node-id={NODE_ID}", *bus, "-k", "upload.identity")
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["*cannot be opened: Expected '< ok >' got: '< ok >< frame*"])


def test_a_device_that_is_wrong(pytester: pytest.Pytester) -> None:
    wrong = build_node("identity-count-wrong", NODE_ID)
    with socketcand() as bus, hosted_on(bus, wrong):
        result = run(pytester, f"--node-id={NODE_ID}", *bus, "-k", "upload.identity")
    assert result.ret == pytest.ExitCode.TESTS_FAILED


def test_a_bus_that_is_not_served(pytester: pytest.Pytester) -> None:
    with socketcand() as bus:
        elsewhere = ("--can-channel=vcan8", "-k", "abort.frame")
        result = run(pytester, f"--node-id={NODE_ID}", *bus, *elsewhere)
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["socketcand vcan8, host=127.0.0.1, port=* cannot be opened: *"])
