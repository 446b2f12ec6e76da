"""Cases on several channels and with NMT: what they configure is undone however they end."""

from collections.abc import Generator
from dataclasses import replace

import pytest
from support.run_bench import NODE_ID, NUMBER, TEXT, Workbench, discovered

from conformance.device.device import DEVICE_TYPE
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.permits import Permits
from conformance.device.protected_objects import PERMISSIONS
from conformance.device.safety import WritePolicy
from conformance.dialogue.channels import TEST_CHANNELS, Channels, interleave
from conformance.dialogue.network import Network
from conformance.faults.catalogue import build_node
from conformance.reference.node import Node
from conformance.run.case_run import CaseRun, begin_case
from conformance.run.evidence import trace_texts
from conformance.run.session import DeviceSession
from conformance.run.verdict import Verdict
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import Step
from conformance.sdo.cob_id import CobId
from conformance.sdo.frames import Abort, Response, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import TRANSITIONS, NmtCommand, NmtState
from conformance.sdo.rules import Level, Rule, Violation

RULE = Rule("test.rule", "7.2.4", Level.MUST, "What the case is about.")
FIRST, SECOND = TEST_CHANNELS
LATE = "nmt-state-changes-after-70-ms"


def allow(bench: Workbench) -> None:
    """Let the cases do what users have to permit."""
    writable = [known.mux for known in bench.device.objects if known.access.writable]
    bench.device = replace(
        bench.device,
        permits=Permits(permissions=PERMISSIONS),
        policy=WritePolicy(writable, PERMISSIONS),
    )


def case(session: DeviceSession) -> CaseRun:
    return begin_case(session, "test.case", "test", RULE)


def violation() -> Violation:
    return Violation(RULE, expected="this", actual="that")


@pytest.fixture
def node() -> Node:
    return build_node(None, NODE_ID)


@pytest.mark.parametrize("error", [None, violation(), AssertionError("own")], ids=repr)
def test_channels_are_put_back(node: Node, error: Exception | None) -> None:
    records = [channel.record for channel in node.channels[1:]]
    records[0].entries[1].value = bytes(CobId(0x6B1))
    records[0].entries[2].value = bytes(CobId(0x6B2))
    with discovered(node) as bench:
        allow(bench)
        run = case(bench.session())
        run.tools.channels.configure(0x1201, FIRST)
        run.tools.channels.configure(0x1202, SECOND)
        assert records[0].request == FIRST.request
        result = run.conclude(error)
    assert (records[0].request, records[0].response) == (CobId(0x6B1), CobId(0x6B2))
    assert not records[1].is_valid
    assert result.verdict is (Verdict.FAIL if error else Verdict.PASS)


@pytest.mark.parametrize(
    "command", [NmtCommand.STOP, NmtCommand.START, NmtCommand.RESET_NODE], ids=str
)
def test_the_device_serves_again_however_a_case_ends(node: Node, command: NmtCommand) -> None:
    with discovered(node) as bench:
        allow(bench)
        session = bench.session()
        run = case(session)
        run.tools.network.produce_heartbeats()
        run.tools.network.send(command)
        assert run.conclude(violation()).afterwards.value == "idle"
        assert case(session).conclude(None).verdict is Verdict.PASS
        assert session.restorer.unrestored == {}
    assert node.state is NmtState.PRE_OPERATIONAL
    assert node.heartbeat_time.value == bytes(2)


