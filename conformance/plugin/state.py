"""The state of the plugin during a pytest run, and items as cases."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from typing import Any

import pytest

from conformance.bus.errors import BenchError, BusOff, InterfaceLost, TransmitBufferFull
from conformance.bus.stop import Stop
from conformance.device.not_testable import Missing
from conformance.plugin.findings import Findings
from conformance.plugin.items import DEVICE_SESSION, CaseFunction
from conformance.plugin.options import Options
from conformance.plugin.unrestored import Values
from conformance.reporting.bus_log import BusLog
from conformance.reporting.journal import NAME
from conformance.run.bench import Bench
from conformance.run.case import CaseInfo
from conformance.run.case_run import CaseRun
from conformance.run.risks import Risk
from conformance.run.session import DeviceSession
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.rules import Level, Rule

# After this number of cases in a row, a full transmit buffer is a cable that is unplugged.
MOST_FULL = 3


@dataclass(slots=True)
class RunState:
    """One run: its bench while it is open, and its results so far.

    ``judged_late_answers`` counts, by device, the late answers that a case has judged: others may
    come while the next device is tested. The ``discovered`` descriptions of devices go with the
    first report. Signals that end a run reach ``stop``. ``seconds_left`` says for how long a
    device, by its node-ID, may be tested yet. The ``reserved`` cases are run in thorough runs only.
    """

    options: Options
    bench: Bench | None = None
    log: BusLog | None = None
    results: list[CaseResult] = field(default_factory=list)
    findings: Findings = field(default_factory=Findings)
    stop: Stop = field(default_factory=Stop)
    values: Values | None = None
    discovered: list[dict[str, Any]] = field(default_factory=list)
    seconds_left: Callable[[int], float] = lambda node_id: inf
    judged_late_answers: Counter[int] = field(default_factory=Counter)
    full_in_a_row: int = 0
    reserved: list[CaseInfo] = field(default_factory=list)
    begun: datetime = field(default_factory=lambda: datetime.now(UTC))

    @property
    def report_dir(self) -> Path:
        """The folder of this run."""
        if self.options.share.report_dir is not None:
            return self.options.share.report_dir
        nodes = self.options.node_ids
        which = f"node-{nodes[0]}" if len(nodes) == 1 else f"nodes-{nodes[0]}-to-{nodes[-1]}"
        return self.options.report_dir / f"{self.begun:%Y%m%d-%H%M%S-%f}-{which}"

    @property
    def bus_log(self) -> Path:
        """Where this process writes the frames that it sees."""
        return self.bus_log_of(self.options.share.worker)

    def bus_log_of(self, worker: str) -> Path:
        """Where a worker writes its frames; without a name, the one log of a run."""
        return self.report_dir / (f"bus-{worker}.log" if worker else "bus.log")

    @property
    def journal(self) -> Path:
        """Where this process writes the values that it changes."""
        worker = self.options.share.worker
        return self.report_dir / (f"{NAME}-{worker}.jsonl" if worker else f"{NAME}.jsonl")

    def leave_out_all(self, reason: str) -> None:
        """Test no device of this process any further that is not out of the run already."""
        for node_id in self.options.run.node_ids:
            self.findings.out.setdefault(node_id, reason)

    def heed(self, error: BaseException | None) -> None:
        """Take the error that ended a case: without a bus no other case is run."""
        if isinstance(error, InterfaceLost | BusOff):
            self.leave_out_all("the bus is gone")
        full = isinstance(error, TransmitBufferFull)
        self.full_in_a_row = self.full_in_a_row + 1 if full else 0
        if self.full_in_a_row >= MOST_FULL:
            self.leave_out_all("no frame leaves the interface: its transmit buffer stays full")

    def session(self, node_id: int) -> DeviceSession:
        """Return the session of a device; the bench is open by then."""
        if self.bench is None:
            raise BenchError("The bus is not open: the run ended before the first case.")
        if node_id not in self.bench.sessions:
            raise BenchError(f"Node {node_id} is not tested by this process.")
        return self.bench.sessions[node_id]


STATE = pytest.StashKey[RunState]()
CASE_RUN = pytest.StashKey[CaseRun]()
RESULT = pytest.StashKey[CaseResult]()
REACHED = pytest.StashKey[bool]()
# Plugins may run a case once more, as another try: the results of the earlier tries, and the
# properties that the item had before the first.
EARLIER = pytest.StashKey[list[CaseResult]]()
PROPERTIES = pytest.StashKey[list[tuple[str, object]]]()


def begin_again(item: pytest.Item) -> None:
    """Remove the result of an earlier try from an item that is run once more."""
    properties = item.stash.setdefault(PROPERTIES, list(item.user_properties))
    if RESULT in item.stash:
        item.stash.setdefault(EARLIER, []).append(item.stash[RESULT])
        item.user_properties = list(properties)
        del item.stash[RESULT]


@dataclass(frozen=True, slots=True)
class ItemCase:
    """An item as a case: one of the suite's ``own``, or a test of the user's.

    ``name``, ``state`` and ``stimulus`` stand in its result.
    """

    case_id: str
    service: str
    rule: Rule
    node_id: int
    name: str
    cites: tuple[Rule, ...] = ()
    risk: Risk | None = None
    own: bool = False
    state: str = ""
    stimulus: str = ""

    @property
    def tested_rules(self) -> set[str]:
        """The ids of the rules that the case tests, with its own."""
        return {self.rule.id, *(rule.id for rule in self.cites)}


CASE = pytest.StashKey[ItemCase]()


def uses_device(item: pytest.Item) -> bool:
    """Say whether a test talks to a device."""
    if isinstance(item, CaseFunction) and item.is_own:
        return True
    return DEVICE_SESSION in getattr(item, "fixturenames", ())


def is_left_to(options: Options, item: pytest.Item, place: int) -> bool:
    """Say whether a worker has to run a test, by its place among the collected tests."""
    share = options.share
    if not uses_device(item):
        return share.plain_tests
    node_id = case_of(item).node_id
    strange = node_id not in options.node_ids
    mine = node_id in share.node_ids and share.has_case(place)
    return mine or (strange and share.plain_tests)


def case_of(item: pytest.Item) -> ItemCase:
    """Return the case of an item; an ordinary test counts as a rule of its own."""
    if CASE not in item.stash:
        item.stash[CASE] = _case_of(item)
    return item.stash[CASE]


def _case_of(item: pytest.Item) -> ItemCase:
    if isinstance(item, CaseFunction):
        info = item.case
        return ItemCase(
            item.case_id,
            item.service,
            info.rule,
            item.node_id,
            info.rule.id,
            info.cites,
            item.risk,
            own=item.is_own,
            state=info.state,
            stimulus=item.label if info.state else "",
        )
    doc = getattr(getattr(item, "function", None), "__doc__", None) or "A test of the user's own."
    rule = Rule(item.name, "none", Level.MUST, " ".join(doc.split()))
    node_ids = item.config.stash[STATE].options.node_ids
    callspec = getattr(item, "callspec", None)
    node_id = callspec.params.get("node_id", node_ids[0]) if callspec else node_ids[0]
    name = getattr(item, "originalname", None) or item.name
    return ItemCase(item.name, item.path.stem, rule, node_id, name)


def left_out(
    case: ItemCase, verdict: Verdict, why: str, missing: Missing | None = None
) -> CaseResult:
    """Return the result of a case that was not begun."""
    rule = case.rule
    return CaseResult(
        case.case_id,
        case.service,
        case.node_id,
        rule.level.value,
        rule.clause,
        rule.sentence,
        verdict,
        rules=[each.id for each in case.cites],
        actual=why,
        name=case.name,
        state=case.state,
        stimulus=case.stimulus,
        missing=missing,
    )
