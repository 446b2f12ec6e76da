"""The suite itself against foreign servers: exactly the cases fail that have a reason to.

A case that fails without a finding is a false alarm or something new; one that has a finding and
passes has become blind, or the server better.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest
from canopen_server import canopen_device
from durand_server import durand_device
from findings import CANOPEN, DURAND, Finding
from foreign_objects import NODE_ID, ForeignDevice, named_objects, readable

from conformance.collection import case_files
from conformance.device.objects import KnownObject

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
        failed = list(failed_cases(pytester, virtual_channel, named_objects(device)))
        after = {mux: device.read(mux) for mux in before}
    assert Counter(failed) == Counter(case for finding in findings for case in finding.cases)
    assert after == before


def failed_cases(
    pytester: pytest.Pytester, channel: str, objects: list[KnownObject]
) -> Iterator[str]:
    """Run the suite in this process, which is where the virtual bus is; yield what failed."""
    run = pytester.inline_run(
        f"--node-id={NODE_ID}",
        "--can-interface=virtual",
        f"--can-channel={channel}",
        "--report-dir=reports",
        # The cases are imported under names that no file of this run can have.
        "--import-mode=importlib",
        *(f"--object={option(known)}" for known in objects),
        # What is generated finds the same over and over again.
        *(str(path) for path in case_files() if path.stem not in ("test_matrix", "test_random")),
    )
    assert run.ret in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    for report in run.getreports("pytest_runtest_logreport"):
        properties = dict(report.user_properties)
        if report.when == "call" and properties["verdict"] == "fail":
            yield str(properties["id"])


def option(known: KnownObject) -> str:
    """Write an object as --object takes it."""
    assert known.data_type is not None
    name = f"{known.mux.index:04X}:{known.mux.sub_index:02X}"
    return f"{name}={known.data_type.name.lower()},{known.access}"
