"""report.html: what it says of a run, from its record and its log."""

import gzip
import re
from collections.abc import Sequence
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reporting_results import ABOUT, DEVICE, END, UNHURRIED, result

from conformance.__main__ import main
from conformance.commands.status import DONE
from conformance.reporting.bus_log import Place
from conformance.reporting.page.writing import MOST_WITH_FRAMES, PAGE, write_page
from conformance.reporting.recorded import RecordedRun
from conformance.reporting.reproduction import FOLDER
from conformance.reporting.results import RESULTS, ResultsFile
from conformance.run.trace import TraceLine
from conformance.run.verdict import CaseResult, Verdict

LOG = """\
(100.000000) can0 605#4000100000000000 T
(100.001000) can0 585#4300100091010F00 R
(100.500000) can0 000#8205 T
(101.000000) can0 605#2B01200034120000 T
(101.002000) can0 609#4000100000000000 T
(101.004000) can0 585#8001200002000106 R
(101.010000) can0 605#2B01200034120000 T
(101.018000) can0 585#6001200000000000 R
"""
ORDER = (("segmented-upload-last", "40h"), ("idle", "21h"))
PLACES = [Place("bus.log", 1, 3), Place("bus.log", 4, 8)]
FAILED = result(
    Verdict.FAIL,
    case_id="matrix.idle[40h]",
    broken_rule="response.specifier",
    cause="response.specifier: abort to download initiate",
    expected="60h",
    actual="an abort",
    trace=[
        TraceLine(
            "download initiate 2001h:00, expedited, 2 bytes: 34 12",
            "605#2B01200034120000",
            sent=True,
            kind="DownloadInitiate",
        ),
        TraceLine(
            "abort 2001h:00, 06010002h (read only)",
            "585#8001200002000106",
            elapsed=0.002,
            kind="Abort",
        ),
    ],
    decisive=1,
)


class Reader(HTMLParser):
    """Keeps the text of a page, and checks that its tags fit together."""

    VOID = frozenset(("meta", "input", "br", "path", "rect"))

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.tags: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open[-1:] not in (["style"], ["script"]):
            self.text += " ".join(data.split()) + " " if data.strip() else ""


def page_of(
    folder: Path,
    results: Sequence[CaseResult],
    *,
    ended: bool = True,
    log: str = LOG,
    found: dict[str, list[str]] | None = None,
    **about: object,
) -> Reader:
    (folder / "bus.log").write_text(log, encoding="utf-8")
    places: list[Place | None] = [*PLACES, *[None] * len(results)][: len(results)]
    end = {"at": "2026-05-06T09:09:09.500+02:00", **END, **(found or {})} if ended else None
    run = RecordedRun({**ABOUT, **about}, [DEVICE], list(results), places, len(results), end)
    reader = Reader()
    reader.feed(write_page(folder, run).read_text(encoding="utf-8"))
    reader.close()
    assert reader.open == []
    return reader


