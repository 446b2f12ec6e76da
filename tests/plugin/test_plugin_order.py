"""In which order a run takes the cases: what shows most first, what stops a device last."""

import pytest
from plugin_runs import case_ids, self_test, the_report

from conformance.plugin.case_order import table
from conformance.run.risks import Kind

pytest_plugins = ["pytester"]

RISKY = (
    "frame.remote or frame.short-abort or frame.mirror or specifier.unknown or run.filler "
    "or block-download.lost"
)


# Their frames are of a kind that no client sends.
NO_CLIENT = ("frame.remote", "frame.short-abort")
KINDS = {
    "specifier.unknown": Kind.UNKNOWN_SPECIFIER,
    "specifier.unknown-is-over": Kind.UNKNOWN_SPECIFIER,
    "block-download.lost": Kind.LOST_SEGMENT,
    "block-download.lost-twice": Kind.LOST_SEGMENT,
    "block-download.lost-later": Kind.LOST_SEGMENT,
}


def test_what_is_risky_comes_behind_the_rest(pytester: pytest.Pytester) -> None:
    """Whatever file it stands in; what judges the whole run stays the last."""
    self_test(pytester, "--junitxml=all.xml", "-k", RISKY, "-v")
    ids = case_ids(pytester.path / "all.xml")
    unmet = [case_id for case_id in ids if case_id.startswith(NO_CLIENT)]
    assert len(unmet) == 4
    assert (the_report(pytester) / "junit.xml").is_file()
    assert ids == [case_id for case_id in ids if case_id not in unmet][:-1] + unmet + ["run.filler"]


def test_what_shows_most_comes_first(pytester: pytest.Pytester) -> None:
    """Lost segments come behind the others there, unknown specifiers behind all of these."""
    self_test(pytester, "--junitxml=all.xml", "-k", "specifier or block-download.lost")
    ids = case_ids(pytester.path / "all.xml")
    early = [
        case_id
        for case_id in ids
        if case_id in table()
        and table()[case_id].early
        and not case_id.startswith("specifier.unknown")
    ]
    assert ids[: len(early)] == early
    for part in (early, ids[len(early) :]):
        kinds = [KINDS.get(case_id.partition("[")[0], Kind.ORDINARY) for case_id in part]
        assert kinds == sorted(kinds)
        assert len(set(kinds)) > 1


def test_what_another_plugin_has_shuffled_is_in_order_again(pytester: pytest.Pytester) -> None:
    """Also what the table of worth does not know: that is as it is written."""
    selected = ("-k", "segmented-upload.restart or segmented-upload.toggle-afterwards")
    self_test(pytester, "--junitxml=plain.xml", *selected)
    pytester.makeconftest(
        """
        import pytest

        @pytest.hookimpl(tryfirst=True)
        def pytest_collection_modifyitems(items):
            items.reverse()
        """
    )
    self_test(pytester, "--junitxml=reversed.xml", *selected)
    plain, reverse = (case_ids(pytester.path / f"{each}.xml") for each in ("plain", "reversed"))
    assert len(plain) > 3
    assert reverse == plain
