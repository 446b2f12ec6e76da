"""The device's program: started for the run, started again when lost, stopped in the end."""

import re
import shlex
import sys
from pathlib import Path

import fragile_server
import pytest
from plugin_runs import NO_HYPOTHESIS, NODE_ID, hosted, run, the_report
from socketcand_bus import socketcand

from conformance.faults.catalogue import build_node
from conformance.plugin.exit_code import ExitCode
from conformance.reference.node import Node
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import BlockAck

pytest_plugins = ["pytester"]

NODE = f"--node-id={NODE_ID}"
WRITABLE = (
    "--sdo-object=2002=unsigned16",
    "--sdo-object=2004=unsigned32",
    "--sdo-response-timeout=0.5",
)


def started(*command: str) -> str:
    return f"--sdo-process={shlex.join([sys.executable, *command])}"


def fragile(pytester: pytest.Pytester, bus: tuple[str, ...], node_id: str = str(NODE_ID)) -> str:
    memory = str(pytester.path / f"memory-{node_id}")
    return started(fragile_server.__file__, node_id, memory, *bus)


def ended(output: str) -> list[bool]:
    """Say of each process that told its number whether it is gone."""
    numbers = [int(number) for number in re.findall(r"^process (\d+)$", output, re.MULTILINE)]
    return [not Path(f"/proc/{number}").exists() for number in numbers]


def device_log(pytester: pytest.Pytester, node_id: int = NODE_ID) -> str:
    return (the_report(pytester) / f"device-{node_id}.log").read_text(encoding="utf-8")


def test_the_reference_server_as_a_program(pytester: pytest.Pytester) -> None:
    with socketcand() as bus:
        serve = started("-m", "conformance", "serve", "--node-id", "{node_id}", *bus)
        result = run(pytester, NODE, *bus, serve, "-k", "abort. or upload.identity")
    assert result.ret == pytest.ExitCode.OK
    assert device_log(pytester).startswith("serving node 5 on socketcand vcan7")


def test_a_program_that_loses_its_first_request(pytester: pytest.Pytester) -> None:
    """It is told beside the cases, which pass: only the start of the program shows it."""
    with socketcand() as bus:
        served = ("serve", "--node-id", str(NODE_ID), "--fault", "first-request-lost", *bus)
        options = (NODE, *bus, started("-m", "conformance", *served), "-k", "abort.frame")
        result = run(pytester, *options, "--sdo-response-timeout=0.5")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*server.first-request*nothing within 500 ms*"])
    result.assert_outcomes(passed=1)


def test_a_program_is_gone_afterwards(pytester: pytest.Pytester) -> None:
    with socketcand() as bus:
        result = run(pytester, NODE, *bus, fragile(pytester, bus), "-k", "abort.frame")
    assert result.ret == pytest.ExitCode.OK
    assert ended(device_log(pytester)) == [True]


def test_a_program_that_ends_at_once(pytester: pytest.Pytester) -> None:
    ends = started("-c", "print('no licence'); raise SystemExit(3)")
    with hosted() as bus:
        result = run(pytester, NODE, *bus, ends, "-k", "abort.")
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(
        ["*= the bench =*", "*exit status 3 before it answered*", "    no licence"]
    )
    assert "passed" not in result.parseoutcomes()


def test_a_program_that_is_not_there(pytester: pytest.Pytester) -> None:
    with hosted() as bus:
        result = run(pytester, NODE, *bus, "--sdo-process=./no-such-server vcan0", "-k", "abort.")
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["The device's program cannot be started: ./no-such-server vcan0*"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--self-test", "--sdo-process=x"), "*not with --self-test*"),
        (("--node-id=5,9", "--sdo-process=x"), "*where the node-ID goes*{node_id}*"),
        (("--node-id=5", "--sdo-process='x"), "*is no command: No closing quotation*"),
    ],
)
def test_wrong_use(pytester: pytest.Pytester, options: tuple[str, ...], said: str) -> None:
    result = run(pytester, *options, "--can-interface=virtual")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([said])


KILLS = """
    import pytest
    from conformance.sdo.layout import Multiplexer

    KEPT, DEADLY = Multiplexer(0x2004), Multiplexer(0x2002)

    @pytest.mark.parametrize("number", range({times}))
    def test_kill(sdo, number):
        assert sdo.upload(KEPT) == bytes.fromhex("11223344"), "it was put back"
        sdo.download(KEPT, b"new!")
        sdo.download(DEADLY, bytes.fromhex("ADDE"))

    def test_last(sdo):
        assert sdo.upload(KEPT) == bytes.fromhex("11223344"), "it was put back"
"""


def test_a_program_that_crashes_is_started_again(pytester: pytest.Pytester) -> None:
    """The case that lost it has failed, and shows what the program said; the others go on."""
    pytester.makepyfile(test_mine=KILLS.format(times=2))
    with socketcand() as bus:
        options = (NODE, *bus, *WRITABLE, fragile(pytester, bus))
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(failed=2, passed=1)
    result.stdout.fnmatch_lines(
        [
            "  afterwards: lost",
            "  note: *the device was lost (test_kill), and has been brought back",
            "  the device's own output, its last lines:",
            "    assertion failed: file server.c, line 42",
        ],
    )
    result.stdout.no_fnmatch_line("not restored:*")
    assert ended(device_log(pytester)) == [True] * 3


