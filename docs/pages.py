"""Writes the pages of the site into a folder, from which Sphinx builds it: "make docs".

They are the pages of this folder, the README as the first of them, and what the suite itself says
of its rules, with their cases, and of the faulty servers on which it is tested.
"""

import os
import re
import shutil
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from conformance.eds.rules import RULES as EDS_RULES
from conformance.faults.catalogue import faults, unusual
from conformance.faults.registry import Defect, Deviation
from conformance.reporting.rule_listing import answers, official_steps, scripted_cases, untested
from conformance.run.case import CaseInfo
from conformance.sdo.rules import CHAPTERS, Rule, cited
from conformance.sdo.rules.chapters import Chapter

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
# Files of the repository that are pages, too.
FILES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
SECTIONS = {
    "Use": "first-run device eds options result reports deviations endings ci lab own-tests server",
    "What is tested": "cases rules/index faults official-test limits",
    "Develop": "architecture testing contributing changelog",
}
# The text of a link may be a picture, then it is left out.
LINK = re.compile(r"(\[[^\[\]]*)?\]\(([^)#:\s]+)(#[^)]*)?\)")


def write_pages(folder: Path) -> None:
    """Write all pages into a new folder."""
    shutil.copytree(HERE, folder, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    for path in HERE.rglob("*.md"):
        _copy(path, folder, path.relative_to(HERE).as_posix())
    for name, page in FILES.items():
        _copy(ROOT / name, folder, page)
    _append(folder / "index.md", _contents())
    _append(folder / "rules" / "index.md", _all_rules())
    _append(folder / "faults.md", _all_servers())
    for chapter in CHAPTERS:
        _append(folder / "rules" / f"{_file(chapter)}.md", _chapter(chapter))


def _copy(file: Path, folder: Path, page: str) -> None:
    """Write a file as a page, and let its links lead to what is there of the repository.

    Other files than pages come along. Of a link to a folder only the text stays.
    """

    def led(link: re.Match[str]) -> str:
        text, target, anchor = link.groups("")
        path = (file.parent / target).resolve()
        if not path.is_relative_to(HERE):
            if path.is_dir():
                return text[1:]
            name = path.relative_to(ROOT).as_posix()
            path = HERE / FILES.get(name, f"files/{name}")
            if name not in FILES:
                copied = folder / "files" / name
                copied.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(ROOT / name, copied)
        relative = os.path.relpath(path, (HERE / page).parent)
        return f"{text}]({Path(relative).as_posix()}{anchor})"

    text = LINK.sub(led, file.read_text(encoding="utf-8"))
    (folder / page).write_text(text, encoding="utf-8")


def _append(path: Path, lines: Iterator[str]) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in lines)


def _contents() -> Iterator[str]:
    """Yield the contents, which stand beside each page."""
    for section, pages in SECTIONS.items():
        yield from ["", "```{toctree}", ":hidden:", f":caption: {section}", "", *pages.split()]
        yield "```"


def _file(chapter: Chapter) -> str:
    return re.sub("[^a-z]+", "-", chapter.title.lower())


def _all_rules() -> Iterator[str]:
    for chapter in CHAPTERS:
        yield from ["", f"## {_title(chapter.title)}", ""]
        for rule in chapter.rules:
            link = f"[`{rule.id}`](#{_label(rule)})"
            yield f"- {link}, {rule.level}, {rule.clause}: {_text(rule.sentence)}"
    yield from ["", "## Descriptions of devices", "", "[`conformance eds`](../eds.md) checks:", ""]
    for of_file in EDS_RULES:
        yield f"- `{of_file.id}`, {of_file.severity}, {of_file.clause}: {_text(of_file.sentence)}"
    yield from ["", "```{toctree}", ":hidden:", "", *map(_file, CHAPTERS), "```"]


def _label(rule: Rule) -> str:
    return "rule-" + rule.id.replace(".", "-")


def _chapter(chapter: Chapter) -> Iterator[str]:
    yield f"# {_title(chapter.title)}"
    for rule in chapter.rules:
        yield from _rule(rule)


def _rule(rule: Rule) -> Iterator[str]:
    cases = [case for case in CASES if rule in case.cites]
    yield from ["", f"({_label(rule)})=", f"## {rule.id}", ""]
    yield from [f"**{rule.level}**, {cited(rule.clause)}: {_text(rule.sentence)}", ""]
    yield from [f"- {name}: {_text(text)}" for name, text in answers(rule)]
    if not cases:
        yield f"- not tested: {_text(untested(rule))}"
        return
    if steps := official_steps([case.rule.id for case in cases]):
        yield f"- [official test](../official-test.md): {', '.join(steps)}"
    yield from ["", "Cases that test it:", ""]
    yield from [f"- {_ids(case)}: {_text(case.rule.sentence)}" for case in cases]
    names = {case.rule.id for case in cases}
    caught = [fault for fault in FAULTS if not names.isdisjoint(_catchers(fault))]
    if caught:
        yield from ["", "[Faulty servers](../faults.md) that these have to catch:", ""]
        yield from [f"- `{fault.name}`: {_text(fault.sentence)}" for fault in caught]


def _ids(case: CaseInfo) -> str:
    """Return the id of a case, for how many values it is run, and when."""
    many = len(case.variations())
    told = [f"{many} of them"] if many > 1 else []
    told += ["with `--sdo-thorough`"] if case.thorough else []
    name = f"`{case.rule.id}`" if case.argument is None else f"`{case.rule.id}[…]`"
    return f"{name} ({', '.join(told)})" if told else name


def _catchers(fault: Deviation) -> set[str]:
    """Return the ids of the cases that have to fail for a fault, without what they vary in."""
    return {begin.partition("[")[0] for begin in fault.caught_by}


def _all_servers() -> Iterator[str]:
    """Yield the faulty servers by kind, then the unusual ones."""
    for defect in Defect:
        yield from ["", f"## {_title(defect)}", "", "| faulty server | what it does | caught by |"]
        yield "|---|---|---|"
        for fault in FAULTS:
            if fault.defect is defect:
                told = _text(fault.sentence) + (" (violates a SHOULD)" if fault.soft else "")
                yield f"| `{fault.name}` | {told} | {_codes(fault.caught_by)} |"
    yield from ["", "## Unusual, but correct", "", "| server | what it does |", "|---|---|"]
    yield from (f"| `{server.name}` | {_text(server.sentence)} |" for server in unusual())


def _codes(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _title(text: str) -> str:
    return text[0].upper() + text[1:]


def _text(text: str) -> str:
    """Return a text in which no character has a meaning for Markdown."""
    return re.sub(r"([\\`*_<|{\[\]])", r"\\\1", text)


CASES = scripted_cases()
FAULTS = faults()

if __name__ == "__main__":
    shutil.rmtree(sys.argv[1], ignore_errors=True)
    write_pages(Path(sys.argv[1]))
