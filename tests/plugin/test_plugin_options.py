"""A wrong option ends a run before it begins, with one sentence; the header says what was read."""

import re

import pytest
from plugin_runs import QUICK, hosted, reports, run, self_test

from conformance import __version__
from conformance.faults.catalogue import build_node

pytest_plugins = ["pytester"]

RANGE = "node-IDs go from 1 to 127"
NO_NODE = "is no node-ID: write a number or a range, as in 1-4,9"
NO_TIME = "is no time: write seconds, as in 0.5"
NO_OBJECT = "does not name an object: write INDEX[:SUB][=TYPE[,ACCESS]] in hexadecimal"

WRONG = {
    "--node-id=0": f"'0': {RANGE}",
    "--node-id=128": f"'128': {RANGE}",
    "--node-id=-1": f"'-1' {NO_NODE}",
    "--sdo-device=a.toml --sdo-device b.toml": "--sdo-device is given 2 times, and a run takes one",
    "--node-id=4-1": "'4-1' counts down: write the lower node-ID first",
    "--node-id=1-128": f"'1-128': {RANGE}",
    "--node-id=x": f"'x' {NO_NODE}",
    "--node-id=1,,2": f"'' {NO_NODE}",
    "--node-id=1-": f"'1-' {NO_NODE}",
    "--node-id=5.0": f"'5.0' {NO_NODE}",
    "--sdo-response-timeout=0": f"'0' {NO_TIME}",
    "--sdo-response-timeout=-1": f"'-1' {NO_TIME}",
    "--sdo-response-timeout=nan": f"'nan' {NO_TIME}",
    "--sdo-response-timeout=inf": f"'inf' {NO_TIME}",
    "--sdo-response-timeout=500ms": f"'500ms' {NO_TIME}",
    "--sdo-server-timeout=0": f"'0' {NO_TIME}",
    "--sdo-object=2001=unsinged16": "called 'unsinged16'. Did you mean 'unsigned16'?",
    "--sdo-object=2001=int": "Write integer8, integer16, integer32 or integer64.",
    "--sdo-object=2001=unsigned8,rx": "called 'rx'. Known: rw, ro, wo, const.",
    "--sdo-object=20010": f"'20010' {NO_OBJECT}",
    "--sdo-object=": f"'' {NO_OBJECT}",
    "--sdo-allow=nmtt": "There is no permission called 'nmtt'. Did you mean 'nmt'?",
    "--sdo-allow=sdo-parameter": "Did you mean 'sdo-parameters'?",
    "--sdo-allow=heartbeat": "Did you mean 'heartbeat-parameters'?",
    "--sdo-object=1201:01=unsigned32": "to write the SDO channels: --sdo-allow=sdo-parameters",
    "--sdo-object=1010:01=unsigned32": "write the parameter storage: --sdo-allow=store-parameters",
    "--sdo-channel=640": "'640' is no SDO channel: write REQUEST:RESPONSE in hexadecimal",
    "--sdo-channel=800:5C0": "'800' is no CAN-ID: it has more than 11 bits",
    "--sdo-channel=plc.dcf": "'plc.dcf' does not say which record of the file",
    "--sdo-channel=plc.dcf:1200": "'1200' is no SDO client parameter record: write 1280 to 12FF",
    "--sdo-channel=plc.dcf:1280": "plc.dcf: the file cannot be read: No such file or directory.",
    "--self-test --sdo-channel=640:5C0": "--sdo-channel goes with one device: --node-id=N.",
    "--can-option=port": "'port' is no setting: write NAME=VALUE, as in port=29536",
    "--can-option==29536": "'=29536' is no setting",
    "--sdo-answer-delay=fast --self-test": f"'fast' {NO_TIME}",
    "--sdo-answer-delay=0.1": "--sdo-answer-delay goes with --self-test.",
    "--sdo-process=": "an empty text is no command",
    "--sdo-seed=x": "'x' is no number: write 1, 2 or the like",
    "--sdo-examples=x": "'x' is no number of examples",
    "--sdo-examples=-1": "'-1' is no number of examples",
    "--sdo-sed=3": "There is no option --sdo-sed. Did you mean --sdo-seed?",
    "--sdo-objects 2001": "There is no option --sdo-objects. Did you mean --sdo-object?",
    "--sdo-xxxxxx": "There is no option --sdo-xxxxxx. pytest --help lists them.",
    "--can-bitrate=fast": "'fast' is no bit rate: write bit/s, as in 500000, 500k or 1M",
    "--can-bitrate=500": "'500' is 500 bit/s, too slow for CAN: 500k are kbit/s",
    "--can-interface=socketcam": "called 'socketcam'. Did you mean 'socketcan'?",
    "--can-interface=vcan0": "a channel of socketcan: write --can-channel=vcan0.",
    "--can-chanel=can0": "There is no option --can-chanel. Did you mean --can-channel?",
    "--nodeid=5": "There is no option --nodeid. Did you mean --node-id?",
    "--node_id 5": "There is no option --node_id. Did you mean --node-id?",
    "--eds drive.eds": "There is no option --eds. Did you mean --sdo-eds?",
    "--channel=can0": "There is no option --channel. Did you mean --can-channel or --sdo-channel?",
    "--frobnicate": "unrecognized arguments: --frobnicate",
    "--sdo-fault=answers-late": "--sdo-fault=answers-late goes with --self-test.",
    "--sdo-simulated": "--sdo-simulated goes with --self-test",
    "--self-test --sdo-simulated --sdo-server-timeout=1": "--sdo-server-timeout needs a clock",
    "--self-test --sdo-quick --sdo-thorough": "--sdo-quick runs few cases and --sdo-thorough more",
    "--self-test --sdo-quik": "There is no option --sdo-quik. Did you mean --sdo-quick?",
    "--self-test --sdo-budged=5": "There is no option --sdo-budged. Did you mean --sdo-budget?",
    "--self-test --sdo-budget=soon": "'soon' is no time: write 5min, 2min30s, 1h or seconds",
    "--self-test --sdo-fault=answer-late": "called 'answer-late'. Did you mean 'answers-late'?",
    "--self-test --sdo-fault=qqqq": "There is no faulty or unusual server called 'qqqq'.",
    "--self-test --sdo-fault=": "There is no faulty or unusual server called ''.",
    "--self-test --sdo-fault=answer-late --collect-only": "Did you mean 'answers-late'?",
}