def test_what_has_stopped_it_twice_is_not_tried_again(pytester: pytest.Pytester) -> None:
    """The cases that are left out say so; the others are run to the end."""
    pytester.makepyfile(test_mine=KILLS.format(times=5))
    with socketcand() as bus:
        options = (NODE, *bus, *WRITABLE, fragile(pytester, bus))
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(failed=2, skipped=3, passed=1)
    twice = "test_kill has stopped the device twice (in test_kill[0] and test_kill[1])"
    result.stdout.fnmatch_lines(
        [
            f"not testable (3 cases): {twice.replace('[', '[[]')}",
            "test_kill stopped the device: test_kill[[]0], test_kill[[]1]",
        ]
    )
    assert (the_report(pytester) / "junit.xml").read_text(encoding="utf-8").count(twice) >= 3


def test_several_programs(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=KILLS.format(times=1))
    chosen = (
        "-k",
        "abort.frame",
        "-n",
        "2",
        "-p",
        "no:cacheprovider",
        "--sdo-report-dir=left behind",
    )
    with socketcand() as bus:
        options = ("--node-id=5,9", *bus, fragile(pytester, bus, "{node_id}"))
        result = pytester.runpytest_subprocess(*NO_HYPOTHESIS, *options, *chosen)
    assert result.ret == pytest.ExitCode.OK
    assert ended(device_log(pytester, 5) + device_log(pytester, 9)) == [True] * 2


# A device on the bench


class Hangs(Node):
    """Answers no more when DEADh is written, until the power was cycled: a file appears."""

    power: Path
    hangs = False

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        self.hangs |= self.is_addressed(frame) and frame.data == fragile_server.DEADLY
        if self.hangs and self.power.exists():
            self.power.unlink()
            self.hangs = False
            return [*self.start(), *super().receive(frame)]
        return [] if self.hangs else super().receive(frame)


def hanging(pytester: pytest.Pytester) -> Hangs:
    node = Hangs(NODE_ID, build_node(None, NODE_ID).server)
    node.power = pytester.path / "power"
    return node


def test_a_bench_device_is_recovered(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine=KILLS.format(times=2))
    with hosted(hanging(pytester)) as bus:
        options = (NODE, *bus, *WRITABLE, "--sdo-recover=touch power")
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(failed=2, passed=1)
    result.stdout.no_fnmatch_line("not restored:*")


class Wedges(Hangs):
    """Acknowledges whatever it is sent when DEADh was written, until the power was cycled."""

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = super().receive(frame)
        if not self.hangs:
            return answers
        return [self.respond(BlockAck(0, 127).encode())] if self.is_addressed(frame) else []


WEDGES = """
    import pytest
    from conformance.sdo.layout import Multiplexer

    @pytest.mark.parametrize("number", range(5))
    def test_any(sdo, number):
        assert sdo.upload(Multiplexer(0x1000))
        if number == 0:
            sdo.download(Multiplexer(0x2002), bytes.fromhex("ADDE"))
"""


def test_a_device_that_answers_whatever_it_is_asked_alike_is_recovered(
    pytester: pytest.Pytester,
) -> None:
    """The case that has wedged it and the next one fail; then it is brought back."""
    pytester.makepyfile(test_mine=WEDGES)
    node = Wedges(NODE_ID, build_node(None, NODE_ID).server)
    node.power = pytester.path / "power"
    with hosted(node) as bus:
        options = (NODE, *bus, *WRITABLE, "--sdo-recover=touch power")
        result = run(pytester, *options, "test_mine.py")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(failed=2, passed=3)
    result.stdout.fnmatch_lines(["  note: *lost (it answered wrongly whatever it was asked)*"])


def test_a_command_that_recovers_nothing(pytester: pytest.Pytester) -> None:
    """What could not be put back is told, in the report as well, and what was not run."""
    pytester.makepyfile(test_mine=KILLS.format(times=1))
    fails = shlex.join([sys.executable, "-c", "print('no relay'); raise SystemExit(1)"])
    with hosted(hanging(pytester)) as bus:
        result = run(pytester, NODE, *bus, *WRITABLE, f"--sdo-recover={fails}", "test_mine.py")
    assert result.ret == ExitCode.DEVICE_LOST
    result.assert_outcomes(failed=1)
    unrestored = "write 4 bytes: 11 22 33 44 to 2004h:00 of node 5"
    result.stdout.fnmatch_lines(
        [
            f"not restored: {unrestored}",
            "Node 5 answered before, but does not answer any more*",
            "not run: 1 case of node 5: *recovers the device failed*",
        ]
    )
    report = (the_report(pytester) / "junit.xml").read_text(encoding="utf-8")
    assert unrestored in report
    assert "not run: lost in test_kill[0]; The command that recovers the device failed" in report
    assert device_log(pytester).splitlines() == ["no relay"] * 3
