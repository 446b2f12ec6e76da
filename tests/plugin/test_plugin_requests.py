"""What a run costs is counted in requests: there are so many at the most, on any machine."""

from itertools import groupby
from pathlib import Path

import pytest
from plugin_runs import self_test, the_report

from conformance.reference import dictionary
from conformance.reference.built_in_device import reference_entries
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry

pytest_plugins = ["pytester"]

DOMAIN = Multiplexer(0x2011)
SENT, RECEIVED = "T", "R"


def counted(log: Path) -> tuple[int, int]:
    """Return how many frames the suite has sent, and how often it has waited for an answer."""
    directions = [line.rpartition(" ")[2] for line in log.read_text("utf-8").splitlines()]
    answers = sum(direction == RECEIVED for direction, _ in groupby(directions))
    return directions.count(SENT), answers


# On a device with a domain of 4 KB: 52,400 answers and 67,500 frames when this was written, of
# which 9,363 are the segments of one block download beyond 16 bits, with 75 answers. The self-test
# takes less: 43,900 answers and 57,900 frames.
LENGTH, MOST_ANSWERS, MOST_FRAMES = 4096, 53_500, 68_500


def test_requests_of_a_run(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    def entries(node_id: int) -> dict[Multiplexer, Entry]:
        found = reference_entries(node_id)
        found[DOMAIN].value = bytes(position % 251 for position in range(LENGTH))
        return found

    monkeypatch.setattr(dictionary, "reference_entries", entries)
    assert self_test(pytester, "--sdo-simulated", "-p", "no:xdist").ret == 0
    frames, answers = counted(the_report(pytester) / "bus.log")
    assert answers <= MOST_ANSWERS
    assert frames <= MOST_FRAMES
