"""The table of states: the way into each leads there, and what goes on does."""

from pathlib import Path

import pytest
from support.run_bench import NODE_ID, discovered

from conformance.bus.link import Captured, Direction
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.lengths_by_writing import Room
from conformance.faults.catalogue import build_node
from conformance.model_cases.open_transfer import begin
from conformance.model_cases.server_states import (
    BLOCK_DOWNLOAD_BETWEEN,
    BLOCK_DOWNLOADS,
    BLOCK_UPLOAD_BETWEEN,
    BLOCK_UPLOADS,
    SEGMENTED_DOWNLOADS,
    SEGMENTED_UPLOAD_LAST,
    SEGMENTED_UPLOADS,
    SILENT,
    SIZE,
    STATES,
    State,
)
from conformance.model_cases.ways_to_states import LONGEST
from conformance.sdo.frames import BlockSegment, Request

PAGE = Path(__file__).parents[2] / "docs" / "cases.md"
OPEN: dict[str, State[Request]] = {
    **SEGMENTED_DOWNLOADS,
    **SEGMENTED_UPLOADS,
    **BLOCK_DOWNLOADS,
    **BLOCK_UPLOADS,
}
UNUSUAL = [None, "strings-of-8-bytes", "values-of-fixed-length", "blocks-of-1-segment"]


@pytest.mark.parametrize("state", OPEN.values(), ids=OPEN)
@pytest.mark.parametrize("name", UNUSUAL)
def test_what_is_due_goes_on(name: str | None, state: State[Request]) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        sdo = bench.dialogue()
        transfer = begin(sdo, state)
        assert isinstance(transfer.due, BlockSegment) == (state.segment is not None)
        captured: list[Captured] = []
        sdo.channel.link.listen(captured.append)
        sdo.send(transfer.due)
        sdo.end_transfer()
        sdo.fence()
        sdo.channel.link.ignore(captured.append)
    received = [one.frame.data for one in captured if one.direction is Direction.RECEIVED]
    assert [data for data in received if data[0] == 0x80] == [], "an abort"
    # The answer to the fence comes in any case; segments and confirmations may bring no other.
    assert len(received) > 1 or state.segment is not None or state.name == "block-upload-end"


@pytest.mark.parametrize("state", OPEN.values(), ids=OPEN)
@pytest.mark.parametrize("name", UNUSUAL)
def test_a_way_leads_on_to_the_end_of_the_transfer(name: str | None, state: State[Request]) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        sdo = bench.dialogue()
        known = Roles(bench.device).text()
        before = Room(sdo).prepare(known, SIZE, state.least)
        stops = list(state.way(sdo, known, len(before)))
        assert len(stops) == 1
        assert sdo.line.open is None
        assert (sdo.upload(known) != before) == state.downloads
        assert sdo.fence() == []


def test_an_upload_that_is_too_short_for_a_state_is_no_way_there() -> None:
    with discovered(build_node(None, NODE_ID)) as bench:
        sdo = bench.dialogue()
        known = Roles(bench.device).text()
        Room(sdo).store(known, sdo.payload(7), segmented=True)
        for state in (SEGMENTED_UPLOAD_LAST, BLOCK_UPLOAD_BETWEEN):
            with pytest.raises(NotTestable, match="too few"):
                state.reach(sdo, known, SIZE)
            sdo.end_transfer()


def test_a_long_transfer_fills_the_first_sub_block() -> None:
    with discovered(build_node("blocks-of-7-segments", NODE_ID)) as bench:
        sdo = bench.dialogue()
        captured: list[Captured] = []
        sdo.channel.link.listen(captured.append)
        BLOCK_DOWNLOAD_BETWEEN.reach(sdo, Roles(bench.device).text(), LONGEST)
        sdo.channel.link.ignore(captured.append)
        sdo.end_transfer()
    sent = [one.frame.data[0] for one in captured if one.direction is Direction.SENT]
    assert sent[-7:] == [1, 2, 3, 4, 5, 6, 7]


def test_a_client_falls_silent_in_each_state_that_is_not_the_last_of_its_kind() -> None:
    silent = {name for name in OPEN if not name.endswith(("-last", "-sent"))}
    assert set(SILENT) == silent


def test_the_page_of_the_cases_has_the_table() -> None:
    lines = [f"| `{state.name}` | {state.sentence} |" for state in STATES.values()]
    assert "\n".join(lines) in PAGE.read_text(encoding="utf-8")
