"""A device that takes what it has to refuse is as before behind a whole run, or the run says so."""

import json
from collections.abc import Iterator
from typing import Any

import pytest
from run_audit import ALSO_WRITABLE, run
from support.run_bench import NODE_ID, Recording

from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import BlockDownloadInitiate, DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType, Entry, Refusal

pytest_plugins = ["pytester"]

# In seconds; each silence that a case awaits takes the response time-out of one second.
MOST_WAITED = 10.0
PROBES = "--sdo-allow=read-only-probes"
DEVICE_TYPE = Multiplexer(0x1000)
COUNTER, CONSTANT = Multiplexer(0x2006), Multiplexer(0x2007)
NAMED = (
    "2001=unsigned8",
    "2004=unsigned32",
    "2010=visible_string",
    "2006=unsigned32,ro",
    "2007=unsigned32,const",
)
# What writes where a right device refuses it, and what writes anything at all by chance.
CHOSEN = (
    "test_expedited_download or read-only or missing or sub-index or matrix.idle[2 or "
    "matrix.idle[C4h or random.any-frames or segmented-download.size"
)
SHORT = f"({CHOSEN}) and not 409 and not 88 and not 177 and not 449"


def entries() -> dict[Multiplexer, Entry]:
    """Return a device that is not the reference server, with a read-only number and a constant."""
    found = reference_entries(NODE_ID) | ALSO_WRITABLE
    found[DEVICE_TYPE].value = bytes.fromhex("92010200")
    found[COUNTER] = Entry(b"\1\2\3\4", DataType.UNSIGNED32, Access.RO)
    found[CONSTANT] = Entry(b"\5\6\7\x08", DataType.UNSIGNED32, Access.CONST)
    return found


class Taking(Recording):
    """Takes writes to what is read-only, in the initiate, in segments or in blocks."""

    takes: tuple[str, ...] = ("expedited", "segmented", "blocks")

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        service = "expedited" if request.expedited else "segmented"
        if service in self.takes:
            return self.objects.find(request.mux)
        return super().entry_to_write(request)

    def entry_to_write_in_blocks(self, request: BlockDownloadInitiate) -> Entry:
        if "blocks" in self.takes:
            return self.objects.find(request.mux)
        return super().entry_to_write_in_blocks(request)


class Emptying(Taking):
    """Forgets what an object holds as soon as a segmented write begins."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        entry = super().entry_to_write(request)
        if not request.expedited and not entry.access.writable:
            entry.value = bytes(len(entry.value))
        return entry


class Misplacing(Recording):
    """Writes what is for a sub-index that is missing to sub-index 0."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        try:
            return super().entry_to_write(request)
        except Refusal as refusal:
            if refusal.code != AbortCode.SUB_INDEX_MISSING:
                raise
            return self.objects.writable(Multiplexer(request.mux.index))


class Neighbouring(Recording):
    """Writes some values of a string into a number as well."""

    def store(self, entry: Entry, data: bytes) -> None:
        super().store(entry, data)
        if entry.data_type is DataType.VISIBLE_STRING and len(self.writes) % 7 == 0:
            self.entries[Multiplexer(0x2004)].value = data.ljust(4, b"#")[:4]


class Creating(Recording):
    """Takes writes to objects that it does not have, and forgets them."""

    def entry_to_write(self, request: DownloadInitiate) -> Entry:
        try:
            return super().entry_to_write(request)
        except Refusal as refusal:
            if refusal.code != AbortCode.OBJECT_MISSING:
                raise
            return Entry(bytes(4), DataType.UNSIGNED32)


# What could not be read before, and has taken a write.
UNREAD = {Creating: {"5FF7h:00"}, Misplacing: {"2004h:01", "2004h:02", "2004h:FE"}}


def kinds() -> Iterator[Any]:
    for service in Taking.takes:
        kind: type[Recording] = type(f"Taking {service}", (Taking,), {"takes": (service,)})
        yield pytest.param(kind, id=f"takes-{service}")
    yield pytest.param(Taking, id="takes-all")
    yield pytest.param(Emptying, id="empties")
    yield pytest.param(Misplacing, id="takes-any-sub-index")
    yield pytest.param(Neighbouring, id="writes-a-neighbour")
    yield pytest.param(Creating, id="takes-missing-objects")


@pytest.fixture(scope="module")
def ordinary_cost() -> list[int]:
    """Return how many frames the run of a right device has taken, once that is known."""
    return []


def listed(pytester: pytest.Pytester) -> set[str]:
    """Return what the journal of a run says that is not back."""
    left: set[str] = set()
    for path in pytester.path.glob("reports/*/not-restored*.jsonl"):
        for line in path.read_text("ascii").splitlines():
            record = json.loads(line)
            if record["record"] in ("changed", "taken"):
                left.add(record["object"])
            elif record["record"] == "back":
                left.discard(record["object"])
    return left


def cost_of(pytester: pytest.Pytester, server: Recording, *statuses: int) -> int:
    """Run the cases; return how many frames were sent. The machine decides on the seconds."""
    result = run(pytester, server, Node(NODE_ID, server), "-k", SHORT, PROBES, named=NAMED)
    assert result.ret in statuses
    logs = sorted(pytester.path.glob("reports/*/bus.log"))
    return logs[-1].read_text("ascii").count(" T\n")


def waited(pytester: pytest.Pytester) -> float:
    """Return how many seconds the cases of the last run have waited for answers in vain."""
    path = sorted(pytester.path.glob("reports/*/results.jsonl"))[-1]
    records = map(json.loads, path.read_text("ascii").splitlines())
    cases = [record["result"] for record in records if record["record"] == "case"]
    return sum(float(case["waited"]) for case in cases)


@pytest.mark.parametrize("kind", list(kinds()))
def test_what_is_not_back_is_listed(
    pytester: pytest.Pytester, kind: type[Recording], ordinary_cost: list[int]
) -> None:
    if not ordinary_cost:
        right = Recording(entries())
        ordinary_cost.append(cost_of(pytester, right, pytest.ExitCode.OK))
        assert not listed(pytester)
    server = kind(entries())
    begin = server.values()
    # That a neighbour was written is seen behind the last case.
    passes = [pytest.ExitCode.OK] if kind is Neighbouring else []
    cost = cost_of(pytester, server, pytest.ExitCode.TESTS_FAILED, *passes)
    changed = {str(mux) for mux, value in server.values().items() if value != begin[mux]}
    assert changed <= listed(pytester)
    assert listed(pytester) == UNREAD.get(kind, set())
    assert cost < 2 * ordinary_cost[0]
    assert waited(pytester) < MOST_WAITED
