"""--sdo-device, --sdo-eds, --sdo-scan: a device that is described, and what is wrong with that."""

from collections import Counter
from pathlib import Path

import pytest
from plugin_runs import NODE_ID, case_ids, hosted, reference, reports, run, self_test, the_report

from conformance.faults.catalogue import build_node
from conformance.reference.built_in_eds import eds_of
from conformance.reporting.official_steps import OFFICIAL_STEPS, table

pytest_plugins = ["pytester"]

DEVICE = """\
node-id = 5
eds = "files/ref.eds"
[objects]
writable = {writable}
never = ["2001"]
[permissions]
read-only-probes = true
"""
FILES = Path(__file__).parents[1] / "eds" / "files"


def described(pytester: pytest.Pytester, writable: str = '"all-rw"', more: str = "") -> str:
    """Write the description of the reference server, and its EDS into a folder beside it."""
    folder = pytester.mkdir("files")
    (folder / "ref.eds").write_text(eds_of(build_node(None, NODE_ID)), encoding="utf-8")
    (pytester.path / "ref.toml").write_text(DEVICE.format(writable=writable) + more, "utf-8")
    return "--sdo-device=ref.toml"


def bus_of(options: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(option for option in options if not option.startswith("--node-id"))


def outcomes(pytester: pytest.Pytester, *arguments: str) -> dict[str, int]:
    """Run cases on the reference server, and return how many had which outcome."""
    with reference() as options:
        result = run(pytester, *bus_of(options), *arguments)
    found = result.parseoutcomes()
    found.pop("deselected", None)
    return found


def test_a_description_suffices(pytester: pytest.Pytester) -> None:
    found = outcomes(pytester, described(pytester), "-k", "od.write-back[2 or download.stored")
    ids = case_ids(the_report(pytester) / "junit.xml")
    assert "od.write-back[2110h:04]" in ids
    # 2001h is never written: neither its own case nor that of a number of 1 byte uses it.
    assert found == {"passed": len(ids) - 1, "skipped": 1}


def test_the_bus_and_the_response_time_are_in_it(pytester: pytest.Pytester) -> None:
    described(pytester, more="[timing]\nresponse = 0.25\n")
    with reference() as options:
        channel = options[-1].partition("=")[2]
        bus = f'[can]\ninterface = "virtual"\nchannel = "{channel}"\n'
        path = pytester.path / "ref.toml"
        path.write_text(path.read_text("utf-8") + bus, "utf-8")
        result = run(pytester, "--sdo-device=ref.toml", "-k", "abort.frame")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(
        [f"*target: node 5 on virtual {channel}", "*response time-out: 250 ms*"]
    )


def test_options_override_it(pytester: pytest.Pytester) -> None:
    description = described(pytester, more='[can]\nchannel = "can7"\nbitrate = 10000\n')
    options = ("--node-id=9", "--can-interface=pcan", "--can-channel=X", "--can-bitrate=250000")
    result = run(pytester, description, *options, "--collect-only", "-k", "abort.frame")
    result.stdout.fnmatch_lines(["*target: node 9 on pcan X, 250000 bit/s"])


def test_without_permission_nothing_is_written(pytester: pytest.Pytester) -> None:
    """An EDS allows nothing by itself; what would be tested is told in one line."""
    eds = pytester.path / "ref.eds"
    eds.write_text(eds_of(build_node(None, NODE_ID)), encoding="utf-8")
    with reference() as options:
        result = run(pytester, *options, f"--sdo-eds={eds}", "-k", "od.write-back or od.read-only")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.fnmatch_lines(
        [
            "not testable (* cases): writing it is not permitted: name what may be written in "
            "device.toml, which 'conformance init' drafts, or with --sdo-object, as *",
            "not testable (* cases): a faulty device would accept the write (of the value "
            "that it has): add --sdo-allow=read-only-probes",
        ]
    )
    log = (the_report(pytester) / "bus.log").read_text(encoding="utf-8")
    written = {line.split("#")[1][2:6] for line in log.splitlines() if " 605#2" in line}
    assert written <= {"0010", "0810", "0910", "0A10", "1810"}, "read-only by the standard"


def test_never_is_stronger_than_the_option(pytester: pytest.Pytester) -> None:
    arguments = (described(pytester, '["2002"]'), "--sdo-object=2001=unsigned8")
    found = outcomes(pytester, *arguments, "-k", "od.write-back[2001h or od.write-back[2002h")
    assert found == {"passed": 1, "skipped": 1}


WRONG = {
    "--sdo-device=none.toml": "none.toml: the file cannot be read: No such file or directory.",
    "--sdo-eds=none.eds --node-id=5": "none.eds: the file cannot be read: No such file or dir",
    "--sdo-eds=drive.txt --node-id=5": "has to end in .eds, .dcf, .xdd or .xdc.",
    "--sdo-eds=typo.eds --node-id=5": "typo.eds: there is no section of an object, as [1000],",
    "--sdo-device=typo.toml": "typo.toml, line 2: there is no key 'nodeid'. Did you mean 'node",
    "--sdo-device=denied.toml": (
        "1017h:00 was named, but a permission is needed to write the heartbeat time: "
        "--sdo-allow=nmt, or [permissions] nmt = true in device.toml."
    ),
    "--sdo-device=nameless.toml": "does not give the node-ID: add --node-id=N",
    "--sdo-eds=drive.eds": "--sdo-eds=drive.eds does not give the node-ID: add --node-id=N",
    "--sdo-device=denied.toml --self-test": "describes a device: leave out --self-test.",
}


@pytest.mark.parametrize(("options", "sentence"), WRONG.items(), ids=WRONG)
def test_a_wrong_description(pytester: pytest.Pytester, options: str, sentence: str) -> None:
    for name, text in (
        ("typo.toml", "# a device\nnodeid = 5\n"),
        ("nameless.toml", ""),
        ("denied.toml", 'node-id = 5\n[objects]\nwritable = ["1017"]\n'),
        ("typo.eds", "[DeviceInfo]\nAccesType=ro\nDataType=7\n[MandatoryObjects]\n"),
    ):
        (pytester.path / name).write_text(text, encoding="utf-8")
    result = run(pytester, *options.split(), "--collect-only")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    printed = result.stdout.str() + result.stderr.str()
    assert printed.count(sentence) == 1
    assert "Traceback" not in printed
    assert not reports(pytester).exists()


def test_ids_are_known_before_the_bus_is_opened(pytester: pytest.Pytester) -> None:
    eds = f"--sdo-eds={FILES / 'io_module.eds'}"
    result = run(pytester, "--node-id=5", eds, "--collect-only", "-q", "-k", "od.")
    ids = {line.partition("::")[2] for line in result.outlines}
    assert {
        "od.read[6401h:04]",
        "od.length[6401h:04]",
        "od.within-limits[6426h:01]",
        "od.default[1200h:01]",
        "od.identity[vendor-id]",
        "od.error-list[1003h:04]",
        "od.block-read[1008h:00]",
        "od.write-back[6200h:01]",
        "od.write-back-in-segments[1017h:00]",
        "od.write-back-in-blocks[6206h:01]",
        "od.too-short[6426h:04]",
        "od.too-long[6426h:04]",
        "od.above-limit[2000h:00]",
        "od.low-limit[2000h:00]",
        "od.read-only[1018h:04]",
        "od.highest-sub-index[1018h]",
        "od.sub-index-beyond[1000h]",
        "od.gap[1800h:03]",
        "od.structure[1003h]",
        "od.unlisted[1002h]",
    } <= ids
    assert "od.below-limit[6426h:01]" not in ids, "there is nothing below 0"
    assert "od.write-back[1003h:00]" not in ids


@pytest.mark.parametrize("name", ["io_module.eds", "drive.eds", "encoder.dcf"])
def test_each_device_has_its_own_cases(pytester: pytest.Pytester, name: str) -> None:
    eds = f"--sdo-eds={FILES / name}"
    result = run(pytester, "--node-id=5,9", eds, "--collect-only", "-q", "-k", "od.read[")
    ids = [line for line in result.outlines if "::od.read[" in line]
    assert len(ids) == len(set(ids))
    assert len([line for line in ids if line.endswith("@9")]) * 2 == len(ids)


def test_a_dcf_is_compared_with_the_configuration(pytester: pytest.Pytester) -> None:
    """It stands for a value that was not written to this device: a SHOULD."""
    text = (
        eds_of(build_node(None, NODE_ID)) + "\n[2150]\nParameterName=x\nDataType=7\nAccessType=rw\n"
    )
    dcf = pytester.path / "ref.dcf"
    dcf.write_text(text.replace("[2001]", "[2001]\nParameterValue=0x12"), encoding="utf-8")
    assert outcomes(
        pytester, "--node-id=5", f"--sdo-eds={dcf}", "-k", "od.configured or od.read[2150h:00]"
    ) == {"non": 1, "failed": 1}  # pytester reads "non-strict" so


def test_a_failure_names_the_object_as_the_eds_does(pytester: pytest.Pytester) -> None:
    case = "od.within-limits[2100h:01]"
    result = self_test(pytester, "--sdo-fault=value-outside-its-limits", "-k", case)
    result.stdout.fnmatch_lines(["*expected: 2100h:01 (Entry 2100h:01) between 10 and 100"])


def test_what_is_known_of_a_device_without_an_eds(pytester: pytest.Pytester) -> None:
    """The objects of every device and those that were named; nothing is said of what is missing."""
    with hosted(build_node(None, NODE_ID)) as bus:
        result = run(pytester, "--node-id=5", *bus, "--sdo-object=2004=unsigned32", "-k", "od.")
    assert result.ret == pytest.ExitCode.OK
    ids = set(case_ids(the_report(pytester) / "junit.xml"))
    assert {"od.read[1000h:00]", "od.read[1001h:00]", "od.block-read[1018h:01]"} <= ids
    assert {"od.write-back[2004h:00]", "od.too-short[2004h:00]"} <= ids
    assert not any(case.startswith(("od.unlisted", "od.gap", "od.structure")) for case in ids)


def test_scan(pytester: pytest.Pytester) -> None:
    part = ("--sdo-scan", "-k", "od.scan[2000h")
    result = self_test(pytester, *part, "--sdo-fault=more-objects-than-the-eds-lists")
    result.stdout.fnmatch_lines(
        ["info: od.scan[[]2000h-2FFFh]: not listed, and there: 2005h, 2009h, *, 2132h, 2141h"]
    )
    lacking = self_test(pytester, *part, "--sdo-fault=listed-objects-missing")
    assert lacking.ret == pytest.ExitCode.TESTS_FAILED
    lacking.stdout.fnmatch_lines(["*actual: none at 2001h, 2002h, *, 2140h"])
    self_test(pytester, *part).assert_outcomes(
        passed=1, deselected=lacking.parseoutcomes()["deselected"]
    )


def test_nothing_is_scanned_unasked(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "-k", "od.scan")
    assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_each_step_of_the_official_tool_has_its_cases(pytester: pytest.Pytester) -> None:
    listed = self_test(pytester, "--collect-only", "-q").outlines
    ids = [line.partition("::")[2] for line in listed if line.startswith("cases/")]
    for step in OFFICIAL_STEPS:
        assert step.stems
        for stem in step.stems:
            assert any(case.startswith(stem) for case in ids), f"{step.name}: {stem}"
    counts = Counter(step.name.partition(" ")[0] for step in OFFICIAL_STEPS)
    assert (counts["SDO"], counts["OD"]) == (30, 9)
    assert [step.name for step in OFFICIAL_STEPS] == [
        f"{group} {number:02}" for group in counts for number in range(1, counts[group] + 1)
    ]


def test_the_table_for_users_is_up_to_date() -> None:
    path = Path(__file__).parents[2] / "docs" / "official-test.md"
    assert path.read_text(encoding="utf-8").endswith(f"\n\n{table()}\n")