def test_a_boot_up_that_was_asked_for_is_no_reboot(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        session = bench.session()
        run = case(session)
        run.tools.network.reset(NmtCommand.RESET_COMMUNICATION)
        run.tools.network.reset(NmtCommand.RESET_NODE)
        assert run.conclude(None).verdict is Verdict.PASS
        assert session.channel.boot_ups >= 2


def test_one_boot_up_more_than_asked_for_is(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        run = case(bench.session())
        run.tools.network.reset(NmtCommand.RESET_COMMUNICATION)
        bench.send_from_elsewhere(node.start()[0])
        result = run.conclude(None)
    assert result.verdict is Verdict.FAIL
    assert result.broken_rule == "server.no-reboot"


def test_permission_is_asked_for_before_anything_is_sent(node: Node) -> None:
    with discovered(node) as bench:
        sdo = bench.dialogue()
        with pytest.raises(NotTestable, match="--sdo-allow=nmt"):
            Network(sdo).send(NmtCommand.STOP)
        with (
            pytest.raises(NotTestable, match="--sdo-allow=sdo-parameters"),
            Channels(sdo).further(),
        ):
            raise AssertionError("unreachable")
        assert node.state is NmtState.PRE_OPERATIONAL
        assert sdo.record.written == set()


@pytest.mark.parametrize(
    ("name", "records"),
    [(None, (0x1201, 0x1202)), ("one-further-channel", (0x1201,)), ("no-further-channels", ())],
)
def test_which_channels_there_are(name: str | None, records: tuple[int, ...]) -> None:
    with discovered(build_node(name, NODE_ID)) as bench:
        allow(bench)
        sdo = bench.dialogue()
        assert Channels(sdo).records() == records
        with pytest.raises(Unimplemented, match="06020000"):
            Channels(sdo).require(len(records) + 1)


def test_channels_in_use_come_last(node: Node) -> None:
    node.channels[1].record.entries[1].value = bytes(CobId(0x6B1))
    with discovered(node) as bench:
        assert Channels(bench.dialogue()).records() == (0x1202, 0x1201)


def test_transfers_step_by_step(node: Node) -> None:
    """The requests of a round go out before an answer is taken; an abort is a result."""
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        sent: list[int] = []
        sdo.channel.link.listen(lambda captured: sent.append(captured.frame.can_id))
        with Channels(sdo).further() as other:
            sent.clear()
            results = interleave(
                (sdo, sdo.client.download(TEXT.mux, b"fourteen bytes")),
                (other, other.client.download(NUMBER.mux, b"\1\2\3\4")),
            )
    requests = [can_id for can_id in sent if can_id in (0x605, 0x681)]
    assert requests[:3] == [0x605, 0x681, 0x605]
    assert sent[:2] == [0x605, 0x681]
    assert results == [None, None]


def test_a_refused_transfer_does_not_stop_the_others(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        with Channels(sdo).further() as other:
            refused, served = interleave(
                (sdo, sdo.client.upload(Multiplexer(0x1FFF))),
                (other, other.client.upload(Multiplexer(0x1008))),
            )
    assert isinstance(refused, Abort)
    assert refused.code == 0x06020000
    assert getattr(served, "data", None) == bench.device.values[Multiplexer(0x1008)]


def test_a_breach_on_one_channel_leaves_nothing_of_the_others_behind(node: Node) -> None:
    """What they were asked is answered before anything else is sent."""

    def breach() -> Generator[Step, Response, None]:
        yield UploadInitiate(NUMBER.mux)
        raise violation()

    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        with Channels(sdo).further() as other:
            with pytest.raises(Violation):
                interleave((other, breach()), (sdo, sdo.client.upload(TEXT.mux)))
            assert not sdo.drain()
            assert sdo.upload(NUMBER) == bench.device.values[NUMBER.mux]


def test_what_is_left_on_a_channel_fails_the_case(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        with pytest.raises(Violation, match="idle-afterwards"), Channels(sdo).further() as other:
            other.send(UploadInitiate(Multiplexer(0x1018, 1)))


def test_frames_of_all_channels_are_shown_in_words(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        run = case(bench.session())
        with run.tools.channels.further() as other:
            other.upload(Multiplexer(0x1018, 1))
        run.tools.network.send(NmtCommand.START)
        run.sdo.info("shown")
        trace = "\n".join(trace_texts(run.conclude(None)))
    assert "681#4018100100000000 upload initiate 1018h:01" in trace
    assert "6A1#4318100100000C5D upload initiate response 1018h:01" in trace
    assert "000#0105             NMT: start, node 5" in trace


def test_silence_on_a_disabled_channel_is_proven(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        Channels(sdo).expect_no_server(FIRST)
        Channels(sdo).configure(0x1201, FIRST)
        with pytest.raises(Violation, match="no answer on 681h and 6A1h"):
            Channels(sdo).expect_no_server(FIRST)


def test_what_is_odd_on_another_channel_came_of_what_was_sent_there(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        with Channels(sdo).further() as other:
            other.send(UploadInitiate(DEVICE_TYPE))
            answer = other.checks.upload_initiate(other.receive(), DEVICE_TYPE)
            other.checks.upload_initiate(replace(answer, reserved_bits=1), DEVICE_TYPE)
    assert [found.asked for found in sdo.record.minor] == [UploadInitiate(DEVICE_TYPE)]


def test_a_state_is_seen_in_heartbeats(node: Node) -> None:
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        network = Network(sdo)
        assert network.produce_heartbeats() is None
        network.send(NmtCommand.STOP)
        network.settle()
        assert node.state is NmtState.STOPPED
        network.end()
        network.settle()
        assert sdo.fence() == []


@pytest.mark.parametrize("name", [LATE, f"no-heartbeat+{LATE}"])
def test_a_device_may_take_its_time_to_enter_a_state(name: str) -> None:
    node = build_node(name, NODE_ID)
    with discovered(node) as bench:
        allow(bench)
        network = Network(bench.dialogue())
        network.produce_heartbeats()
        for command, state in TRANSITIONS.items():
            if state is not NmtState.INITIALISING:
                network.send(command)
                assert node.state is not state
                network.settle()
                assert node.state is state
                network.linger()
                assert node.state is state


def test_a_change_of_state_that_is_not_told_is_waited_for_as_long_as_those_that_were(
    node: Node,
) -> None:
    with discovered(node) as bench:
        allow(bench)
        network = Network(bench.dialogue())
        assert network.produce_heartbeats() is None
        for command in (NmtCommand.STOP, NmtCommand.ENTER_PRE_OPERATIONAL):
            network.send(command)
            network.settle()
        network.end_heartbeats()
        assert 0.0 < bench.channel.pace.entering(NmtState.PRE_OPERATIONAL, 60.0) < 60.0


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("heartbeat-time-constant", AbortCode.WRITE_OF_READ_ONLY),
        ("heartbeat-time-constant-5-ms", AbortCode.WRITE_OF_READ_ONLY),
        ("no-heartbeat", AbortCode.OBJECT_MISSING),
        ("heartbeats-of-20-ms-refused", None),
        ("heartbeats-queued", None),
    ],
)
def test_a_device_may_have_its_own_way_with_heartbeats(name: str, code: AbortCode | None) -> None:
    node = build_node(name, NODE_ID)
    with discovered(node) as bench:
        allow(bench)
        sdo = bench.dialogue()
        network = Network(sdo)
        refusal = network.produce_heartbeats()
        assert (refusal and refusal.code) == code
        network.send(NmtCommand.START)
        network.settle()
        assert node.state is NmtState.OPERATIONAL
        if refusal is None:
            network.end_heartbeats()


def test_heartbeats_that_do_not_end() -> None:
    with discovered(build_node("nmt-heartbeat-for-ever", NODE_ID)) as bench:
        allow(bench)
        sdo = bench.dialogue()
        network = Network(sdo)
        assert network.produce_heartbeats() is None
        with pytest.raises(Violation, match="no heartbeat with 1017h = 0"):
            network.end_heartbeats()
