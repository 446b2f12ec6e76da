"""Random conversations: what they send, how they are kept, and what is left of a failure."""

import itertools
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.run_bench import NODE_ID

from conformance.beginning.discovery import discover
from conformance.bus.channel import Channel
from conformance.bus.link import Captured, Direction, Link
from conformance.device.device import Device
from conformance.device.known_objects import by_multiplexer
from conformance.device.learned import Learned
from conformance.device.safety import WritePolicy, written_by
from conformance.faults.hosting import simulated_bus
from conformance.model_cases.conversations import hunt
from conformance.model_cases.conversations.conversation import (
    Conversation,
    Disturbance,
    Event,
    Kind,
    Service,
    Transfer,
    from_lines,
    to_lines,
)
from conformance.model_cases.conversations.device_objects import harmless
from conformance.model_cases.conversations.plan import SearchPlan
from conformance.model_cases.conversations.search import ConversationSearch
from conformance.model_cases.conversations.store import FailingStore
from conformance.model_cases.conversations.trials import Failure, Trials
from conformance.reference.built_in_device import REFERENCE_OBJECTS
from conformance.run.case_run import CaseRun, begin_case
from conformance.run.session import DeviceSession
from conformance.sdo.decoding import decode_request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import Level, Rule, Violation

RULE = Rule("random.test", "7.2.4", Level.MUST, "What the case is about.")
TEXT = Multiplexer(0x2010)
NOWHERE = Multiplexer(0x7E7E, 0x2B)


class Searched:
    """One device, simulated, on which searches are made; ``sent`` is all that it got."""

    def __init__(self, server: str | None, folder: Path) -> None:
        link = Link(simulated_bus([NODE_ID], server), "simulated")
        writable = [known.mux for known in REFERENCE_OBJECTS if known.access.writable]
        device = Device(NODE_ID, by_multiplexer(REFERENCE_OBJECTS), policy=WritePolicy(writable))
        channel = Channel(link, NODE_ID, 0.05)
        discover(channel, device)
        self.sent: list[str] = []
        link.listen(self._keep)
        self.session = DeviceSession(channel, device, seed=1, cansend_channel="can0")
        self.store = FailingStore.of(folder, NODE_ID, RULE.id)

    def _keep(self, captured: Captured) -> None:
        if captured.direction is Direction.SENT:
            self.sent.append(str(captured.frame))

    def search(self, kind: Kind, plan: SearchPlan) -> CaseRun:
        run = begin_case(self.session, RULE.id, "random", RULE)
        ConversationSearch(self.session, run, plan, self.store).run(kind)
        return run


@pytest.fixture
def reference(tmp_path: Path) -> Searched:
    return Searched(None, tmp_path)


@pytest.mark.parametrize("kind", Kind)
def test_the_reference_server_passes(reference: Searched, kind: Kind) -> None:
    run = reference.search(kind, SearchPlan(40, seed=7))
    assert run.result.progress.startswith("40 of 40 examples in ")
    assert not reference.store.path.exists()


@pytest.mark.parametrize("kind", Kind)
def test_only_what_may_be_written_is_named(reference: Searched, kind: Kind) -> None:
    """Whatever the device takes a frame for."""
    reference.search(kind, SearchPlan(40, seed=8))
    device = reference.session.device
    for text in reference.sent:
        can_id, _, data = text.partition("#")
        if can_id == f"{0x600 + NODE_ID:03X}" and "R" not in data:
            target = written_by(decode_request(bytes.fromhex(data).ljust(8, b"\0")))
            allowed = target is None or device.lacks(target) or device.policy.permits(target)
            assert allowed, text


@given(st.binary(max_size=8))
def test_harmless(data: bytes) -> None:
    device = Device(NODE_ID, policy=WritePolicy([TEXT]), learned=Learned(nowhere=(NOWHERE,)))
    sent = harmless(data, device, TEXT)
    target = written_by(decode_request(sent.ljust(8, b"\0")))
    assert target is None or device.lacks(target) or device.policy.permits(target)
    assert sent[:1] == data[:1]


@pytest.mark.parametrize("kind", Kind)
def test_the_same_seed_sends_the_same_frames(tmp_path: Path, kind: Kind) -> None:
    sent = []
    for seed in (1, 1, 2):
        device = Searched(None, tmp_path)
        device.search(kind, SearchPlan(10, seed))
        sent.append(device.sent)
    assert sent[0] == sent[1] != sent[2]


