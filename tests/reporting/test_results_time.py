"""The time of day of a result is that of the place, also where clocks are put forward meanwhile."""

import time
from collections.abc import Iterator
from datetime import UTC, datetime
from types import SimpleNamespace

import pytest

from conformance.reporting import results

pytestmark = pytest.mark.skipif(not hasattr(time, "tzset"), reason="the zone cannot be set here")


@pytest.fixture
def _in_berlin(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    # As POSIX writes the rules of a place: no table of zones is needed.
    with monkeypatch.context() as patch:
        patch.setenv("TZ", "CET-1CEST,M3.5.0,M10.5.0/3")
        time.tzset()
        results._zone.cache_clear()
        yield
    time.tzset()
    results._zone.cache_clear()


@pytest.mark.usefixtures("_in_berlin")
@pytest.mark.parametrize(
    ("second", "written"),
    [
        ("2026-03-29T00:59:59.500+00:00", "2026-03-29T01:59:59.500+01:00"),
        ("2026-03-29T01:00:00.000+00:00", "2026-03-29T03:00:00.000+02:00"),
        ("2026-10-25T00:59:59.999+00:00", "2026-10-25T02:59:59.999+02:00"),
        ("2026-10-25T01:00:00.000+00:00", "2026-10-25T02:00:00.000+01:00"),
    ],
)
def test_around_the_changes_of_the_clock(
    monkeypatch: pytest.MonkeyPatch, second: str, written: str
) -> None:
    moments = [datetime.fromisoformat(second).astimezone(UTC).timestamp() + ago for ago in (-60, 0)]
    monkeypatch.setattr(results, "time", SimpleNamespace(time=iter(moments).__next__))
    results.now()
    assert results.now() == written
