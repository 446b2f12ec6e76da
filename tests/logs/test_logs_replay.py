"""``conformance replay``: the requests of a log, sent again, and the answers judged anew."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

import pytest

from conformance.__main__ import main
from conformance.bus.opening import BusSettings, open_bus
from conformance.commands.status import BROKEN_BENCH, DONE, NOT_ALLOWED, WRONG_USE
from conformance.faults.catalogue import build_node
from conformance.logs import replay_plan
from conformance.logs.reading import RecordedLog
from conformance.logs.replay_plan import NotReplayed, ReplayPlan, read_plan
from conformance.reference.host import HostedNode, NodeHost
from conformance.reference.node import Node
from conformance.run.bench import private_channel
from conformance.sdo.can_frame import CanFrame

ABORT = "605#8000100000000008"
READ = "605#4000100000000000"
UPLOAD = ["605#4008200000000000", "585#4108200008000000", "605#7000000000000000"]
WRITE = ["605#2F01200001000000", "585#6001200000000000"]
# The reference server serves no segment with t = 1 at the beginning; the log has one.
WRONG_TOGGLE = [*UPLOAD, "585#1041424344454647"]
# By their first byte those from 20h on are download initiates, unless in a block.
BLOCK = [
    "605#C210200020010000",
    "585#A410200029000000",
    *(f"605#{number:02X}41424344454647" for number in range(1, 42)),
    "585#A229290000000000",
]


@dataclass
class Listening:
    """A node that writes down what it receives."""

    node: Node
    frames: list[str] = field(default_factory=list)
    deaf: frozenset[str] = frozenset()
    wake_at: float | None = None

    def start(self) -> list[CanFrame]:
        return self.node.start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        self.frames.append(str(frame))
        return [] if str(frame) in self.deaf else self.node.receive(frame)

    def advance(self, now: float) -> list[CanFrame]:
        return self.node.advance(now)


def written(path: Path, frames: Sequence[str], seconds: float = 0.001) -> str:
    lines = (
        f"({100 + number * seconds:.6f}) can0 {frame}\n" for number, frame in enumerate(frames)
    )
    path.write_text("".join(lines))
    return str(path)


def replayed(log: str, *arguments: str, node: HostedNode | None = None) -> int:
    channel = private_channel()
    host = NodeHost(open_bus(BusSettings("virtual", channel)), node or build_node(None, 5))
    with host:
        bus = ("--can-interface=virtual", f"--can-channel={channel}")
        return main(["replay", log, *bus, *arguments])


def calls(task: Callable[[], object]) -> int:
    """Count the functions that are called."""
    found = 0

    def count(_: FrameType, event: str, __: object) -> None:
        nonlocal found
        found += event == "call"

    sys.setprofile(count)
    try:
        task()
    finally:
        sys.setprofile(None)
    return found


def test_a_long_log_takes_no_longer_for_each_frame(tmp_path: Path) -> None:
    """A failing transfer of 65,544 bytes has 10,000 requests."""
    short, long = (written(tmp_path / f"{count}.log", UPLOAD[:2] * count) for count in (100, 400))
    few = calls(lambda: read_plan(RecordedLog(short), None))
    many = calls(lambda: read_plan(RecordedLog(long), None))
    assert many < 6 * few


def test_a_device_that_is_wrong_still(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = written(tmp_path / "a.log", WRONG_TOGGLE)
    assert replayed(log, node=build_node("upload-toggle-ignored", 5)) == NOT_ALLOWED
    told = capsys.readouterr().out
    assert "605#7000000000000000 node 5: upload segment request, t=1\n" in told
    assert "node 5: segmented-upload.toggle (MUST) A toggle bit that did not alternate" in told
    assert "    expected: an abort with 05030000h (toggle bit not alternated)\n" in told
    assert "1 not allowed\n" in told


def test_a_device_that_is_right_now(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert replayed(written(tmp_path / "a.log", WRONG_TOGGLE)) == DONE
    told = capsys.readouterr().out
    assert "node 5: abort 2008h:00, 05030000h (toggle bit not alternated)\n" in told
    assert "    in the log: 585#1041424344454647 upload segment response, t=1, 7 bytes: " in told
    assert "all responses allowed\n" in told
    assert told.splitlines()[-1] == "answered as in the log: 1 of 2"


def test_the_server_is_idle_before_and_afterwards(tmp_path: Path) -> None:
    node = Listening(build_node(None, 5))
    replayed(written(tmp_path / "a.log", UPLOAD[:1]), node=node)
    assert node.frames == [ABORT, UPLOAD[0], ABORT]


def test_a_log_that_writes_needs_a_permission(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    node = Listening(build_node(None, 5))
    log = written(tmp_path / "a.log", [*WRITE, "605#C610200004000000", "000#8205", "605#00"])
    assert replayed(log, node=node) == WRONG_USE
    assert node.frames == []
    assert capsys.readouterr().err == (
        "conformance: The log writes 2001h:00 of node 5, 2010h:00 of node 5 and sends NMT commands "
        "(reset communication, node 5): add --writes to send that to the device.\n"
    )


@pytest.mark.parametrize("frame", ["605#2F012000", "00000605#2F01200001000000", "605#C2012000"])
def test_a_write_in_another_shape_is_one(tmp_path: Path, frame: str) -> None:
    """A wrong server may take it for a download."""
    plan = read_plan(RecordedLog(written(tmp_path / "a.log", [frame])), None)
    assert plan.changes == "writes 2001h:00 of node 5"


def test_segments_of_a_block_are_no_writes(tmp_path: Path) -> None:
    plan = read_plan(RecordedLog(written(tmp_path / "a.log", BLOCK)), None)
    assert plan.changes == "writes 2010h:00 of node 5"


def test_with_the_permission_it_writes(tmp_path: Path) -> None:
    node = Listening(build_node(None, 5))
    assert replayed(written(tmp_path / "a.log", WRITE), "--writes", node=node) == DONE
    assert WRITE[0] in node.frames


def test_nothing_else_is_written_by_a_device_in_another_state(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where the block download is refused now, segment 32 would begin a download of 4241h."""
    node = Listening(build_node("no-block-download", 5))
    log = written(tmp_path / "a.log", BLOCK)
    assert replayed(log, "--writes", node=node) == BROKEN_BENCH
    assert node.frames[-2:] == ["605#1F41424344454647", ABORT]
    assert (
        "605#2041424344454647 and what follows it were not sent: the device is in another state "
        "than in the log, and it would write 4241h:43\n"
    ) in capsys.readouterr().out


