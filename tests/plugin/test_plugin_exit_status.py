"""The exit status: whether the device is right, is wrong, or could not be tested at all."""

import errno
import threading

import can
import pytest
from plugin_runs import NODE_ID, hosted, parsed, reference, reports, run, self_test, the_report

from conformance.faults.catalogue import build_node
from conformance.plugin.exit_code import ExitCode
from conformance.plugin.state import MOST_FULL
from conformance.reference.host import HostedNode
from conformance.reference.node import Node
from conformance.reference.simulated_bus import SimulatedBus
from conformance.run.case_files import CASES
from conformance.sdo.can_frame import CanFrame

pytest_plugins = ["pytester"]

RESPONSE_TIMEOUT = 0.2


class Bystander(HostedNode):
    """Another node: it sends a heartbeat, as others do all the time, when there is traffic."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        return [CanFrame(0x709, b"\x05")]


class Stopped(HostedNode):
    """A device in NMT state Stopped: it has started but does not answer requests."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        return [CanFrame(0x700 + NODE_ID, b"\0")] if frame.can_id == 0x600 + NODE_ID else []


def test_a_device_that_is_right(pytester: pytest.Pytester) -> None:
    assert self_test(pytester, "-k", "abort.frame").ret == 0


def test_a_device_that_is_wrong(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-fault=identity-count-wrong", "-k", "upload.identity")
    assert result.ret == 1
    result.assert_outcomes(failed=1, deselected=result.parseoutcomes()["deselected"])


def test_nothing_selected(pytester: pytest.Pytester) -> None:
    assert self_test(pytester, "-k", "no_such_case").ret == 5


def test_only_what_cannot_be_tested(pytester: pytest.Pytester) -> None:
    """Skipped cases are no failure; the summary says what to add."""
    result = self_test(pytester, "--sdo-object=2001=unsigned8", "-k", "sequence.downloads-unread")
    assert result.ret == 0
    assert set(result.parseoutcomes()) == {"skipped", "deselected"}


# Several devices in turn


class LateInTurn(Node):
    """Answers once more when the run has gone on to the next device."""

    def __init__(self, node_id: int) -> None:
        super().__init__(node_id, build_node(None, node_id).server)
        self.turns: list[int] = []

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if 0x600 < frame.can_id < 0x680 and self.turns[-1:] != [frame.can_id]:
            self.turns.append(frame.can_id)
            if self.turns == [0x605, 0x609] * 2:  # both are discovered first
                return [self.respond(bytes.fromhex("4318100100000000"))]
        return super().receive(frame)


def test_a_late_answer_of_the_device_before(pytester: pytest.Pytester) -> None:
    """It is charged to the device that sent it, though its own late answers were judged already."""
    chosen = "abort.frame or run.no-late-response or upload.identity"
    with hosted(LateInTurn(NODE_ID), build_node(None, 9)) as bus:
        result = run(pytester, f"--node-id={NODE_ID},9", *bus, "-k", chosen)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert set(result.parseoutcomes()) == {"passed", "deselected"}
    result.stdout.fnmatch_lines(
        ["late response after run.no-late-response: *585#4318100100000000*"]
    )
    result.stdout.no_fnmatch_line("*the bench*")


# A silent node


def silent(pytester: pytest.Pytester, *nodes: HostedNode) -> pytest.RunResult:
    """Run against a node that does not answer, among others."""
    timeout = f"--sdo-response-timeout={RESPONSE_TIMEOUT}"
    with hosted(*nodes) as bus:
        # To collect all cases would take longer than to find out that no node answers.
        result = run(pytester, f"--node-id={NODE_ID}", *bus, timeout, str(CASES / "test_abort.py"))
    assert result.ret == 10
    assert not {"passed", "errors"} & set(result.parseoutcomes())
    assert "Traceback" not in result.stdout.str() + result.stderr.str()
    return result


def test_a_silent_node(pytester: pytest.Pytester) -> None:
    result = silent(pytester)
    result.stdout.fnmatch_lines(
        [
            "*= the bench =*",
            "Node 5 does not answer.",
            "  sent: 3 times a read of 1000h on 605h (605#4000100000000000), "
            "waiting 200 ms for 585h each time",
            "  heard: 0 other frames",
            "  check: *bit rate*termination*node-ID*NMT state*",
        ]
    )
    assert result.duration > 3 * RESPONSE_TIMEOUT
    log = (the_report(pytester) / "bus.log").read_text(encoding="utf-8")
    assert len(log.splitlines()) == 5, "three reads, two of them behind an abort"


def test_a_silent_node_among_others(pytester: pytest.Pytester) -> None:
    """Who else is alive says that the bus works and the node-ID may be wrong."""
    result = silent(pytester, Bystander())
    result.stdout.re_match_lines_random(
        [
            r"  heard: \d+ other frames; nodes with heartbeat or boot-up: 9$",
            r"    709#05$",
            r"  check: is the node-ID 5 right, is that node in NMT state Stopped\?$",
        ]
    )


def test_a_node_that_starts_and_does_not_answer(pytester: pytest.Pytester) -> None:
    result = silent(pytester, Stopped())
    result.stdout.re_match_lines_random(
        [r"  heard: \d+ other frames; nodes with heartbeat or boot-up: 5; booted just now: 5\b"]
    )


def test_one_silent_node_of_two(pytester: pytest.Pytester) -> None:
    """The other is tested; a run that leaves a device out does not look like one that does not."""
    chosen = ("--node-id=5,9", "-k", "abort.frame", f"--sdo-response-timeout={RESPONSE_TIMEOUT}")
    with hosted(build_node(None, NODE_ID)) as bus:
        result = run(pytester, *bus, *chosen)
    assert result.ret == ExitCode.SILENT_NODE
    result.stdout.fnmatch_lines(["node 5: 1 pass", "node 9: 1 not run", "Node 9 does not answer."])
    result.stdout.no_fnmatch_line("Node 5 does not answer.")


# A broken bench


def test_an_interface_that_cannot_be_opened(pytester: pytest.Pytester) -> None:
    bus = ("--can-interface=socketcan", "--can-channel=no-such-can0")
    result = run(pytester, "--node-id=5", *bus)
    assert result.ret == 11
    result.stdout.fnmatch_lines(
        ["*= the bench =*", "socketcan no-such-can0 cannot be opened: *. *", "*no tests ran*"]
    )
    assert "Traceback" not in result.stdout.str() + result.stderr.str()


def test_a_report_folder_that_cannot_be_made(pytester: pytest.Pytester) -> None:
    reports(pytester).write_text("a file", encoding="utf-8")
    result = self_test(pytester, "-k", "abort.frame")
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["The report folder *--sdo-report-dir=DIR.*"])