@pytest.mark.parametrize(
    ("server", "kind", "most"),
    [
        ("third-segmented-upload-late", Kind.SEGMENTED_TRANSFERS, 80),
        ("upload-toggle-ignored", Kind.ANY_FRAMES, 30),
        ("download-not-stored", Kind.SEGMENTED_TRANSFERS, 30),
    ],
)
def test_a_failure_is_shrunk_kept_and_tried_first(
    tmp_path: Path, server: str, kind: Kind, most: int
) -> None:
    device = Searched(server, tmp_path)
    with pytest.raises(Violation) as first:
        device.search(kind, SearchPlan(200, seed=1))
    assert len(device.session.frames) <= most
    kept = device.store.load()
    again = Searched(server, tmp_path)
    with pytest.raises(Violation) as second:
        again.search(kind, SearchPlan(200, seed=99))
    assert second.value.rule == first.value.rule
    assert again.store.load() == kept
    repaired = Searched(None, tmp_path)
    repaired.search(kind, SearchPlan(1, seed=1))
    assert not repaired.store.path.exists()


def test_the_time_is_bounded(reference: Searched) -> None:
    run = reference.search(Kind.ANY_FRAMES, SearchPlan(100, seed=1, search_seconds=0.0))
    assert run.result.progress.startswith("0 of 100 examples")
    assert run.sdo.record.notes == [f"{run.result.progress}, which is as long as it may take"]


DISTURBED: Conversation = (
    Transfer(Service.BLOCK_UPLOAD, TEXT, 14, block_sizes=(1, 2), withheld=(1,)),
    Transfer(
        Service.DOWNLOAD,
        Multiplexer(0x2011, 3),
        disturbances=(
            Disturbance(2, Event.ALTER, 1, 0x80),
            Disturbance(0, Event.INSERT, label="40h"),
        ),
    ),
)


def test_a_conversation_survives_as_text() -> None:
    assert from_lines(to_lines(DISTURBED)) == DISTURBED


@pytest.mark.parametrize("text", ["", "{}", "[1]", "no json", '{"service": "nothing"}'])
def test_what_cannot_be_read_is_no_conversation(tmp_path: Path, text: str) -> None:
    store = FailingStore(tmp_path / "a.jsonl")
    assert store.load() is None
    store.path.write_text(text)
    assert store.load() is None


def test_no_link_is_followed(tmp_path: Path) -> None:
    """Its name can be foreseen: another user could put a link there."""
    precious = tmp_path / "precious"
    precious.mkdir()
    (tmp_path / "failing").mkdir()
    (tmp_path / "failing" / "node-5").symlink_to(precious)
    store = FailingStore.of(tmp_path / "failing", NODE_ID, "random.any")
    with pytest.raises(OSError, match="link"):
        store.save(())
    assert list(precious.iterdir()) == []
    kept = tmp_path / "kept"
    kept.write_text("kept", encoding="utf-8")
    store = FailingStore.of(tmp_path / "other", NODE_ID, "random.any")
    store.path.parent.mkdir(parents=True)
    store.path.symlink_to(kept)
    with pytest.raises(OSError, match="link"):
        store.save(())
    assert kept.read_text(encoding="utf-8") == "kept"


def test_a_kept_conversation_about_an_object_that_is_gone(reference: Searched) -> None:
    gone = Multiplexer(0x5FFF)
    for transfer in (Transfer(Service.EXPEDITED, gone), Transfer(Service.UPLOAD, gone)):
        reference.store.save((transfer,))
        run = reference.search(Kind.SEQUENCES, SearchPlan(5, seed=7))
        assert any("not tried: 5FFFh:00 is gone" in note for note in run.sdo.record.notes)
        assert reference.store.load() == (transfer,)


def test_a_device_that_fails_by_chance_is_no_error_of_the_suite(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """hypothesis draws what it has seen fail once more, and it does not fail."""
    number = itertools.count()
    drawn = st.integers().map(lambda _: (Transfer(Service.UPLOAD, TEXT, content=next(number)),))
    monkeypatch.setattr(hunt, "drawn", lambda kind, objects: drawn)
    searched = Searched("upload-toggle-ignored", tmp_path)
    failing = Failure((), Violation(RULE, expected="a", actual="b"), (), is_known=False)

    def attempt(
        trials: Trials, conversation: Conversation, like: Rule | None = None
    ) -> Failure | None:
        first = conversation and conversation[0].content == 2
        return replace(failing, conversation=conversation) if first else None

    monkeypatch.setattr(Trials, "attempt", attempt)
    with pytest.raises(Violation) as found:
        searched.search(Kind.SEQUENCES, SearchPlan(20, seed=7))
    assert found.value.rule is RULE
