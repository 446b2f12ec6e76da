"""``conformance decode --judge`` on the bus logs of runs, and on logs that were written by hand."""

from pathlib import Path

import pytest
from plugin_runs import self_test, the_report

from conformance.__main__ import main
from conformance.commands.status import DONE, NOT_ALLOWED
from conformance.logs import judged_channel

pytest_plugins = ["pytester"]
CASES = "block-upload.acknowledged or segmented-upload.toggle or frame or block-download.lost"


def judged(log: Path, capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, str]:
    capsys.readouterr()
    status = main(["decode", "--judge", *options, str(log)])
    return status, capsys.readouterr().out


def written(tmp_path: Path, *lines: str) -> Path:
    """Write a log, each line a time in seconds and a frame."""
    log = tmp_path / "bus.log"
    log.write_text(
        "".join(f"(10{when}) can0 {frame}\n" for when, frame in map(str.split, lines)),
        encoding="utf-8",
    )
    return log


def test_a_clean_run_passes(pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]) -> None:
    self_test(pytester, "-k", CASES)
    status, text = judged(the_report(pytester) / "bus.log", capsys)
    assert status == DONE
    assert text.splitlines()[-1] == "all responses allowed"
    assert "    toggle error" not in text
    assert "    block size of a download: 127" in text.splitlines()


def test_a_faulty_server_does_not(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    self_test(pytester, "--sdo-fault=upload-toggle-ignored", "-k", "segmented-upload.toggle")
    status, text = judged(the_report(pytester) / "bus.log", capsys)
    assert status == NOT_ALLOWED
    assert "segmented-upload.toggle (MUST)" in text
    assert "expected: an abort with 05030000h" in text
    assert text.splitlines()[-1].endswith(" not allowed")


def test_abort_of_a_running_transfer_is_not_blamed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = ("0.000 605#8008100000000408", "0.001 605#4008100000000000",
             "0.002 585#4108100009000000", "0.003 605#6000000000000000")  # fmt: skip
    log = written(tmp_path, *begun, "0.004 585#8008100022000008")
    assert judged(log, capsys)[0] == DONE
    log = written(tmp_path, *begun, "0.004 585#8018100022000008")
    assert judged(log, capsys)[0] == NOT_ALLOWED


def test_segments_that_cross_with_an_abort_may_be_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Twelve are sent; the server aborts at the fourth, and takes the others for requests."""
    begun = ("0.000 605#8008100000000408", "0.001 605#C61020000E000000",
             "0.002 585#A41020007F000000")  # fmt: skip
    segments = [f"0.00{3 + n // 5}{2 * (n % 5)} 605#{n:02X}5A56742B7C3F57" for n in range(1, 12)]
    refusals = [f"0.009{n} 585#8000000001000405" for n in range(8)]
    late = ("0.007 605#8C5550787A4B7639", "0.008 585#8010200012000706",
            "0.0085 605#4000100000000000", *refusals, "0.010 585#4300100091010F00")  # fmt: skip
    log = written(tmp_path, *begun, *segments, *late)
    assert judged(log, capsys)[0] == DONE
    log = written(tmp_path, *begun, *late)
    assert judged(log, capsys)[0] == NOT_ALLOWED


def test_line_and_time_are_those_of_the_response(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(
        tmp_path, "0.000 605#4018100100000000", "0.001 605#8018100100000408",
        "0.002 605#4018100100000000", "0.0045 585#4319100104000000",
    )  # fmt: skip
    status, text = judged(log, capsys)
    assert status == NOT_ALLOWED
    assert text.startswith("line 4, 4.5 ms, can0, node 5: response.multiplexer (MUST)")


def test_an_answer_that_never_comes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    aborted, asked = "605#8018100100000408", "605#4018100100000000"
    log = written(tmp_path, f"0.000 {aborted}", f"0.001 {asked}", f"1.500 {aborted}")
    status, text = judged(log, capsys)
    assert status == NOT_ALLOWED
    assert text.startswith("line 2, 1.0 ms, can0, node 5: response.answered (MUST)")
    # A log that ends behind a request says nothing of its answer.
    log = written(tmp_path, f"0.000 {aborted}", f"0.001 {asked}")
    assert judged(log, capsys)[0] == DONE


def test_a_log_may_begin_in_the_middle_of_a_transfer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path, "0.000 605#6000000000000000", "0.001 585#0054696E79204E6F")
    assert judged(log, capsys)[0] == DONE


def test_a_server_may_give_up_its_own_transfer_at_any_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = (
        "0.000 605#8008100000000408",
        "0.001 605#4008100000000000",
        "0.002 585#4108100009000000",
    )
    timed_out = "585#8008100000000405"
    assert judged(written(tmp_path, *begun, f"1.000 {timed_out}"), capsys)[0] == DONE
    assert judged(written(tmp_path, *begun, f"0.003 {timed_out}"), capsys)[0] == DONE
    of_another = "585#8009100000000405"
    assert judged(written(tmp_path, *begun, f"0.003 {of_another}"), capsys)[0] == NOT_ALLOWED


def test_only_the_node_that_was_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = (
        "0.000 605#8008100000000408",
        "0.001 605#4018100100000000",
        "0.002 585#4319100104000000",
    )
    log = written(tmp_path, *wrong)
    assert judged(log, capsys, "--node-id", "6")[0] == DONE
    assert judged(log, capsys, "--node-id", "5")[0] == NOT_ALLOWED


def test_after_a_reboot_nothing_old_is_expected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(
        tmp_path, "0.000 605#8008100000000408", "0.001 605#4008100000000000",
        "0.200 705#00", "0.900 605#6000000000000000",
    )  # fmt: skip
    assert judged(log, capsys)[0] == DONE


def test_nodes_of_two_buses_are_told_apart(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both are node 5: one is read in segments while the other answers something else."""
    aborted, asked = "605#8008100000000408", "605#4008100000000000"
    log = written(
        tmp_path, f"0.000 {aborted}", f"0.001 {asked}", "0.002 585#4108100009000000",
        "0.004 605#6000000000000000", "0.006 585#0054696E79204E6F",
    )  # fmt: skip
    one = log.read_text(encoding="utf-8")
    other = written(
        tmp_path, f"0.003 {aborted}", f"0.0035 {asked}", "0.005 585#4F08100041000000",
    )  # fmt: skip
    lines = one + other.read_text(encoding="utf-8").replace("can0", "can1")
    log.write_text("".join(sorted(lines.splitlines(keepends=True))), encoding="utf-8")
    status, text = judged(log, capsys)
    assert status == DONE, text
    assert "can0, node 5: 3 requests, 2 responses" in text
    assert "can1, node 5: 2 requests, 1 responses" in text
    main(["decode", str(log)])
    shown = capsys.readouterr().out.splitlines()
    assert [line for line in shown if "can1 585#" in line and line.endswith("1 byte: 41")]
    assert [line for line in shown if "can0 585#0054" in line and "upload segment" in line]


# NMT: in Stopped nothing is answered


READ, ANSWER = "605#4018100100000000", "585#4318100104000000"
STOP, START, STOP_ALL = "000#0205", "000#0105", "000#0200"


@pytest.mark.parametrize(
    "stop", [(STOP,), (STOP_ALL, "0.050 705#04")], ids=["by-command", "by-its-word"]
)
def test_an_answer_in_stopped_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], stop: tuple[str, ...]
) -> None:
    log = written(
        tmp_path, *(f"0.000 {stop[0]}", *stop[1:]), f"0.110 {READ}", f"0.111 {ANSWER}",
        f"0.120 {START}", f"0.130 {READ}", f"0.131 {ANSWER}",
    )  # fmt: skip
    status, text = judged(log, capsys)
    assert status == NOT_ALLOWED
    assert text.startswith(f"line {2 + len(stop)}, 111.0 ms, can0, node 5: nmt.stopped (MUST)")
    assert text.splitlines()[-1] == "1 not allowed"