@pytest.mark.parametrize(("options", "sentence"), WRONG.items(), ids=WRONG)
def test_a_wrong_option(pytester: pytest.Pytester, options: str, sentence: str) -> None:
    given = options.split()
    device = [] if "--self-test" in options or "--sdo-fault" in options else ["--node-id=5"]
    result = run(pytester, *device, *given)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    printed = result.stdout.str() + result.stderr.str()
    assert printed.count(sentence) == 1
    assert "Traceback" not in printed
    assert "passed" not in printed
    assert not reports(pytester).exists()


def header(result: pytest.RunResult) -> list[str]:
    prefix = "conformance: "
    return [line.removeprefix(prefix) for line in result.outlines if line.startswith(prefix)]


def test_header_of_the_self_test(pytester: pytest.Pytester) -> None:
    target, how, objects = header(self_test(pytester, "-k", "abort.frame"))
    start = f"{__version__}, target: built-in reference server, node 5 on virtual conformance-"
    assert target.startswith(start)
    assert how == (
        "bit rate: as the interface is set, response time-out: 1000 ms, seed: 1, strict: no"
    )
    assert re.fullmatch(r"objects: \d+ entries in the EDS, \d+ of them may be written", objects)


def test_header_of_a_fault(pytester: pytest.Pytester) -> None:
    target, *_ = header(self_test(pytester, "--sdo-fault=answers-late", "--collect-only"))
    assert target.startswith(f"{__version__}, target: built-in answers-late, node 5 on virtual ")


