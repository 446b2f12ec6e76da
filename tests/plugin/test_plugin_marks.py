"""The marks of the cases: what -m leaves out does not happen on the bus."""

import json
import re
from collections.abc import Iterator
from fnmatch import filter as matching

import pytest
from plugin_runs import QUICK, run, self_test, the_report

from conformance.plugin.marks import MARKS, READS

pytest_plugins = ["pytester"]

# A download initiate, of segments or of blocks.
DOWNLOAD = re.compile(r"\b6[0-7]\w#(?:[23]|[CD][02468ACE])")


class Marks:
    """Takes the marks of all cases, by their ids."""

    def __init__(self) -> None:
        self.of: dict[str, set[str]] = {}

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self.of = {item.name: {mark.name for mark in item.iter_markers()} for item in session.items}


def marks(pytester: pytest.Pytester) -> dict[str, set[str]]:
    found = Marks()
    arguments = (*QUICK, "--self-test", "--collect-only", "-q", "--strict-markers")
    pytester.runpytest_inprocess(*arguments, plugins=[found])
    return found.of


def sent_by_cases(pytester: pytest.Pytester) -> Iterator[tuple[str, str]]:
    """Yield each case of the only run with each frame that it has sent."""
    folder = the_report(pytester)
    log = (folder / "bus.log").read_text(encoding="utf-8").splitlines()
    for line in (folder / "results.jsonl").read_text(encoding="utf-8").splitlines():
        record = json.loads(line)
        if record["record"] == "case" and record.get("frames"):
            frames = record["frames"]
            for frame in log[frames["first"] - 1 : frames["last"]]:
                if frame.endswith(" T"):
                    yield record["result"]["case_id"], frame


def test_what_only_reads_sends_no_download(pytester: pytest.Pytester) -> None:
    result = self_test(pytester, "--sdo-simulated", "-m", "not writes")
    assert result.parseoutcomes()["passed"] > 400
    sent = list(sent_by_cases(pytester))
    assert len(sent) > 1000
    assert not [case for case, frame in sent if DOWNLOAD.search(frame)]


def test_no_other_case_sends_nmt_commands(pytester: pytest.Pytester) -> None:
    chosen = ("-m", "not nmt and not matrix and not random", "-k", "not beyond and not 4097")
    assert self_test(pytester, "--sdo-simulated", *chosen).ret == pytest.ExitCode.OK
    assert not [case for case, frame in sent_by_cases(pytester) if " 000#" in frame]


SOME = {
    "block-download.crc-and-size-wrong": {"must", "block", "download", "writes"},
    "segmented-upload.toggle-first": {"must", "segmented", "upload", "writes"},
    "upload.device-type": {"must", "expedited", "upload"},
    "frame.short[1]": {"may", "risky"},
    "matrix.block-upload-end[40h]": {"must", "matrix", "block", "upload", "writes"},
    "vanished-client.next-transfer[block-download-between]": {
        *("must", "block", "download", "writes", "risky")
    },
    "server-timeout.once[segmented-download-middle]": {
        *("must", "segmented", "download", "writes", "slow")
    },
    "od.read[1018h:01]": {"must", "od"},
}


@pytest.mark.parametrize(
    ("expression", "hint"),
    [
        ("blok", "'blok'. Did you mean 'block'?"),
        ("not (slow or wirtes)", "'wirtes'. Did you mean 'writes'?"),
        ("MUST and segmented", "'MUST'. Did you mean 'must'?"),
        ("down", "'down'. Did you mean 'download'?"),
    ],
)
def test_a_mistyped_mark_is_an_error(pytester: pytest.Pytester, expression: str, hint: str) -> None:
    """pytest would run nothing, or all."""
    result = self_test(pytester, "--sdo-simulated", "-m", expression)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    assert f"-m: there is no mark {hint}" in result.stdout.str() + result.stderr.str()


def test_marks_of_the_project_are_none_of_ours(pytester: pytest.Pytester) -> None:
    """One that no test of this run bears may be used in other folders."""
    pytester.makepyfile(test_mine="import pytest\n@pytest.mark.mus\ndef test_mine(sdo): pass")
    for expression in ("mus", "not integration", "not hardware(port='must', unit=1)"):
        result = self_test(pytester, "--sdo-simulated", "test_mine.py", "-m", expression)
        assert result.parseoutcomes()["passed"] == 1


def test_the_marks_of_the_cases(pytester: pytest.Pytester) -> None:
    found = marks(pytester)
    assert {case: found[case] for case in SOME} == SOME
    levels = {"must", "should", "may"}
    assert all(len(levels & of_case) == 1 for of_case in found.values())
    assert set.union(*found.values()) == set(MARKS), "each mark has a case, and no case another"
    assert all("nmt" in found[case] for case in found if case.startswith("nmt.reset"))
    families = {case.partition("[")[0] for case in found}
    assert [pattern for pattern in READS if not matching(families, pattern)] == []


def test_pytest_explains_them(pytester: pytest.Pytester) -> None:
    result = run(pytester, "--markers")
    result.stdout.fnmatch_lines(["@pytest.mark.writes: a case that may send a download; others *"])
    assert all(f"@pytest.mark.{name}: a case that " in result.stdout.str() for name in MARKS)


def test_a_case_of_the_users_own_may_have_other_marks(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import pytest
        from conformance.run.case import must

        @pytest.mark.ours
        @must("ours.reads", "upload.size")
        def test_reads(sdo):
            '''It is read.'''
            sdo.upload(__import__("conformance").device.device.VENDOR_ID)
        """
    )
    result = pytester.runpytest_inprocess(*QUICK, "--collect-only", "-q", ".", "-m", "ours")
    result.stdout.fnmatch_lines(["*::ours.reads"])