@pytest.mark.parametrize(
    "lines",
    [
        (f"0.000 {STOP}", f"0.010 {READ}", f"0.300 {READ}"),
        (f"0.000 {STOP}", f"0.010 {START}", f"0.020 {READ}", f"0.021 {ANSWER}"),
        (f"0.000 {READ}", f"0.001 {STOP}", f"0.002 {ANSWER}", f"0.003 {READ}"),
        (f"0.000 {READ}", f"0.001 {STOP}", f"0.002 {READ}", f"0.003 {ANSWER}"),
        ("0.000 000#0206", f"0.010 {READ}", f"0.011 {ANSWER}"),
        (f"0.000 {STOP}", "0.010 705#05", f"0.020 {READ}", f"0.021 {ANSWER}"),
        (f"0.000 {STOP}", "0.010 705#00", f"0.020 {READ}", f"0.021 {ANSWER}"),
    ],
    ids=["silent", "started", "under-way", "crossed", "another-node", "says-it-runs", "booted"],
)
def test_what_a_stopped_node_may_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], lines: tuple[str, ...]
) -> None:
    assert judged(written(tmp_path, *lines), capsys)[0] == DONE


def test_the_log_of_a_server_that_answers_in_stopped(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    self_test(pytester, "--sdo-fault=nmt-stopped-answers", "-k", "nmt.stopped")
    status, text = judged(the_report(pytester) / "bus.log", capsys)
    assert status == NOT_ALLOWED
    assert "nmt.stopped (MUST)" in text


@pytest.mark.parametrize(
    ("name", "case", "rule"),
    [
        ("product-code-written", "communication.read-only", "object.read-only"),
        (
            "identity-has-a-fifth-entry",
            "communication.no-further-entry",
            "object.sub-index-missing",
        ),
        ("error-list-takes-counts", "error-list-count", "communication.error-list-count"),
        ("load-signature-in-capitals", "od.load-signature", "storage.signature"),
        ("vendor-id-changes", "upload.identity", "object.constant"),
    ],
)
def test_the_log_of_a_server_with_a_wrong_object_of_cia_301(
    pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str], name: str, case: str, rule: str
) -> None:
    self_test(pytester, f"--sdo-fault={name}", "-k", case)
    status, text = judged(the_report(pytester) / "bus.log", capsys)
    assert status == NOT_ALLOWED
    assert f"{rule} (MUST)" in text