ROGUE = f"""
    import can

    def test_first(sdo):
        assert sdo.fence() == []

    def test_rogue(request):
        channel = request.config.getoption("can_channel")
        with can.Bus(interface="virtual", channel=channel) as bus:
            read = bytes.fromhex("4000100000000000")
            bus.send(can.Message(arbitration_id={0x600 + NODE_ID}, data=read, is_extended_id=False))

    def test_second(sdo):
        assert sdo.fence() == []
"""


def test_a_second_client_between_two_cases(pytester: pytest.Pytester) -> None:
    """Whatever the device answered to it, it is the bench that is wrong."""
    pytester.makepyfile(test_mine=ROGUE)
    with reference() as options:
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == ExitCode.BENCH_ERROR
    outcomes = result.parseoutcomes()
    assert (outcomes["passed"], outcomes["errors"]) == (2, 1)
    result.stdout.fnmatch_lines(
        ["*= the bench =*", "Another node sends SDO requests on 605h*a PLC).*"]
    )


IN_A_CASE = f"""
    import can

    def test_disturbed(sdo, request):
        assert sdo.fence() == []
        channel = request.config.getoption("can_channel")
        with can.Bus(interface="virtual", channel=channel) as bus:
            read = bytes.fromhex("4000100000000000")
            bus.send(can.Message(arbitration_id={0x600 + NODE_ID}, data=read, is_extended_id=False))
            sdo.fence()
"""


