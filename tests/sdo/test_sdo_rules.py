"""The registry of rules: what each of them says, and how it is found."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import conformance.sdo.rules as exported
from conformance.sdo.rules import CHAPTERS, RULES, Level, Rule, UnknownRule, rule_of


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.id)
def test_a_rule_says_what_reports_need(rule: Rule) -> None:
    assert re.fullmatch(r"[a-z-]+\.[a-z0-9-]+", rule.id)
    assert re.fullmatch(r"7(\.\d+)+((, 7(\.\d+)+)* and 7(\.\d+)+)?|CiA 306-1", rule.clause)
    assert re.fullmatch(r"([A-Z0-9]|n |pst |ackseq ).{10,98}\.", rule.sentence)
    assert not rule.untestable or rule.untestable.endswith(".")
    assert "abort" in rule.reaction or not rule.codes
    assert len(set(rule.codes)) == len(rule.codes)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.id)
def test_what_must_be_refused_has_its_codes(rule: Rule) -> None:
    due = rule.level is Level.MUST and rule.reaction.startswith("abort")
    assert rule.codes or not due


@pytest.mark.parametrize(
    ("name", "clause"),
    [
        ("dictionary.identity", "7.5.2.21"),
        ("object.constant", "7.4.5"),
        ("data.boolean", "7.1.4.3"),
        ("data.unicode", "7.1.6"),
        ("data.variable-length", "7.1.6"),
        ("object.no-data", "7.5.2.4"),
        ("server.new-initiate-served", "7.2.4.3.2"),
        ("segmented-download.new-initiate", "7.2.4.3.2"),
        ("segmented-upload.new-initiate", "7.2.4.3.5"),
        ("channel.request-identifier", "7.3.3"),
        ("channel.restricted-identifier", "7.3.5"),
        ("block-upload.no-switch", "7.2.4.3.5 and 7.2.4.3.13"),
        ("data.type-length", "7.1.4"),
        ("block.size", "7.2.4.3.9, 7.2.4.3.10, 7.2.4.3.13 and 7.2.4.3.14"),
        ("upload.ends", "7.2.4.3.7 and 7.2.4.3.14"),
        ("communication.mapped-object", "7.5.2.36 and 7.5.2.38"),
        ("communication.transmission-type", "7.5.2.35 and 7.5.2.37"),
        ("communication.storage-capability", "7.5.2.13 and 7.5.2.14"),
    ],
)
def test_the_clause_is_the_one_that_asks_for_it(name: str, clause: str) -> None:
    """Clauses of CiA 301 v4.2 that are easily taken for their neighbours."""
    assert rule_of(name).clause == clause


def test_a_rule_is_found_by_its_id() -> None:
    assert all(rule_of(rule.id) is rule for rule in RULES)


def test_ids_and_sentences_are_unique() -> None:
    assert len({rule.id for rule in RULES}) == len(RULES)
    assert len({rule.sentence for rule in RULES}) == len(RULES)
    assert len({chapter.title for chapter in CHAPTERS}) == len(CHAPTERS)


@pytest.mark.parametrize(
    ("name", "nearest"),
    [("upload.sizes", "upload.size"), ("segmented-download.togle", "segmented-download.toggle")],
)
def test_an_unknown_rule_is_answered_with_the_nearest(name: str, nearest: str) -> None:
    with pytest.raises(UnknownRule, match=f"'{name}'; the nearest is '{nearest}"):
        rule_of(name)


def test_what_the_package_exports_is_in_the_registry() -> None:
    exports = [value for value in vars(exported).values() if isinstance(value, Rule)]
    assert len(exports) > 20
    assert all(rule_of(rule.id) is rule for rule in exports)


PACKAGE = Path(exported.__file__).parents[2]


def test_what_can_be_broken_is_in_the_registry() -> None:
    """Elsewhere a rule gets an id only to name the part of a run that is no case."""
    built = [
        (path.name, call.args[2])
        for path in PACKAGE.rglob("*.py")
        if "rules" not in path.parts
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call) and ast.unparse(call.func) == "Rule"
        if call.args and isinstance(call.args[0], ast.Constant)
    ]
    assert built
    for name, level in built:
        assert ast.unparse(level) == "Level.MAY", f"{name}: add the rule to the registry"


PROTOCOL = tuple(
    f"conformance.sdo.{name}"
    for name in (
        *("rules", "abort_codes", "frames", "layout"),
        *("can_frame", "describe", "kinds", "seen"),  # the words for what came
    )
)


def test_importing_the_rules_brings_in_nothing_but_the_protocol() -> None:
    command = (
        "import sys; before = set(sys.modules); import conformance.sdo.rules; "
        "print(*sorted(set(sys.modules) - before - set(sys.stdlib_module_names)))"
    )
    output = subprocess.run(  # noqa: S603
        [sys.executable, "-c", command], check=True, capture_output=True, text=True
    ).stdout
    third = [
        name
        for name in output.split()
        if name.partition(".")[0] not in sys.stdlib_module_names and not name.startswith(PROTOCOL)
    ]
    assert third == ["conformance", "conformance.sdo"]
