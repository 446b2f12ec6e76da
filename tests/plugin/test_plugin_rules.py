"""``conformance rules``: every rule has a case that tests it, or says why it has none."""

import re
import sys
from pathlib import Path
from subprocess import PIPE, Popen

import pytest

import conformance
from conformance.__main__ import main
from conformance.commands.status import DONE, WRONG_USE
from conformance.eds.rules import RULES as EDS_RULES
from conformance.reporting.official_steps import OFFICIAL_STEPS
from conformance.reporting.rule_listing import cases_of_rules, rule_lines, scripted_cases
from conformance.run.case_files import case_files
from conformance.sdo.rules import RULES, Rule, UnknownRule

TOGGLE = """\
segmented download:
  segmented-download.toggle  MUST  7.2.4.3.4
      The data of a segment whose toggle bit did not alternate is not stored.
      accepted: abort, or silence
      abort codes: 05030000h (toggle bit not alternated)
      open: whether the transfer is aborted or the segment ignored
      tested by: segmented-download.toggle, segmented-download.number-toggle, \
segmented-download.toggle-ignored-data
"""
BOOLEAN = """\
sizes:
  data.boolean  MAY  7.1.4.3
      A BOOLEAN is 00h or 01h; what another value does is left to the device.
      accepted: served, or abort
      abort codes: any
      open: the effect of values above 1
      not tested: Any effect is right, and a value above 1 might set off one in the device.
"""

SUB_COMMAND = """\
idle server:
  specifier.sub-command  MUST  7.2.4.3
      A block initiate whose sub-command bits name none is not served.
      accepted: abort, or silence
      abort codes: 05040001h (command specifier not valid or unknown)
      tolerated: any other
      open: silence: it may pass for an acknowledgement or an end out of place
      tested by: specifier.sub-command
"""
BLOCK_SIZE = """\
upload initiates:
  block-upload.invalid-block-size  MUST  7.2.4.3.13
      A block upload in sub-blocks of no segment, or of more than 127, is refused.
      accepted: abort
      abort codes: 05040002h (invalid block size)
      tolerated: 08000000h (general error), 05040001h (command specifier not valid or unknown)
      tested by: block-upload.invalid-block-size
      official test: SDO 26
"""
SDO_17 = """\
segmented upload:
  segmented-upload.toggle  MUST  7.2.4.3.7
      A toggle bit that did not alternate ends the upload and brings no data.
      accepted: abort, idle
      abort codes: 05030000h (toggle bit not alternated)
      tested by: segmented-upload.toggle-first, segmented-upload.toggle-repeated
      official test: SDO 17
"""


@pytest.fixture(scope="module")
def tested() -> dict[str, list[str]]:
    return cases_of_rules(scripted_cases())


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.id)
def test_a_rule_has_either_a_case_or_a_reason(rule: Rule, tested: dict[str, list[str]]) -> None:
    assert bool(tested[rule.id]) != bool(rule.untestable), "either a case or a reason"


def test_every_case_says_which_rule_it_tests() -> None:
    assert [case.rule.id for case in scripted_cases() if not case.cites] == []


def test_the_cases_are_those_of_all_files() -> None:
    files = {path.stem for path in case_files()}
    assert {case.rule.id.partition(".")[0] for case in scripted_cases()} >= {"abort", "run"}
    assert len(scripted_cases()) > 10 * len(files)


@pytest.mark.parametrize(
    ("names", "due"),
    [
        (["segmented-download.toggle"], TOGGLE),
        (["data.boolean"], BOOLEAN),
        (["data.boolean", "segmented-download.toggle"], TOGGLE + BOOLEAN),
        (["specifier.sub-command"], SUB_COMMAND),
        (["block-upload.invalid-block-size"], BLOCK_SIZE),
        (["sdo 17"], SDO_17),
    ],
    ids=["none-tolerated", "untestable", "both", "any-tolerated", "some-tolerated", "step"],
)
def test_what_it_prints(names: list[str], due: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rules", *names]) == DONE
    assert capsys.readouterr().out == due


def test_of_nearly_all_abort_codes_it_names_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    main(["rules", "response.not-refused"])
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "abort codes" in line]
    assert line.startswith("      abort codes: any but 05030000h (toggle bit not alternated), ")
    assert line.count("h (") == 6


def test_it_prints_all_and_counts_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rules"]) == DONE
    *lines, totals = capsys.readouterr().out.splitlines()
    printed = [line.split()[0] for line in lines if line.startswith("  ") and line[2] != " "]
    assert printed == [*(rule.id for rule in RULES), *(rule.id for rule in EDS_RULES)]
    assert totals.startswith(f"{len(RULES)} rules: ")


def test_every_step_of_the_official_test_is_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rules"]) == DONE
    lines = capsys.readouterr().out.splitlines()
    told = [line.partition("official test: ")[2] for line in lines if "official test: " in line]
    named = {step for line in told for step in line.split(", ")}
    assert named == {step.name for step in OFFICIAL_STEPS}


def test_the_reader_of_a_pipe_may_close_it() -> None:
    """As with ``conformance rules | head -1``: that is no error."""
    command = [sys.executable, "-m", "conformance", "rules"]
    with Popen(command, stdout=PIPE, stderr=PIPE, text=True) as run:  # noqa: S603 - it is our own
        assert run.stdout is not None
        assert run.stderr is not None
        assert run.stdout.readline()
        run.stdout.close()
        assert run.stderr.read() == ""
        assert run.wait() == DONE


def test_an_unknown_rule_is_wrong_use(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rules", "segmented-download.togle"]) == WRONG_USE
    assert "the nearest is 'segmented-download.toggle'" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["SDO 9", "sdo 09"])
def test_a_step_is_named_with_or_without_zeros(name: str) -> None:
    assert list(rule_lines([name])) == list(rule_lines(["SDO 09"]))


def test_a_step_that_no_case_covers() -> None:
    with pytest.raises(UnknownRule, match=r"no case covers a step 'SDO 99'; .*SDO 01, SDO 02"):
        list(rule_lines(["SDO 99"]))


@pytest.mark.parametrize("name", ["od.unlisted", "od.unlisted[1001h]"])
def test_a_case_is_answered_with_its_rules(capsys: pytest.CaptureFixture[str], name: str) -> None:
    """A cause that no other rule names has the id of the case."""
    assert main(["rules", name]) == DONE
    lines = capsys.readouterr().out.splitlines()
    named = [line.split()[0] for line in lines if line.startswith("  ") and line[2] != " "]
    assert named == ["object.missing-refused", "dictionary.unlisted"]


def test_each_rule_that_a_cause_can_name_is_listed() -> None:
    """A breach names a rule of the registry, or that of a case; no other rule is made anywhere."""
    made = re.compile(r"\bRule\(\s*\"([a-z-]+\.[a-z-]+)\"")
    package = Path(conformance.__file__).parent
    listed = {rule.id for rule in RULES}
    found = {
        name
        for path in package.rglob("*.py")
        if "rules" not in path.parts and "cases" not in path.parts
        for name in made.findall(path.read_text(encoding="utf-8"))
    }
    assert {name for name in found - listed if not name.startswith("run.")} == set()
