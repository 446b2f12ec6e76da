"""In which order a run takes the cases: what a device may not survive comes last."""

import pytest
from plugin_runs import case_ids, self_test, the_report

pytest_plugins = ["pytester"]

RISKY = (
    "frame.remote or frame.short-abort or frame.mirror or specifier.unknown or run.filler "
    "or block-download.lost"
)


def test_what_is_risky_comes_behind_the_rest(pytester: pytest.Pytester) -> None:
    """Whatever file it stands in; what judges the whole run stays the last."""
    self_test(pytester, "--junitxml=all.xml", "-k", RISKY, "-v")
    ids = case_ids(pytester.path / "all.xml")
    families = list(dict.fromkeys(case_id.partition("[")[0] for case_id in ids))
    assert families == [
        "frame.mirror",
        "specifier.unknown",
        "specifier.unknown-is-over",
        "block-download.lost",
        "block-download.lost-twice",
        "frame.remote",
        "frame.remote-ignored",
        "frame.short-abort",
        "run.filler",
    ]
    assert (the_report(pytester) / "junit.xml").is_file()