def test_the_verdict(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    assert "Nodes 5, 9: 2 cases tested, 1 failed, for 1 cause." in page.text
    assert "device name (1008h) Drive" in page.text
    assert "drive.eds, version 1.4 SHA-256" in page.text
    assert "pytest --node-id=5,9" in page.text
    assert "(60.5 s)" in page.text
    assert "machine bench-3: " in page.text


def test_a_cause(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    assert "1. response.specifier : abort to download initiate" in page.text
    assert "MUST, CiA 301 clause" in page.text
    (picture,) = (each for tag, each in page.tags if each.get("class") == "diagram")
    assert picture["aria-label"] == (
        "client: download initiate 2001h:00, expedited, 2 bytes: 34 12; "
        "server: abort 2001h:00, 06010002h (read only) (the offending frame)"
    )
    assert [each["class"] for tag, each in page.tags if tag == "g" and each] == ["decisive"]
    assert "2B cs 1, n 2, e 1, s 1 01 20 00 2001h:00 34 12 00 00 data" in page.text
    assert "80 cs 4 01 20 00 2001h:00 02 00 01 06 code 06010002h" in page.text


def test_the_frames_of_a_case_that_passed(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(trace=[]), result(case_id="download.number")])
    assert (
        "0.0 > 605#4000100000000000 upload initiate 1000h:00 "
        "1.0 < 585#4300100091010F00 upload initiate response 1000h:00, expedited, 4 bytes: "
        "91 01 0F 00 500.0 > 000#8205 NMT: reset communication, node 5"
    ) in page.text
    assert "609#" not in page.text


def test_a_page_of_many_cases_has_the_frames_of_those_that_did_not_pass(tmp_path: Path) -> None:
    (tmp_path / "bus.log").write_text(LOG, encoding="utf-8")
    results = [result(trace=[]), result(Verdict.UNIMPLEMENTED, trace=[])]
    results += [result(trace=[])] * (MOST_WITH_FRAMES - len(results))
    run = RecordedRun(ABOUT, [DEVICE], results, [*PLACES, *[None] * (len(results) - 2)])
    assert "0.0 &gt; 605#4000100000000000 upload" in write_page(tmp_path, run).read_text(
        encoding="utf-8"
    )
    run.results.append(result(trace=[]))
    run.places.append(Place("bus.log", 4, 6))
    page = write_page(tmp_path, run).read_text(encoding="utf-8")
    assert "605#4000100000000000" not in page
    assert "<pre>0.0 &gt; 605#2B01200034120000 download" in page
    assert "<pre>… 3 frames, which are in bus.log, lines 1 to 3</pre>" in page
    assert "does not show the frames of the 2 cases that passed" in page


def test_times_and_audit(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    assert "upload initiate 1 1.00 1.00 1.00" in page.text
    assert "download initiate 2 4.00 4.00 8.00" in page.text
    assert "3 requests were sent in the cases, 3 responses came." in page.text
    assert re.search(r"node 5, 2001h:00 2 \d\d:\d\d:\d\d \d\d:\d\d:\d\d 34 12 ", page.text)
    assert "NMT: reset communication, node 5 1" in page.text
    assert "Each value that was changed has been put back." in page.text


def test_the_map(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    assert "idle 40h ✗" in page.text


def test_the_map_has_the_order_of_a_transfer_whatever_ran_first(tmp_path: Path) -> None:
    ids = [f"matrix.{state}[{stimulus}]" for state, stimulus in ORDER]
    page = page_of(tmp_path, [result(case_id=case_id) for case_id in ids][:2])
    assert "idle segmented-upload-last 21h ✓ 40h ✓" in page.text


def test_rules_and_steps(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    assert "SDO 01 reads 1000h 1 0 0 1 ✓" in page.text
    assert "SDO 02 reads and writes back 1017h 0 0 0 none" in page.text
    assert re.search(r"response\.specifier [^✓✗]* 0 1 0 1 ✗", page.text)


def test_what_to_fix_first_stands_at_the_beginning(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    first = "Fix this first: response.specifier: abort to download initiate the only failure MUST, "
    assert page.text.index(first) < page.text.index("Bench")
    assert "Fix this first" not in page_of(tmp_path, [result()]).text


def test_all_causes_are_listed_before_all_tables(tmp_path: Path) -> None:
    other = result(
        Verdict.FAIL, case_id="nmt.x", broken_rule="nmt.stopped", cause="nmt.stopped: served"
    )
    page = page_of(tmp_path, [FAILED, other])
    listed = [page.text.index(str(failed.cause)) for failed in (FAILED, other)]
    assert max(listed) < page.text.index("Bench")
    links = [each["href"] for tag, each in page.tags if tag == "a"]
    for anchor in ("cause-1", "cause-2"):
        assert f"#{anchor}" in links
        assert ("article", {"class": "cause", "id": anchor}) in page.tags


def test_the_rarer_reasons_are_folded(tmp_path: Path) -> None:
    lacking = [result(Verdict.NOT_TESTABLE, actual=f"needs {number}") for number in range(8)]
    page = page_of(tmp_path, lacking)
    assert "2 more reasons, for 2 cases" in page.text
    assert all(f"needs {number}" in page.text for number in range(8))


def test_a_quick_run_says_what_it_leaves_out(tmp_path: Path) -> None:
    about = {**ABOUT, "properties": {**ABOUT["properties"], "node-5.quick": "2 of 9 cases"}}
    run = RecordedRun(about, [DEVICE], [result()], [None], 1, None)
    assert "A quick run: 2 of 9 cases." in write_page(tmp_path, run).read_text(encoding="utf-8")


def test_a_run_that_was_killed(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result()], ended=False)
    assert "no case has failed, but the run is not a pass" in page.text
    assert "the run was killed: its record has no end" in page.text
    assert "The run has no end: what was not put back stands in not-restored.jsonl" in page.text


def test_a_log_that_is_cut_off_or_gone(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(trace=[]), FAILED], log=LOG[:300])
    assert "0.0 > 605#4000100000000000 upload initiate 1000h:00" in page.text
    (tmp_path / "bus.log").unlink()
    run = RecordedRun(ABOUT, [DEVICE], [result()], [PLACES[0]], 1, None)
    text = write_page(tmp_path, run).read_text(encoding="utf-8")
    assert "There is no log of frames beside this report." in text


def packed(folder: Path) -> Path:
    """Pack the log of a run, as someone does who is to mail it."""
    log = folder / "bus.log"
    (folder / "bus.log.gz").write_bytes(gzip.compress(log.read_bytes()))
    log.unlink()
    return folder / "bus.log.gz"


def test_a_packed_log_is_read_as_it_was(tmp_path: Path) -> None:
    run = RecordedRun(ABOUT, [DEVICE], [result(trace=[]), FAILED], [*PLACES], 2, None)
    (tmp_path / "bus.log").write_text(LOG, encoding="utf-8")
    unpacked = write_page(tmp_path, run).read_text(encoding="utf-8")
    assert "upload initiate response 1000h:00" in unpacked
    path = packed(tmp_path)
    assert write_page(tmp_path, run).read_text(encoding="utf-8") == unpacked
    path.write_bytes(path.read_bytes()[:-20])  # as a full disk leaves it
    assert "<h2>Causes</h2>" in write_page(tmp_path, run).read_text(encoding="utf-8")


def test_a_cause_leads_to_what_reproduces_it(tmp_path: Path) -> None:
    (tmp_path / FOLDER).mkdir()
    links = [f"{FOLDER}/01-response.specifier{end}" for end in (".sh", ".log")]
    for link in links:
        (tmp_path / link).write_text("(0.0) can0 605#2B01200034120000 T\n", encoding="utf-8")
    page = page_of(tmp_path, [result(), FAILED], bus_arguments=["--can-channel=can1"])
    hrefs = [each["href"] for tag, each in page.tags if tag == "a"]
    assert [href for href in hrefs if href and not href.startswith("#")] == links
    assert f"conformance replay {links[1]} --can-channel=can1 --writes" in page.text


def test_it_needs_nothing_beside_it(tmp_path: Path) -> None:
    """Neither the network nor another file; a policy in it forbids what is fetched."""
    page = page_of(tmp_path, [result(), FAILED])
    for _, attributes in page.tags:
        assert not attributes.keys() & {"src", "onclick", "onload"}
        assert (attributes.get("href") or "#").startswith("#")
    (policy,) = (each for tag, each in page.tags if each.get("http-equiv"))
    assert str(policy["content"]).startswith("default-src 'none'")


def test_each_link_leads_somewhere(tmp_path: Path) -> None:
    page = page_of(tmp_path, [result(), FAILED])
    ids = [each["id"] for _, each in page.tags if "id" in each]
    assert len(ids) == len(set(ids))
    assert {str(each["href"])[1:] for tag, each in page.tags if tag == "a"} <= set(ids)


HOSTILE = (
    "<script>x()</script>",
    "]]>",
    "{{ 7 * 7 }}",
    "\x1b[31m",
    "\u202e",
    '"onload=x()',
    "-->",
    "</pre>",
)
TEXTS = st.text(min_size=1) | st.sampled_from(HOSTILE)


@UNHURRIED
@given(TEXTS, TEXTS, TEXTS)
def test_what_a_device_says_is_inert(
    tmp_path_factory: pytest.TempPathFactory, said: str, name: str, frame: str
) -> None:
    """Whatever it sends is text, and is shown; nothing of it becomes a tag."""
    folder = tmp_path_factory.mktemp("inert")
    harmless, hostile = (
        result(
            Verdict.FAIL,
            **dict.fromkeys(("case_id", "service", "requirement", "expected", "reason"), text),
            actual=text,
            notes=[text],
            trace=[TraceLine(text, frame)],
            decisive=0,
            cause=text,
        )
        for frame, text in (("1#00", "x"), (frame, said))
    )
    plain = page_of(folder, [harmless])
    device = {**DEVICE, "texts": {"1008h:00": said}, "identity": {name: said}}
    run = RecordedRun(ABOUT, [device], [hostile], [PLACES[0]], 1, None)
    text = write_page(folder, run).read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    assert {tag for tag, _ in reader.tags} <= {tag for tag, _ in plain.tags}
    assert not any(name.startswith("on") for _, each in reader.tags for name in each)
    assert "\x1b" not in text
    assert "\u202e" not in text
    if said in HOSTILE and said.isprintable():
        assert said in reader.text


def test_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bus.log").write_text(LOG, encoding="utf-8")
    file = ResultsFile(tmp_path)
    file.run(ABOUT)
    file.selected(1)
    file.device(DEVICE)
    file.case(result(), PLACES[0])
    file.end(END)
    assert not file.close()
    assert (tmp_path / RESULTS).is_file()
    assert main(["report", str(tmp_path)]) == DONE
    assert f"written: {tmp_path / PAGE}" in capsys.readouterr().out


def test_a_rule_is_red_where_it_is_broken(tmp_path: Path) -> None:
    """Not where a case that tests it has failed for another."""
    both = replace(FAILED, rules=["response.specifier", "response.multiplexer"])
    page = page_of(tmp_path, [result(), both])
    text = (tmp_path / PAGE).read_text(encoding="utf-8")
    rows = re.findall(r'<tr( class="has-failed")?><th scope="row"><b>([^<]+)</b>', text)
    assert {name for red, name in rows if red} >= {"response.specifier"}
    assert "response.multiplexer" in {name for red, name in rows if not red}
    assert "1 failed" in page.text


def test_what_is_wrong_with_the_bench_stands_at_the_top(tmp_path: Path) -> None:
    broken = result(Verdict.BENCH_ERROR, actual="lost")
    found = {"unrestored": ["2001h:00 held 05"], "bench_errors": ["Node 5 is lost"]}
    page = page_of(tmp_path, [result(), broken], found=found)
    assert page.text.index("not put back: 2001h:00 held 05") < page.text.index("Cases by service")
    assert page.text.index("Node 5 is lost") < page.text.index("Cases by service")