def test_a_heartbeat_of_a_stopped_node_changes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = written(tmp_path, f"0.000 {STOP}", "0.010 705#04", f"0.020 {READ}", f"0.021 {ANSWER}")
    assert judged(log, capsys)[0] == NOT_ALLOWED


def impatient(requests: int, behind: int) -> list[str]:
    """Return a conversation in which each answer comes ``behind`` requests late."""
    lines, when = [], 0
    for number in range(requests + behind):
        asked, answered = 0x2000 + number % 64, 0x2000 + (number - behind) % 64
        if number < requests:
            lines.append(f"0.{when:06} 605#40{asked & 0xFF:02X}{asked >> 8:02X}0000000000")
        if number >= behind:
            lines.append(
                f"0.{when + 1:06} 585#43{answered & 0xFF:02X}{answered >> 8:02X}0000000000"
            )
        when += 1000
    return lines


@pytest.mark.parametrize("behind", [1, 2, 10])
def test_answers_that_come_requests_late_are_judged(
    behind: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = impatient(100, behind)
    assert judged(written(tmp_path, *lines), capsys)[1].endswith("all responses allowed\n")
    at = next(at for at in range(100, 200) if "585#" in lines[at])
    lines[at] = lines[at].replace("20000000", "30000000")
    status, text = judged(written(tmp_path, *lines), capsys)
    assert status == NOT_ALLOWED
    assert text.startswith(f"line {at + 1}, ")


@pytest.fixture
def _little_effort(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judged_channel, "MOST_EFFORT", 100)
    monkeypatch.setattr(judged_channel, "MOST_EFFORT_OF_ALL", 100)


@pytest.mark.usefixtures("_little_effort")
def test_where_a_client_does_not_wait_too_long_nothing_is_judged_until_it_is_quiet(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked, wrong = "605#4018100100000000", "585#4319100104000000"
    later = (f"0.500 {asked}", f"0.501 {wrong}")
    status, text = judged(written(tmp_path, *impatient(100, 10), *later), capsys)
    lines = text.splitlines()
    assert lines[0].startswith("line ")
    assert ": not judged from here until the channel is quiet for 100 ms: the client" in lines[0]
    assert lines[1].startswith("line 202, 501.0 ms, can0, node 5: response.multiplexer (MUST)")
    assert status == NOT_ALLOWED
    status, text = judged(written(tmp_path, *impatient(100, 10)), capsys)
    assert status == DONE
    assert text.splitlines()[-1].startswith("all responses but the ")


@pytest.mark.usefixtures("_little_effort")
def test_following_a_client_that_does_not_wait_is_bounded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, text = judged(written(tmp_path, *impatient(400, 10)), capsys)
    assert text.count("not judged from here") == 1


def test_a_client_that_asks_twice_at_once_is_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The answers come in the order of the requests; the last one is wrong."""
    two = ("605#4000200000000000", "605#4001200000000000",
           "585#4300200000000000", "585#4301200000000000")  # fmt: skip
    lines = [f"0.{10 * n + at:06} {frame}" for n in range(300) for at, frame in enumerate(two)]
    assert judged(written(tmp_path, *lines), capsys)[1].endswith("all responses allowed\n")
    lines[-1] = lines[-1].replace("43012000", "43022000")
    status, text = judged(written(tmp_path, *lines), capsys)
    assert status == NOT_ALLOWED
    assert text.startswith("line 1200, ")


def test_an_exchange_that_was_right_before_is_judged_again_when_it_differs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    read, write = "605#4000200000000000", "605#2B01200001020000"
    right = (f"0.000 {read}", "0.001 585#4B00200001020000", f"0.002 {write}",
             "0.003 585#6001200000000000", f"0.004 {read}", "0.005 585#4B00200003040000",
             "0.006 605#2B01200003040000", "0.007 585#6001200000000000")  # fmt: skip
    assert judged(written(tmp_path, *right), capsys)[0] == DONE
    for request, answer in (
        (read, "4B00200003040001"),
        (read, "4B01200001020000"),
        (read, "6001200000000000"),
        (write, "6001200000000001"),
        (write, "4B01200001020000"),
    ):
        again = (*right, f"0.008 {request}", f"0.009 585#{answer}")
        text = judged(written(tmp_path, *again), capsys)[1]
        assert text.startswith("line 10, 9.0 ms, can0, node 5: ")
    silent = judged(written(tmp_path, *right, f"0.008 {read}", f"1.500 {read}"), capsys)[1]
    assert silent.startswith("line 9, 8.0 ms, can0, node 5: response.answered (MUST)")
    unasked = judged(written(tmp_path, *right, right[1].replace("0.001", "0.008")), capsys)[1]
    assert unasked.startswith("line 9, 8.0 ms, can0, node 5: response.unsolicited (MUST)")