def test_a_second_client_in_the_middle_of_a_case(pytester: pytest.Pytester) -> None:
    """It is an error and not a failure of the device, though answers were mixed up."""
    pytester.makepyfile(test_mine=IN_A_CASE)
    with reference() as options:
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == ExitCode.BENCH_ERROR
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*Another node sends SDO requests on 605h*a PLC).*"])


STRANGER = f"""
    import can

    def test_strange(sdo, request):
        channel = request.config.getoption("can_channel")
        with can.Bus(interface="virtual", channel=channel) as bus:
            bus.send(can.Message(arbitration_id={0x580 + NODE_ID}, data=bytes(8)))
        assert sdo.fence() == []
"""


def test_a_stranger_with_the_number_of_the_device_is_told_once(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=STRANGER)
    with reference() as options:
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == 0
    told = f"bench: another node sends 29-bit frames*: {0x580 + NODE_ID:08X}#0000000000000000"
    result.stdout.fnmatch_lines([told])
    properties = parsed(the_report(pytester) / "junit.xml").iter("property")
    assert any(each.attrib["name"] == "bench-notes" for each in properties)


CABLE_OUT = """
    import pytest
    from conformance.reference.simulated_bus import SimulatedBus

    @pytest.mark.parametrize("number", range(6))
    def test_sends(sdo, number):
        SimulatedBus.cable_out = number > 0
        assert sdo.fence() == []
"""


