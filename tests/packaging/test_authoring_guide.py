"""The worked example of CONTRIBUTING.md, and the code in docs: it exists, and runs as printed."""

import re
import shlex
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
EXAMPLES = {
    "TOGGLE = Rule(": "conformance/sdo/rules/segmented_upload.py",
    '@must("segmented-upload.toggle-first"': "cases/test_segmented_upload.py",
    "@fault(": "conformance/faults/faulty/segmented_upload.py",
}


def blocks(text: str) -> list[str]:
    """Return the indented parts of a page, as they stand there."""
    found = re.findall(r"(?:^(?: {4}.*)?\n)+", text, re.MULTILINE)
    return [textwrap.dedent(each).strip("\n") for each in found if each.strip()]


def proof() -> list[list[str]]:
    """Return the words of the commands that prove a new case."""
    (listed,) = (each for each in blocks(GUIDE) if "detection.py --quick" in each)
    return [shlex.split(line, comments=True) for line in listed.splitlines()]


@pytest.mark.parametrize("begins", EXAMPLES)
def test_the_example_stands_in_the_source_as_it_is_printed(begins: str) -> None:
    (printed,) = (each for each in blocks(GUIDE) if each.startswith(begins))
    source = (ROOT / EXAMPLES[begins]).read_text(encoding="utf-8")
    assert f"\n{printed}\n" in source


@pytest.mark.parametrize("number", [0, 1])
def test_the_proof_of_the_example_holds(number: int, tmp_path: Path) -> None:
    program, *arguments = proof()[number]
    command = [*([] if program == "python" else ["-m", program]), *arguments]
    reports = [] if program == "python" else [f"--sdo-report-dir={tmp_path}"]
    done = subprocess.run(  # noqa: S603 - it stands in the guide
        [sys.executable, *command, *reports], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_each_command_of_the_proof_names_what_there_is() -> None:
    named = [word for words in proof() for word in words if "/" in word]
    assert len(named) >= 5
    assert [word for word in named if not (ROOT / word).exists()] == []


@pytest.mark.parametrize("page", ["own-tests.md"])
def test_the_tests_in_docs_pass_on_the_built_in_device(
    pytester: pytest.Pytester, page: str
) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    code = [each for each in blocks(text) if each.startswith("from conformance import")]
    assert code
    body = code[0].partition("\n\npytest ")[0]
    pytester.makepyfile(test_mine=body)
    result = pytester.runpytest("--self-test", "--sdo-simulated", "test_mine.py")
    result.assert_outcomes(passed=body.count("def test_"))
