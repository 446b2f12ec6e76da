"""A device that refuses by its state, without permission to look for another state."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from run_bench import NODE_ID, NUMBER, TEXT, Workbench, begin, discovered

from conformance.device.lacking import NotTestable
from conformance.device.roles import Roles
from conformance.device.serving import Refused, Service
from conformance.faults.catalogue import build_node
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.layout import Multiplexer

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
        (fact,) = bench.device.serving.facts
        assert fact == Refused(Service.UPLOAD, None, AbortCode.LOCAL_CONTROL)
        with pytest.raises(NotTestable, match=r"08000021h .* --sdo-allow=nmt"):
            Roles(bench.device).text()


def test_refused_downloads_are_a_fact() -> None:
    with met("writes-refused-in-pre-operational") as (bench, _):
        (fact,) = bench.device.serving.facts
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
        assert not bench.device.serving.facts
        assert Roles(bench.device).text() == TEXT


def test_nothing_is_commanded_without_permission() -> None:
    with met("reads-refused-in-pre-operational") as (bench, _):
        assert bench.device.serving.state is None
        assert bench.device.serving.home is None
