"""An error of the suite's own program, and fixtures of others with the names of ours."""

import pytest
from plugin_runs import case_ids, parsed, self_test, the_report

from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.pauses import Pauses
from conformance.plugin.exit_code import ExitCode
from conformance.plugin.fixtures import Fixtures
from conformance.run import case_run

pytest_plugins = ["pytester"]

CASE = ("-k", "abort.not-answered[general-error]")
WORDS = "The suite itself has an error: TypeError: no such thing ("


def raise_it(*_: object, **__: object) -> None:
    raise TypeError("no such thing")


@pytest.mark.parametrize(
    ("owner", "method"),
    [(Dialogue, "expect_nothing"), (case_run, "leave")],
    ids=["in-a-case", "behind-a-case"],
)
def test_an_error_of_the_suite_is_no_failure(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, owner: object, method: str
) -> None:
    monkeypatch.setattr(owner, method, raise_it)
    result = self_test(pytester, *CASE)
    result.assert_outcomes(errors=1)
    assert result.ret == ExitCode.SUITE_ERROR
    output = result.stdout.str()
    assert WORDS in output
    assert "in raise_it)" in output
    assert "Traceback (most recent call last):" in output
    (case,) = parsed(the_report(pytester) / "junit.xml").iter("testcase")
    assert case.find("failure") is None
    assert case.find("error") is not None


def test_an_error_in_a_fixture_of_the_suite_is_no_failure(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Roles, "number", raise_it)
    chosen = self_test(pytester, "-k", "test_expedited_download")
    assert chosen.ret == ExitCode.SUITE_ERROR
    assert WORDS in chosen.stdout.str()
    assert "failed" not in chosen.parseoutcomes()


def test_an_error_of_the_suite_does_not_keep_the_others_from_being_run(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Dialogue, "expect_nothing", raise_it)
    result = self_test(pytester, "-k", "abort.frame or abort.not-answered[general-error]")
    result.assert_outcomes(errors=1, passed=1)


def test_a_case_of_the_users_own_fails_by_itself(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        test_mine="""
from conformance.run.case import must

@must("mine.case", clause="7.2.4")
def test_mine(sdo):
    '''Ours.'''
    raise TypeError("my own")
"""
    )
    result = self_test(pytester, "test_mine.py")
    result.assert_outcomes(failed=1)
    assert result.ret == pytest.ExitCode.TESTS_FAILED


FAULTY = ("--sdo-fault=upload-toggle-ignored", "-k", "segmented-upload.toggle-first")


def test_what_a_pause_of_the_bench_may_have_caused_is_no_failure(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    self_test(pytester, *FAULTY).assert_outcomes(failed=1)
    monkeypatch.setattr(Pauses, "excuse", True)
    result = self_test(pytester, *FAULTY, "--sdo-write-deviations=drafted.toml")
    result.assert_outcomes(skipped=1)
    assert result.ret == pytest.ExitCode.OK
    assert "the bench itself was not running at times" in result.stdout.str()
    assert "[[deviations]]" not in (pytester.path / "drafted.toml").read_text()


NAMES = [name for name in vars(Fixtures) if name.startswith("sdo")]
FEW = (
    "abort.frame or test_whole_run or expedited-download.size or segmented-download.toggle "
    "or upload.identity or dictionary.write-only"
)


def test_fixtures_of_the_user_are_not_for_the_suite(pytester: pytest.Pytester) -> None:
    plain = self_test(pytester, "-k", FEW).parseoutcomes()
    functions = "".join(
        f"\n@pytest.fixture\ndef {name}():\n    raise RuntimeError('of the user')\n"
        for name in NAMES
    )
    pytester.makeconftest("import pytest\n" + functions)
    result = self_test(pytester, "-k", FEW)
    assert result.parseoutcomes() == plain
    assert len(NAMES) > 10
    assert plain["passed"] > 10
    assert "failed" not in plain


def test_but_for_the_users_own_tests(pytester: pytest.Pytester) -> None:
    pytester.makeconftest(
        "import pytest\n\n"
        "@pytest.fixture\ndef sdo_text(sdo_device):\n    return sdo_device.node_id\n"
    )
    pytester.makepyfile(test_mine="def test_mine(sdo, sdo_text):\n    assert sdo_text == 5\n")
    result = self_test(pytester, "test_mine.py")
    result.assert_outcomes(passed=1)
    assert case_ids(the_report(pytester) / "junit.xml") == ["test_mine"]
