"""What a killed run has left changed: whole in its report folder, told by the next, put back."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from plugin_runs import NODE_ID, QUICK, hosted_on, reports, run
from socketcand_bus import socketcand

from conformance.__main__ import main
from conformance.commands.status import DONE, NOT_THERE
from conformance.plugin.exit_code import ExitCode
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.reporting.journal import journals, read_journal
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import DownloadInitiate, Response
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import ObjectDictionary, Refusal

pytest_plugins = ["pytester"]

TEXT, NUMBER = Multiplexer(0x2010), Multiplexer(0x2004)
LONG = bytes(range(0x20, 0x7F)) * 3
NAMED = (
    "--sdo-object=2004=unsigned32",
    "--sdo-object=2010=visible_string",
    "--sdo-response-timeout=30",
)
KILLED = """
    import os
    import signal
    from conformance.sdo.layout import Multiplexer

    def test_written(sdo):
        sdo.download(Multiplexer(0x2004), b"new!")
        sdo.download(Multiplexer(0x2010), b"new")
        os.kill(os.getpid(), signal.SIGKILL)
"""
PASSES = """
    def test_nothing(sdo):
        sdo.fence()
"""


@contextmanager
def killed(pytester: pytest.Pytester) -> Iterator[tuple[ObjectDictionary, tuple[str, ...]]]:
    """Run on a device until the run is killed; yields the device and the options of its bus."""
    objects = reference_device(NODE_ID)
    objects.find(TEXT).value = LONG
    with socketcand() as bus, hosted_on(bus, Node(NODE_ID, Server(objects))):
        pytester.makepyfile(test_mine=KILLED)
        folder = f"--sdo-report-dir={reports(pytester)}"
        options = (*QUICK, folder, f"--node-id={NODE_ID}", *bus, *NAMED, "test_mine.py")
        assert pytester.runpytest_subprocess(*options).ret == -signal.SIGKILL
        assert objects.find(TEXT).value == b"new"
        pytester.makepyfile(test_mine=PASSES)
        yield objects, bus


def left(pytester: pytest.Pytester) -> list[Path]:
    return [path for folder in reports(pytester).iterdir() for path in journals(folder)]


@pytest.mark.parametrize("quiet", [(), ("-q",), ("-qq",)])
def test_the_next_run_says_so(pytester: pytest.Pytester, quiet: tuple[str, ...]) -> None:
    with killed(pytester) as (objects, bus):
        (journal,) = left(pytester)
        assert read_journal(journal)[1][0].values[TEXT] == LONG
        result = run(pytester, f"--node-id={NODE_ID}", *bus, *NAMED, "test_mine.py", *quiet)
        assert result.ret == 0
        result.stdout.fnmatch_lines(
            [
                "conformance: an earlier run left changed values on node 5 (2004h:00, 2010h:*"
                "--sdo-restore*"
            ]
        )
        assert objects.find(TEXT).value == b"new"
        assert left(pytester) == [journal]


def test_the_next_run_puts_it_back_first(pytester: pytest.Pytester) -> None:
    with killed(pytester) as (objects, bus):
        number = read_journal(left(pytester)[0])[1][0].values[NUMBER]
        result = run(
            pytester, f"--node-id={NODE_ID}", *bus, *NAMED, "--sdo-restore", "test_mine.py"
        )
        assert result.ret == 0
        result.stdout.fnmatch_lines(["put back: 2004h:00, 2010h:00 of node 5*"])
        assert (objects.find(TEXT).value, objects.find(NUMBER).value) == (LONG, number)
        assert left(pytester) == []


def test_a_command_puts_it_back(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    """On the bus of the run, which the journal names."""
    with killed(pytester) as (objects, _):
        (journal,) = left(pytester)
        assert main(["restore", str(journal.parent), "--response-timeout=30"]) == DONE
        assert "put back: 2004h:00, 2010h:00 of node 5" in capsys.readouterr().out
        assert objects.find(TEXT).value == LONG
        assert left(pytester) == []
        assert main(["restore", str(journal.parent)]) == DONE
        assert "has no values to restore" in capsys.readouterr().out


def test_another_device_is_not_written_to(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    with killed(pytester) as (objects, _):
        (journal,) = left(pytester)
        objects.find(Multiplexer(0x1018, 4)).value = bytes(4)
        assert main(["restore", str(journal.parent), "--response-timeout=30"]) == NOT_THERE
        assert "is not the device" in capsys.readouterr().err
        assert objects.find(TEXT).value == b"new"
        assert left(pytester) == [journal]


def test_nor_is_one_that_does_not_say_which_it_is(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    with killed(pytester) as (objects, bus):
        (journal,) = left(pytester)
        objects.remove(0x1018)
        assert main(["restore", str(journal), "--response-timeout=30"]) == NOT_THERE
        assert "1018h:01 cannot be read now" in capsys.readouterr().err
        result = run(
            pytester, f"--node-id={NODE_ID}", *bus, *NAMED, "--sdo-restore", "test_mine.py"
        )
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stdout.fnmatch_lines(["*Nothing was written to it*"])
        assert objects.find(TEXT).value == b"new"
        assert left(pytester) == [journal]


def test_a_folder_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["restore", "reports/TYPO"]) == NOT_THERE
    assert capsys.readouterr().err == "conformance: reports/TYPO does not exist\n"


REFUSES = """
    from conformance.sdo.layout import Multiplexer

    def test_written(sdo):
        sdo.download(Multiplexer(0x2004), b"new!")
        open("refuse", "w").close()
"""


class Refusing(Server):
    """Takes nothing more when a file is there."""

    def on_download_initiate(self, request: DownloadInitiate) -> list[Response]:
        if Path("refuse").exists():
            raise Refusal(AbortCode.LOCAL_CONTROL)
        return super().on_download_initiate(request)


def test_a_run_that_leaves_a_value_does_not_exit_0(pytester: pytest.Pytester) -> None:
    """What it names is whole in its journal, which stays."""
    pytester.makepyfile(test_mine=REFUSES)
    with socketcand() as bus, hosted_on(bus, Node(NODE_ID, Refusing(reference_device(NODE_ID)))):
        result = run(pytester, f"--node-id={NODE_ID}", *bus, *NAMED, "test_mine.py")
    result.assert_outcomes(passed=1)
    assert result.ret == ExitCode.BENCH_ERROR
    result.stdout.fnmatch_lines(["not restored: write 4 bytes: * to 2004h:00 of node 5"])
    result.stdout.fnmatch_lines(["*'conformance restore *' writes them back"])
    assert len(left(pytester)) == 1


@pytest.mark.parametrize(
    "case",
    [
        "od.load-signature and not part",
        "od.save-signature and not part",
        "channel.client-stored",
    ],
)
def test_nothing_is_left_by_a_case_about_what_is_stored(
    pytester: pytest.Pytester, case: str
) -> None:
    result = run(pytester, "--self-test", "-k", case)
    result.assert_outcomes(passed=1, deselected=result.parseoutcomes()["deselected"])
    assert left(pytester) == []
