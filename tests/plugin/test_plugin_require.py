"""--sdo-require: a run that has not tested what it had to is not green, and says what to add."""

import pytest
from plugin_runs import hosted, parsed, reference, run, self_test, the_report

from conformance.faults.catalogue import build_node
from conformance.plugin.exit_code import ExitCode

pytest_plugins = ["pytester"]

TOO_SHORT = ("-k", "download.too-short or download.too-long or upload.device-type")


def sentences(result: pytest.RunResult) -> list[str]:
    beginning = "required, but not tested: --sdo-require="
    return [line.removeprefix(beginning) for line in result.outlines if line.startswith(beginning)]


def test_a_step_that_was_not_tested_fails_the_run(pytester: pytest.Pytester) -> None:
    with reference() as device:
        result = run(pytester, *device, *TOO_SHORT, "--sdo-require=sdo 09")
    assert result.ret == ExitCode.NOT_TESTED
    (sentence,) = sentences(result)
    assert sentence.startswith("'sdo 09': SDO 09: none of ")
    assert "--sdo-object=" in sentence
    properties = {
        each.attrib["name"]: each.attrib["value"]
        for each in parsed(the_report(pytester) / "junit.xml").iter("property")
    }
    assert properties["required-but-not-tested"].endswith(sentence)


def test_with_what_was_missing_the_run_is_green(pytester: pytest.Pytester) -> None:
    with reference() as device:
        named = ("--sdo-object=2001=unsigned8", "--sdo-object=2004=unsigned32")
        wanted = ("--sdo-require=SDO 09", "--sdo-require=download.too-long", "--sdo-require=50%")
        result = run(pytester, *device, *TOO_SHORT, *named, *wanted)
    assert result.ret == pytest.ExitCode.OK
    assert not sentences(result)


@pytest.mark.parametrize(("share", "status"), [("50%", 0), ("51%", ExitCode.NOT_TESTED)])
def test_a_share_of_the_cases_that_were_selected(
    pytester: pytest.Pytester, share: str, status: int
) -> None:
    with reference() as device:
        chosen = ("upload.device-type", "download.same-value")
        result = run(pytester, *device, *chosen, f"--sdo-require={share}")
    assert result.ret == status
    expected = ["'51%': 1 of 2 cases (50 %) were tested: needs a"] if status else []
    assert [each[: len(expected[0])] for each in sentences(result)] == expected


def test_each_service_with_the_words_is_required(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "abort.frame", "block-upload.size", "--sdo-require=block upload")
    assert result.ret == ExitCode.NOT_TESTED
    assert sentences(result) == [
        "'block upload': block upload choices: the run had no case on it",
        "'block upload': block upload errors: the run had no case on it",
    ]


def test_a_service_that_is_refused_was_not_tested(pytester: pytest.Pytester) -> None:
    without = ("--sdo-fault=no-block-transfer", "block-upload.size")
    result = self_test(pytester, *without, "--sdo-require=SDO 23", "--sdo-require=100%")
    assert result.ret == ExitCode.NOT_TESTED
    (sentence,) = sentences(result)
    beginning = "'SDO 23': SDO 23: none of 24 cases was tested: the device refuses it: abort "
    assert sentence.startswith(beginning)


def test_a_failure_is_a_failure_first(pytester: pytest.Pytester) -> None:
    fault = "--sdo-fault=abort-big-endian"
    result = self_test(pytester, fault, "abort.frame", "--sdo-require=random")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert sentences(result) == ["'random': random: the run had no case on it"]
    assert self_test(pytester, fault, "abort.frame", "--sdo-require=abort").ret == 1


def test_each_device_has_to_show_it(pytester: pytest.Pytester) -> None:
    with hosted(build_node(None, 5), build_node(None, 9)) as bus:
        wanted = ("--sdo-require=download", "-k", "download.same-value")
        result = run(pytester, "--node-id=5,9", *bus, *wanted)
    assert result.ret == ExitCode.NOT_TESTED
    assert "required, but not tested: node 9: --sdo-require='download'" in result.stdout.str()


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ("blocks", "Did you mean 'block'?"),
        ("segmnted", "Did you mean 'segmented'?"),
        ("101%", "'101%' is no share: write 0% to 100%"),
        ("many%", "'many%' is no share"),
        ("", "'' is no share such as 90%, no service such as block, no rule"),
        ("SDO 019", "Did you mean 'SDO 19'?"),
    ],
)
def test_what_cannot_be_required_is_told(
    pytester: pytest.Pytester, wrong: str, sentence: str
) -> None:
    result = self_test(pytester, f"--sdo-require={wrong}")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert sentence in result.stderr.str()
