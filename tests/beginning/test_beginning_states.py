"""A device that refuses by its state: what is known of it, and where cases run."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from support.run_bench import NODE_ID, NUMBER, PROBES, TEXT, Workbench, begin, discovered

from conformance.beginning.revival import Revival
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.device.permits import Permits
from conformance.device.process import DeviceProcess, ProcessSettings
from conformance.device.protected_objects import NMT
from conformance.device.serving import Refused, Service
from conformance.faults.catalogue import build_node
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand, NmtMessage, NmtState

MISSING_AMONG = Multiplexer(0x2006)


@contextmanager
def met(name: str) -> Iterator[tuple[Workbench, DeviceSession]]:
    """Get to know a server of the catalogue as a run does."""
    with discovered(build_node(name, NODE_ID)) as bench:
        session = bench.session()
        session.survey()
        yield bench, session


def test_refused_uploads_are_a_fact() -> None:
    with met("locked-until-a-password") as (bench, _):
        (fact,) = bench.device.learned.serving.facts
        assert fact == Refused(Service.UPLOAD, None, AbortCode.LOCAL_CONTROL)
        with pytest.raises(NotTestable, match=r"08000021h .* --sdo-allow=nmt"):
            Roles(bench.device).text()


def test_refused_downloads_are_a_fact() -> None:
    with met("writes-refused-in-pre-operational") as (bench, _):
        (fact,) = bench.device.learned.serving.facts
        assert fact == Refused(Service.DOWNLOAD, None, AbortCode.DEVICE_STATE)
        with pytest.raises(NotTestable, match=r"08000022h .* --sdo-allow=nmt"):
            Roles(bench.device).number()


@pytest.mark.parametrize("mux", [NUMBER.mux, MISSING_AMONG])
def test_a_case_that_meets_it_is_not_testable(mux: Multiplexer) -> None:
    with met("locked-until-a-password") as (_, session):
        run = begin(session)
        with pytest.raises(NotTestable) as met_on_the_way:
            run.sdo.read(mux)
        assert run.conclude(met_on_the_way.value).verdict is Verdict.NOT_TESTABLE


def test_what_is_served_is_no_fact() -> None:
    with met("locked-for-now") as (bench, _):
        assert not bench.device.learned.serving.facts
        assert Roles(bench.device).text() == TEXT


def test_nothing_is_commanded_without_permission() -> None:
    with met("reads-refused-in-pre-operational") as (bench, _):
        assert bench.device.learned.serving.state is None
        assert bench.device.learned.serving.home is None


class Rebooting(Revival):
    """Brings a device back by a reset of the node, as a power cycle does."""

    def __init__(self, bench: Workbench, folder: Path) -> None:
        settings = ProcessSettings(recover=["true"])
        super().__init__(settings, DeviceProcess(settings, folder / "log"), bench.channel)
        self._reset = bench.channel.send_nmt

    def attempt(self) -> str:
        self._reset(NmtMessage(NmtCommand.RESET_NODE, NODE_ID))
        return super().attempt()


def test_a_device_that_was_brought_back_serves_the_next_case(tmp_path: Path) -> None:
    """It has booted, and refuses downloads until it is Operational."""
    with discovered(build_node("writes-refused-in-pre-operational", NODE_ID)) as bench:
        bench.device = replace(bench.device, permits=Permits(permissions=PROBES | {NMT}))
        session = bench.session()
        session.survey()
        assert bench.device.learned.serving.home is NmtState.OPERATIONAL
        session.revival = Rebooting(bench, tmp_path)
        session.lost = True
        assert session.revive() == ""
        run = begin(session)
        value = bench.device.values[NUMBER.mux]
        assert run.sdo.try_download(NUMBER, value) is None
        assert run.conclude(None).verdict is Verdict.PASS
