"""The pages of the site: what is written of the rules and faults, and where links lead."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from conformance.faults.catalogue import faults, unusual
from conformance.reporting.rule_listing import scripted_cases
from conformance.sdo.rules import RULES, cited

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("site") / "pages"
    subprocess.run((sys.executable, "docs/pages.py", folder), cwd=ROOT, check=True)  # noqa: S603
    return {
        path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in folder.rglob("*.md")
    }


def test_each_rule_is_on_a_page_with_its_clause_and_cases(pages: dict[str, str]) -> None:
    chapters = "\n".join(
        text for name, text in pages.items() if name.startswith("rules/") and "index" not in name
    )
    parts = {part.partition("\n")[0]: part for part in re.split(r"(?m)^## ", chapters)}
    cases = scripted_cases()
    for rule in RULES:
        assert f"**{rule.level}**, {cited(rule.clause)}: " in parts[rule.id]
        for case in cases:
            if rule in case.cites:
                assert f"- `{case.rule.id}" in parts[rule.id]
    toggle = parts["segmented-upload.toggle"]
    assert "- `upload-toggle-ignored`: Takes segment requests whatever their toggle bit." in toggle
    assert "SDO 17" in toggle


def test_each_server_is_listed(pages: dict[str, str]) -> None:
    for server in [*faults(), *unusual()]:
        assert f"| `{server.name}` | " in pages["faults.md"]


def test_links_lead_to_pages_and_files_but_not_to_folders_of_the_repository(
    pages: dict[str, str],
) -> None:
    assert "(docs/" not in pages["index.md"]
    assert "[First run](first-run.md)" in pages["index.md"]
    assert "an example project |" in pages["index.md"]
    assert "(contributing.md)" in pages["index.md"]
    assert "(architecture.md)" in pages["contributing.md"]
    assert "[github.yml](files/examples/ci/github.yml)" in pages["ci.md"]


def test_the_contents_name_each_page(pages: dict[str, str]) -> None:
    """Sphinx takes a page that is in none of them for an error."""
    listed = re.findall(r"^[\w/-]+$", pages["index.md"], re.MULTILINE)
    top = {
        name.removesuffix(".md") for name in pages if not re.match("rules/(?!index)|index", name)
    }
    assert top <= set(listed)