def test_a_cable_that_is_out_ends_the_run(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each case would wait for room in the transmit buffer, for hours."""
    send = SimulatedBus.send

    def send_if_there_is_room(bus: SimulatedBus, msg: can.Message, timeout: float = 0) -> None:
        if getattr(SimulatedBus, "cable_out", False):
            raise can.CanOperationError("Transmit buffer full", errno.ENOBUFS)
        send(bus, msg)

    monkeypatch.setattr(SimulatedBus, "cable_out", False, raising=False)
    monkeypatch.setattr(SimulatedBus, "send", send_if_there_is_room)
    monkeypatch.setattr("conformance.bus.link.SEND_LIMIT", 0.01)
    pytester.makepyfile(test_mine=CABLE_OUT)
    result = self_test(pytester, "--sdo-simulated", "test_mine.py")
    assert result.ret == ExitCode.BENCH_ERROR
    outcomes = result.parseoutcomes()
    assert (outcomes["passed"], outcomes["errors"]) == (1, MOST_FULL)
    result.stdout.fnmatch_lines(["not run: 2 cases of node 5: no frame leaves the interface: *"])


WRITES = """
    from conformance.sdo.layout import Multiplexer

    def test_elsewhere(sdo):
        sdo.download(Multiplexer(0x1004), bytes(2))
"""


def test_a_case_that_would_write_elsewhere(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=WRITES)
    result = self_test(pytester, "test_mine.py")
    assert result.ret == ExitCode.BENCH_ERROR
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*= the bench =*", "*write to 1004h:00*--sdo-object=1004:00*"])
    assert "605#2B0410" not in (the_report(pytester) / "bus.log").read_text(encoding="utf-8")


# A lost device

HALTS = ("--sdo-fault=unknown-specifier-halts", "--sdo-response-timeout=0.1")


def test_a_device_that_is_lost(pytester: pytest.Pytester) -> None:
    """The case that lost it has failed; what follows is not run, and not passed either."""
    result = self_test(pytester, *HALTS, "-k", "segmented-download.foreign")
    assert result.ret == 12
    assert result.parseoutcomes()["failed"] == 1
    result.stdout.fnmatch_lines(
        [
            "segmented-download.foreign[[]unknown-FFh]: FAIL *",
            "  afterwards: lost",
            "*= the bench =*",
            "Node 5 answered before, but does not answer any more*power-cycle it*",
            "not run: 3 cases of node 5: lost in *[[]unknown-FFh]; the run cannot bring it back*",
        ]
    )


def test_what_was_not_run_is_in_the_reports(pytester: pytest.Pytester) -> None:
    """With the reason, in the file of the suite and in that of pytest."""
    self_test(pytester, *HALTS, "-k", "segmented-download.foreign", "--junitxml=all.xml")
    why = "not run: lost in segmented-download.foreign[unknown-FFh]; the run cannot bring it back"
    for path in (the_report(pytester) / "junit.xml", pytester.path / "all.xml"):
        cases = {case.attrib["name"]: case for case in parsed(path).iter("testcase")}
        assert len(cases) == 20, path
        for name in ("unknown-E0h", "unknown-FFh"):
            skipped = cases[f"segmented-download.foreign-later[{name}]"].find("skipped")
            assert skipped is not None
            assert skipped.attrib["message"].startswith(why)


def test_with_v_what_was_not_run_is_named(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *HALTS, "-k", "segmented-download.foreign", "-v")
    result.stdout.fnmatch_lines(["*segmented-download.foreign-later[[]unknown-FFh] NOT RUN*"])


def test_a_silent_device_has_its_cases_in_the_report(pytester: pytest.Pytester) -> None:
    silent(pytester)
    report = (the_report(pytester) / "junit.xml").read_text(encoding="utf-8")
    assert 'message="not run: silent"' in report


def test_what_a_lost_device_was_left_with_is_told(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *HALTS, "-k", "segmented-download.foreign")
    result.stdout.fnmatch_lines(["not restored: write 4 bytes: 74 65 78 74 to 2010h:00 of node 5"])


def test_a_device_that_is_lost_in_the_last_case(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, *HALTS, "-k", "specifier.unknown and FFh and not over")
    assert result.ret == ExitCode.DEVICE_LOST


def test_nothing_keeps_running_afterwards(pytester: pytest.Pytester) -> None:
    before = threading.active_count()
    self_test(pytester, "-k", "abort.frame")
    self_test(pytester, *HALTS, "-k", "segmented-download.foreign")
    silent(pytester)
    assert threading.active_count() == before


@pytest.mark.parametrize("verbose", [[], ["-v"]], ids=["plain", "verbose"])
def test_a_lost_device_is_no_error_of_the_next_one(
    pytester: pytest.Pytester, verbose: list[str]
) -> None:
    """The cases of the first that are left out lie in several files, and the next begins anew."""
    result = self_test(
        pytester,
        *(
            "--node-id=5,9",
            "--sdo-fault=unknown-specifier-halts",
            "--sdo-response-timeout=0.1",
            *verbose,
        ),
        *("-k", "upload.identity or specifier.unknown or specifier.block or independence.refusal"),
        "--junitxml=all.xml",
    )
    assert result.ret == ExitCode.DEVICE_LOST
    outcomes = result.parseoutcomes()
    assert outcomes["failed"] == 2
    assert outcomes.keys() <= {"failed", "passed", "deselected", "skipped"}
    rows = [line for line in result.outlines if line.startswith("node ")]
    assert [row.partition(": ")[2] for row in rows[:2]] == [rows[0].partition(": ")[2]] * 2
    assert "not run" in rows[0]
    for case in parsed(pytester.path / "all.xml").iter("testcase"):
        told = {p.attrib["name"]: p.attrib["value"] for p in case.iter("property")}
        assert (told["verdict"] == "not run") == (case.find("skipped") is not None)
