"""The worked example of CONTRIBUTING.md, and the code in docs: it exists, and runs as printed."""

import os
import re
import shlex
import shutil
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
    "if request.toggle": "conformance/sdo/oracle/segmented_upload.py",
    "require(response.toggle": "conformance/sdo/oracle/segmented_upload.py",
    '"segmented-upload.toggle served"': "tests/sdo/oracle/test_oracle_exchanges.py",
}
PAGE = "conformance/reporting/page"
USER = "conformance/plugin/run_description.py"


def blocks(text: str) -> list[str]:
    """Return the indented parts of a page, as they stand there."""
    found = re.findall(r"(?:^(?: {4}.*)?\n)+", text, re.MULTILINE)
    return [textwrap.dedent(each).strip("\n") for each in found if each.strip()]


def proof() -> list[list[str]]:
    """Return the words of the commands that prove a new case."""
    (listed,) = (each for each in blocks(GUIDE) if "detection.py --quick" in each)
    return [shlex.split(line, comments=True) for line in listed.splitlines()]


def takes_seconds(words: list[str]) -> bool:
    """Say of a command of the proof whether it takes seconds; the others take up to two hours."""
    return words[0] != "make" and "tests/faults/worth.py" not in words


@pytest.mark.parametrize("begins", EXAMPLES)
def test_the_example_stands_in_the_source_as_it_is_printed(begins: str) -> None:
    example = printed(begins)
    source = (ROOT / EXAMPLES[begins]).read_text(encoding="utf-8")
    assert any(f"\n{textwrap.indent(example, ' ' * deep)}\n" in source for deep in range(0, 16, 4))


@pytest.mark.parametrize("words", [*filter(takes_seconds, proof())], ids=" ".join)
def test_the_proof_of_the_example_holds(words: list[str], tmp_path: Path) -> None:
    program, *arguments = words
    command = [*([] if program == "python" else ["-m", program]), *arguments]
    reports = [f"--sdo-report-dir={tmp_path}"] if "--self-test" in words else []
    done = subprocess.run(  # noqa: S603 - it stands in the guide
        [sys.executable, *command, *reports], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_each_command_of_the_proof_names_what_there_is() -> None:
    named = [word for words in proof() for word in words if "/" in word]
    assert len(named) >= 5
    assert [word for word in named if not (ROOT / word).exists()] == []


def changed(copy: Path, *additions: tuple[str, str, str]) -> Path:
    """Copy the suite; return the copy, which has in each file the text added before another."""
    for name in ("conformance", "cases", "docs"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name, before, added in additions:
        path = copy / name
        text = path.read_text("utf-8")
        assert text.count(before) == 1
        path.write_text(text.replace(before, f"{added}\n{before}"), encoding="utf-8")
    return copy


def printed(begins: str) -> str:
    """Return the example of the guide that begins so."""
    (found,) = (each for each in blocks(GUIDE) if each.startswith(begins))
    return found


@pytest.fixture(scope="module")
def with_option(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of the suite in which two files have the option of the guide."""
    declared, used = printed("LABEL = "), printed('"label"')
    return changed(
        tmp_path_factory.mktemp("copy"),
        ("conformance/device/options.py", "# All above", f"{declared}\n"),
        (USER, "from conformance.device.options", "from conformance.device.options import LABEL"),
        (USER, '        "seed"', f"        {used}"),
    )


def python(copy: Path, *arguments: str) -> str:
    """Return what a program prints that imports the suite from a copy."""
    done = subprocess.run(  # noqa: S603 - it is our own
        [sys.executable, *arguments],
        cwd=copy,
        env=os.environ | {"PYTHONPATH": str(copy)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_an_option_takes_its_declaration_and_its_use(with_option: Path) -> None:
    test = ("-m", "pytest", "-q", "-p", "no:cacheprovider")
    helped = " ".join(python(with_option, *test, "--help").split())
    assert "--sdo-label=NAME a name for the run, such as the version of the firmware" in helped
    assert "sdo_label (string): as --sdo-label; also the environment variable CANOPEN_LA" in helped
    case = ("--self-test", "--sdo-label=2.1", "-k", "abort.own-multiplexer")
    python(with_option, *test, *case)
    (results,) = (with_option / "reports").glob("*/results.jsonl")
    assert '"label": "2.1"' in results.read_text("utf-8").splitlines()[0]


def test_device_toml_and_docs_follow_from_the_declaration(with_option: Path) -> None:
    (with_option / "drive.toml").write_text("label = '2.2'\n", encoding="utf-8")
    read = (
        "from pathlib import Path",
        "from conformance.device.description import read_description",
        "from conformance.device.options import LABEL",
        "print(read_description(Path('drive.toml'))[LABEL])",
    )
    assert python(with_option, "-c", ";".join(read)) == "2.2\n"
    python(with_option, "docs/option_tables.py")
    row = "| `--sdo-label=NAME` | `label` | a name for the run, such as the version of the"
    assert row in (with_option / "docs" / "options.md").read_text("utf-8")


def test_the_tables_in_docs_are_those_of_the_options(tmp_path: Path) -> None:
    for name in ("options.md", "device.md"):
        shutil.copy(ROOT / "docs" / name, tmp_path)
    python(ROOT, "docs/option_tables.py", str(tmp_path))
    for name in ("options.md", "device.md"):
        written = (ROOT / "docs" / name).read_text("utf-8")
        assert (tmp_path / name).read_text("utf-8") == written, "write them anew: make options"


def test_a_section_of_the_report_takes_its_values_and_its_place(tmp_path: Path) -> None:
    values = textwrap.indent(printed("@property\ndef to_add"), " " * 4)
    section, _, link = printed('<section id="to-add">').partition("\n\n")
    copy = changed(
        tmp_path,
        (f"{PAGE}/content.py", "    # Cases in groups\n", f"{values}\n"),
        (f"{PAGE}/report.html.jinja", '<section id="audit">', section),
        (f"{PAGE}/report.html.jinja", '<li><a href="#verdict">', link),
    )
    case = ("--self-test", "--sdo-simulated", "-k", "server-timeout and not segmented")
    python(copy, "-m", "pytest", "-q", "-p", "no:cacheprovider", *case)
    (page,) = (copy / "reports").glob("*/report.html")
    text = page.read_text("utf-8")
    assert re.search(r"<h2>To add</h2>\n<ul><li>server time-out: \d+</li></ul>", text)
    assert link in text


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
