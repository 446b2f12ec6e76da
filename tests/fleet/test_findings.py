"""The suite itself against foreign servers: only cases fail that have a reason to.

A case that fails without a finding is a false alarm or something new; a finding that none of its
cases shows has become invisible, or the server better. A cause that one case has told need not fail
the others.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest
from canopen_server import canopen_device
from durand_server import durand_device
from findings import CANOPEN, DURAND, Finding
from foreign_objects import NODE_ID, ForeignDevice, named_objects, readable

from conformance.device.known_objects import KnownObject
from conformance.run.case_files import case_files
from conformance.run.verdict import Verdict

pytest_plugins = ["pytester"]

Open = Callable[[str, int], AbstractContextManager[ForeignDevice]]
FLEET = pytest.mark.parametrize(
    ("open_device", "findings"),
    [
        pytest.param(canopen_device, CANOPEN, id="canopen"),
        pytest.param(durand_device, DURAND, id="durand"),
    ],
)


@FLEET
def test_findings(
    pytester: pytest.Pytester,
    virtual_channel: str,
    open_device: Open,
    findings: tuple[Finding, ...],
) -> None:
    with open_device(virtual_channel, NODE_ID) as device:
        before = {mux: device.read(mux) for mux in readable(device)}
        shown = list(shown_cases(pytester, virtual_channel, named_objects(device)))
        after = {mux: device.read(mux) for mux in before}
    failed = {case for case, verdict in shown if verdict == Verdict.FAIL}
    known = {case for finding in findings for case in finding.cases}
    assert failed - known == set()
    told = {case for case, _ in shown}
    assert [finding.reason for finding in findings if told.isdisjoint(finding.cases)] == []
    assert after == before


def shown_cases(
    pytester: pytest.Pytester, channel: str, objects: list[KnownObject]
) -> Iterator[tuple[str, str]]:
    """Run the suite in this process, which is where the virtual bus is.

    Yields the cases that failed, and those that something wrong with the device kept from their
    point, with the verdict.
    """
    run = pytester.inline_run(
        f"--node-id={NODE_ID}",
        "--can-interface=virtual",
        f"--can-channel={channel}",
        "--sdo-report-dir=reports",
        "--sdo-allow=read-only-probes",
        "--sdo-allow=other-nodes",
        # The cases are imported under names that no file of this run can have.
        "--import-mode=importlib",
        *(f"--sdo-object={option(known)}" for known in objects),
        # These take a third of the time, and show what shorter ones show.
        *("-k", "not beyond"),
        # What is generated finds the same over and over again.
        *(str(path) for path in case_files() if path.stem not in ("test_matrix", "test_random")),
    )
    assert run.ret in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    for report in run.getreports("pytest_runtest_logreport"):
        properties = dict(report.user_properties)
        wrong = properties.get("verdict") == Verdict.FAIL or "cause" in properties
        if report.when == "call" and wrong:
            yield str(properties["id"]), str(properties["verdict"])


def option(known: KnownObject) -> str:
    """Write an object as --sdo-object takes it."""
    assert known.data_type is not None
    name = f"{known.mux.index:04X}:{known.mux.sub_index:02X}"
    return f"{name}={known.data_type.name.lower()},{known.access}"