def test_a_block_download_is_sent_whole(tmp_path: Path) -> None:
    node = Listening(build_node(None, 5))
    log = written(tmp_path / "a.log", BLOCK)
    replayed(log, "--writes", node=node)
    assert [frame for frame in node.frames if frame != ABORT] == [
        frame for frame in BLOCK if frame.startswith("605")
    ]


def test_an_answer_that_does_not_come(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    node = Listening(build_node(None, 5), deaf=frozenset({READ}))
    log = written(tmp_path / "a.log", [READ, "585#4300100000000000", UPLOAD[0]])
    assert replayed(log, "--response-timeout=0.3", node=node) == NOT_ALLOWED
    told = capsys.readouterr().out
    assert "    in the log: 585#4300100000000000 upload initiate response 1000h:00" in told
    assert "1 not allowed" in told


def test_the_last_request_is_waited_for_like_any_other(tmp_path: Path) -> None:
    node = Listening(build_node(None, 5), deaf=frozenset({READ}))
    log = written(tmp_path / "a.log", [READ])
    assert replayed(log, "--response-timeout=0.3", node=node) == NOT_ALLOWED


def test_an_answer_that_the_log_does_not_have(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path / "a.log", [READ, UPLOAD[0], UPLOAD[1]], seconds=0.5)
    assert replayed(log) == DONE
    assert "    in the log: no answer\n" in capsys.readouterr().out


def test_pauses_are_not_repeated(tmp_path: Path) -> None:
    """Behind an answer, and for longer than the response time-out: the log takes three hours."""
    log = written(tmp_path / "a.log", [*UPLOAD[:2], ABORT, READ], seconds=3600)
    assert replayed(log, "--response-timeout=0.3") == DONE


def test_a_boot_up_is_an_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The request behind it would be lost while the device starts."""
    frames = [READ, "585#4300100091010F00", "000#8105", "705#00", READ, "585#4300100091010F00"]
    log = written(tmp_path / "a.log", frames)
    replayed(log, "--writes")
    told = capsys.readouterr().out
    assert told.index("NMT: reset node, node 5") < told.index("boot-up of node 5")
    assert told.index("boot-up of node 5") < told.rindex(READ)


def test_one_of_several_nodes(tmp_path: Path) -> None:
    frames = [READ, "606#2F01200001000000", "586#6001200000000000", "000#8106", "000#0500"]
    plan = read_plan(RecordedLog(written(tmp_path / "a.log", frames)), 5)
    assert [str(step.seen.frame) for step in plan.steps] == [READ, "000#0500"]
    assert plan.changes == "sends NMT commands (000#0500)"


def test_what_is_not_sent_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.log"
    path.write_text(f"(1.000000) can0 {READ} T\n(1.500000) can0 123#40 T\n")
    assert replayed(str(path)) == DONE
    assert capsys.readouterr().err == (
        "conformance: 1 frames with 123h are not sent: that is no default SDO channel\n"
    )


def _of_two_buses(path: Path) -> None:
    path.write_text(f"(1.000000) can0 {READ}\n(1.500000) can1 {READ}\n")


def _without_requests(path: Path) -> None:
    path.write_text("(1.000000) can0 181#00\n")


def _too_many(path: Path) -> None:
    written(path, [READ] * 4)


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (_of_two_buses, "has requests on can0 and on can1"),
        (_without_requests, "has no SDO requests to node 5 on a default channel"),
        (_too_many, "has more than 3 requests"),
    ],
)
def test_logs_that_are_refused(
    make: Callable[[Path], None], why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replay_plan, "MOST_REQUESTS", 3)
    make(tmp_path / "a.log")
    with pytest.raises(NotReplayed, match=why):
        read_plan(RecordedLog(str(tmp_path / "a.log")), 5)


def test_many_objects_are_not_all_named() -> None:
    plan = ReplayPlan(commands=[f"reset node, node {number}" for number in range(1, 31)])
    assert plan.changes.endswith("reset node, node 20 and 10 more)")
