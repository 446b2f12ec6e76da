"""report.html in a browser: its script runs there, and its links open what they lead to."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from reporting_results import result
from test_page import FAILED, page_of

from conformance.reporting.page.writing import PAGE

BROWSER = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
pytestmark = pytest.mark.skipif(BROWSER is None, reason="needs Chromium: apt-get install chromium")


def opened(page: Path, fragment: str = "") -> str:
    """Return the elements of a page once it has been opened."""
    command = [
        *(str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"),
        *(f"--user-data-dir={page.parent / 'profile'}", f"file://{page}{fragment}"),
    ]
    done = subprocess.run(command, capture_output=True, check=True, timeout=120)  # noqa: S603
    return done.stdout.decode("utf-8")


def case(dom: str, number: int) -> str:
    found = re.search(rf'<details class="case" id="c{number}"[^>]*>', dom)
    assert found is not None
    return found[0]


def test_the_filter_is_there(tmp_path: Path) -> None:
    page_of(tmp_path, [FAILED])
    dom = opened(tmp_path / PAGE)
    assert re.search(r"<output [^>]*>1 of 1 cases</output>", dom)
    assert '<form id="filter" aria-label="Which cases are shown">' in dom
    assert "open" not in case(dom, 0)


def test_the_map_is_one_stop_of_the_tab_key(tmp_path: Path) -> None:
    cases = [result(case_id=f"matrix.{state}[40h]") for state in ("idle", "block-upload-end")]
    page_of(tmp_path, cases)
    table = re.search(r'<table class="map">.*?</table>', opened(tmp_path / PAGE), re.DOTALL)
    assert table is not None
    links = re.findall(r"<a [^>]*>", table[0])
    assert [re.findall(r'tabindex="([^"]+)"', link) for link in links] == [["0"], ["-1"]]


def test_a_link_opens_its_case(tmp_path: Path) -> None:
    page_of(tmp_path, [FAILED])
    assert 'open=""' in case(opened(tmp_path / PAGE, "#c0"), 0)
