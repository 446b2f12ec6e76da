"""Reports are made of values: other words for all that the suite says leave them alone."""

import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from plugin_runs import NODE_ID, case_ids, hosted, reports, run
from support.rewording import reword, reworded, rewording

from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.eds.reading import read_eds
from conformance.faults.catalogue import build_node
from conformance.reporting.cause_counts import causes_of
from conformance.reporting.page.diagram import diagram
from conformance.reporting.recorded import read_run
from conformance.reporting.reproduction import FOLDER
from conformance.reporting.summary import summary_lines
from conformance.run import trace
from conformance.run.verdict import Verdict
from conformance.sdo.rules import Cause

pytest_plugins = ["pytester"]

CASES = "matrix.segmented-upload-first or independence.refusal or read-only or number-too-long"
EDS = Path(__file__).parents[1] / "fleet" / "servers" / "device.eds"
PROBES = Missing(Lack.PERMISSION, "read-only-probes")


def reword_all(patch: pytest.MonkeyPatch) -> None:
    """Have the suite say everything in other words: also causes, lacks and remarks."""
    init = NotTestable.__init__

    def lacking(self: NotTestable, words: str, *missing: Any) -> None:
        init(self, reworded(words), *missing)

    reword(patch)
    patch.setattr(NotTestable, "__init__", lacking)
    patch.setattr(Cause, "words", property(rewording(Cause.words.__get__)))
    patch.setattr(trace, "ASIDE", reworded(trace.ASIDE))
    patch.setattr(trace, "left_out", rewording(trace.left_out))


class Tags(HTMLParser):
    """Counts the tags of a page, with their classes."""

    def __init__(self) -> None:
        super().__init__()
        self.found: Counter[tuple[str, str]] = Counter()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        style = dict(attrs).get("class")
        if style is not None:  # the others show times
            self.found[tag, style] += 1


def structure(folder: Path) -> dict[str, Any]:
    """Return all of a report but its words and its times."""
    recorded = read_run(folder)
    results = recorded.results
    drawings = [diagram(result.trace, result.decisive) for result in results]
    lacking = (line for line in summary_lines(results, whole=True) if " not " in f" {line}")
    logs = sorted((folder / FOLDER).glob("*.log"))
    tags = Tags()
    tags.feed((folder / "report.html").read_text(encoding="utf-8"))
    return {
        "results": [(each.case_id, each.verdict, each.broken_rules) for each in results],
        "causes": [
            (count.cause.rule_id, [each.case_id for each in count.cases])
            for count in causes_of(recorded)
        ],
        "lacks": [re.findall(r"\d+ cases?\b", line) for line in lacking],
        "drawings": [
            [(row.sent, row.decisive, row.boxes) for row in drawn.rows]
            for drawn in drawings
            if drawn is not None
        ],
        "reproduced": {
            path.name: [line.split()[2:] for line in path.read_text().splitlines()] for path in logs
        },
        "page": tags.found,
        "junit": case_ids(folder / "junit.xml"),
        "rules": case_ids(folder / "causes.xml"),
    }


def test_other_words_leave_the_reports_as_they_are(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    found: list[tuple[Path, dict[str, Any]]] = []
    node = build_node("upload-toggle-ignored", NODE_ID, read_eds(EDS, NODE_ID))
    options = (f"--node-id={NODE_ID}", f"--sdo-eds={EDS}", "--sdo-seed=7", "-k", CASES)
    for rewords in (False, True):
        with hosted(node) as bus, monkeypatch.context() as patch:
            if rewords:
                reword_all(patch)
            run(pytester, *bus, *options, "--sdo-object=2010=visible_string")
        (folder,) = set(reports(pytester).iterdir()) - {each for each, _ in found}
        found.append((folder, structure(folder)))
    (plain, before), (other, after) = found
    for name, value in before.items():
        assert after[name] == value, name
    words = [{each.actual for each in read_run(folder).results} for folder in (plain, other)]
    assert words[0] & words[1] == {""}, "each sentence was reworded"
    sentences = {each.actual for each in read_run(plain).results if each.missing == PROBES}
    assert len(sentences) > 1, "one addition is asked for in several ways"
    verdicts = Counter(verdict for _, verdict, _ in before["results"])
    assert verdicts[Verdict.FAIL] > 1
    assert verdicts[Verdict.NOT_TESTABLE] > 10
    assert before["reproduced"]
