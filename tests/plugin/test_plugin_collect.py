"""--collect-only: the list of cases, for reading and for pasting, without a bus and a report."""

import pytest
from plugin_runs import reports, run, self_test

pytest_plugins = ["pytester"]

ABOUT = "rules abort.not-answered response.unsolicited"
LISTED = f"""\
<CaseModule test_abort.py>
  <Case abort.not-answered[general-error]  MUST  clause 7.2.4.3.17  {ABOUT}>
  <Case abort.not-answered[timed-out]  MUST  clause 7.2.4.3.17  {ABOUT}>
  <Case abort.not-answered[missing-object]  MUST  clause 7.2.4.3.17  {ABOUT}>
  <Case abort.not-answered[code-0]  MUST  clause 7.2.4.3.17  {ABOUT}>
  <Case abort.not-answered[unknown-code]  MUST  clause 7.2.4.3.17  {ABOUT}>
  <Case abort.not-answered[all-zero]  MUST  clause 7.2.4.3.17  {ABOUT}>
  <Case abort.frame  MUST  clause 7.2.4.3.17  rules abort.code response.reserved>
<CaseModule test_whole_run.py>
  <Case run.constants  MUST  clause 7.4.5  rules object.constant>
  <Case run.reserved  MUST  clause 7.2.4.3  rules response.reserved>
  <Case run.filler  SHOULD  clause 7.2.4.3  rules response.filler>
  <Case run.no-late-response  MUST  clause 7.2.4.2  rules response.unsolicited>
  <Case run.outside-the-cases  MUST  clause 7.2.4.2  rules response.unsolicited>
"""
IDS = """\
cases/test_abort.py::abort.not-answered[general-error]
cases/test_abort.py::abort.not-answered[timed-out]
cases/test_abort.py::abort.not-answered[missing-object]
cases/test_abort.py::abort.not-answered[code-0]
cases/test_abort.py::abort.not-answered[unknown-code]
cases/test_abort.py::abort.not-answered[all-zero]
cases/test_abort.py::abort.frame
cases/test_whole_run.py::run.constants
cases/test_whole_run.py::run.reserved
cases/test_whole_run.py::run.filler
cases/test_whole_run.py::run.no-late-response
cases/test_whole_run.py::run.outside-the-cases
"""
SOME = ("-k", "abort.not-answered or abort.frame or test_whole_run")


def no_bus(*arguments: object, **options: object) -> None:
    raise AssertionError("a bus was opened")


@pytest.fixture(autouse=True)
def forbid_buses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("can.Bus", no_bus)


def dedented(text: str) -> str:
    """Take away the indentation, which depends on the folder where the suite lies."""
    lines = text.splitlines()
    margin = min(len(line) - len(line.lstrip()) for line in lines)
    return "\n".join(line[margin:] for line in lines)


RISKY = ("-k", "frame.one-answer or frame.remote or frame.short-abort or frame.mirror")


def test_a_list_keeps_the_cases_of_a_file_together(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--collect-only", "-q", *RISKY)
    ids = [line.partition("::")[2] for line in result.outlines if "::" in line]
    assert ids[0] == "frame.one-answer"
    assert ids[-2:] == ["frame.short-abort", "frame.mirror"]


def test_the_list(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--collect-only", *SOME)
    assert result.ret == pytest.ExitCode.OK
    lines = [line for line in result.outlines if "<Case" in line]
    assert dedented("\n".join(lines)) == dedented(LISTED)
    assert not reports(pytester).exists()


def test_the_ids(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--collect-only", "-q", *SOME)
    assert "\n".join(result.outlines).startswith(IDS)
    assert not reports(pytester).exists()


def test_each_case_says_what_it_requires(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--collect-only", "-vv", "-k", "abort.frame")
    result.stdout.fnmatch_lines(
        [
            "*<Case abort.frame  MUST  clause 7.2.4.3.17  rules abort.code response.reserved>",
            "*An abort of the server is exactly 80h, the multiplexer, and a code of table 22.",
        ]
    )


def test_the_ids_name_the_device_when_there_are_several(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--node-id=5,9", "--collect-only", "-q", "-k", "abort.frame")
    assert result.outlines[:2] == [
        "cases/test_abort.py::abort.frame@5",
        "cases/test_abort.py::abort.frame@9",
    ]


@pytest.mark.parametrize("interface", ["socketcan", "virtual", "pcan"])
def test_no_adapter_is_needed(pytester: pytest.Pytester, interface: str) -> None:
    bus = (f"--can-interface={interface}", "--can-channel=can0")
    result = run(pytester, "--node-id=5", *bus, "--collect-only", *SOME)
    assert result.ret == pytest.ExitCode.OK
    assert not reports(pytester).exists()


def test_a_project_may_call_its_files_and_tests_as_it_likes(pytester: pytest.Pytester) -> None:
    pytester.makeini("[pytest]\npython_files = *_check.py\npython_functions = check_*")
    pytester.makepyfile(mine_check="def check_mine(): pass\ndef test_not_mine(): pass")
    chosen = ("-k", "mine or abort.not-answered or abort.frame or test_whole_run")
    result = self_test(pytester, "--collect-only", "-q", ".", "cases", *chosen)
    assert "\n".join(result.outlines).startswith(f"mine_check.py::check_mine\n{IDS}")