def test_header_of_a_device(pytester: pytest.Pytester) -> None:
    options = (
        "--node-id=1-3,9",
        "--can-interface=pcan",
        "--can-channel=PCAN_USBBUS1",
        "--can-bitrate=250000",
        "--sdo-response-timeout=0.25",
        "--sdo-seed=7",
        "--strict",
    )
    target, how, objects = header(run(pytester, *options, "--collect-only"))
    assert target == f"{__version__}, target: node 1, 2, 3, 9 on pcan PCAN_USBBUS1, 250000 bit/s"
    assert how == "bit rate: 250000 bit/s, response time-out: 250 ms, seed: 7, strict: yes"
    assert (
        objects
        == "objects: 0 named, no EDS (--sdo-eds=FILE adds cases for each object of the device)"
    )


def test_help_shows_the_options(pytester: pytest.Pytester) -> None:
    result = run(pytester, "--help")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["CANopen SDO conformance:", "*--node-id*N*", "*--self-test*"])


def test_the_report_folder_is_reports_by_default(pytester: pytest.Pytester) -> None:
    pytester.runpytest_inprocess(*QUICK, "--self-test", "-k", "abort.frame")
    (folder,) = (pytester.path / "reports").iterdir()
    assert folder.name.endswith("-node-5")
    assert {path.name for path in folder.iterdir()} >= {"bus.log", "junit.xml"}


def test_the_seed_decides_on_the_bytes_that_are_written(pytester: pytest.Pytester) -> None:
    texts = []
    for seed in ("1", "1", "2"):
        self_test(pytester, f"--sdo-seed={seed}", "-k", "download.text and 4")
        newest = max(reports(pytester).iterdir())
        lines = (newest / "bus.log").read_text(encoding="utf-8").splitlines()
        texts.append([line.split()[2] for line in lines if " 605#23112000" in line])
    assert texts[0]
    assert texts[0] == texts[1]
    assert texts[0] != texts[2]


def test_the_response_timeout_is_what_a_silent_answer_costs(pytester: pytest.Pytester) -> None:
    fault = ("--sdo-fault=unknown-specifier-ignored", "-k", "specifier.unknown and E0h")
    result = self_test(pytester, *fault, "--sdo-response-timeout=0.07")
    result.stdout.fnmatch_lines(["*actual: nothing within 70 ms"])


def test_a_node_id_may_be_hexadecimal(pytester: pytest.Pytester) -> None:
    with hosted(build_node(None, 0x7F)) as bus:
        result = run(pytester, "--node-id=0x7F", *bus, "-k", "abort.frame")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(["conformance: *target: node 127 on virtual *"])


def test_time_outs_are_waited_for_only_where_declared(pytester: pytest.Pytester) -> None:
    undeclared = self_test(pytester, "-k", "server-timeout.once")
    undeclared.assert_outcomes(skipped=3, deselected=undeclared.parseoutcomes()["deselected"])
    undeclared.stdout.fnmatch_lines(["*declare it with --sdo-server-timeout=SECONDS*"])


def test_the_built_in_server_keeps_a_declared_time_out(pytester: pytest.Pytester) -> None:
    declared = ["--sdo-server-timeout=0.3", "-k", "server-timeout.once and segmented"]
    assert self_test(pytester, *declared).parseoutcomes()["passed"] == 1
    left_out = self_test(pytester, *declared, "-m", "not slow")
    assert left_out.ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_frames_are_logged_for_those_who_want_them(pytester: pytest.Pytester) -> None:
    live = ("-o", "log_cli=true", "-o", "log_cli_level=DEBUG")
    result = self_test(pytester, "-k", "upload.device-type", *live)
    result.stdout.fnmatch_lines(
        [
            "*DEBUG *conformance.frames:* > 605#4000100000000000 upload initiate 1000h:00",
            "*DEBUG *conformance.frames:* < 585#4300100091010F00 upload initiate response 1000h*",
        ]
    )
    assert "conformance.frames" not in self_test(pytester, "-k", "upload.device-type").stdout.str()


def test_a_failure_has_the_frames_that_pytest_was_told_to_log(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(test_mine="def test_mine(sdo):\n    sdo.fence()\n    assert False")
    result = self_test(pytester, "test_mine.py", "--log-level=DEBUG")
    result.stdout.fnmatch_lines(["*- Captured log call -*", "DEBUG *> 605#4000100000000000 *"])
