"""The commands in the README and in docs: what needs no hardware is run, all have known options.

They run in an empty folder, as those of someone who has just installed the suite.
"""

import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path

import pytest

from conformance.__main__ import command_line
from conformance.device.description import read_description
from conformance.device.options import ALLOW, LARGE, NEVER, WRITABLE
from conformance.sdo.layout import Multiplexer

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
# Stands for drive.eds.
EDS = ROOT / "tests" / "fleet" / "servers" / "device.eds"
PROMPT = re.compile(r"^\w+\$ ")


def commands(pages: Sequence[Path]) -> list[list[str]]:
    """Return the words of each command, those of a pipe one by one; a # begins a comment."""
    found: list[list[str]] = []
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages).replace("\\\n", " ")
    for line in re.findall(r"^ {4}(\S.*)$", text, re.MULTILINE):
        try:
            words = shlex.split(PROMPT.sub("", line), comments=True)
        except ValueError:  # a line of another language
            continue
        if not words:
            continue
        pipe = words.index("|") if "|" in words else len(words)
        parts = (words[:pipe], words[pipe + 1 :])
        found += [part for part in parts if part and part not in found]
    return found


def of(program: str, pages: Sequence[Path] = PAGES) -> list[list[str]]:
    """Return the arguments of each command of a program; what is optional is taken as given."""
    return [
        [word if "[" in word[1:] else word.strip("[]") for word in words[1:]]
        for words in commands(pages)
        if words[0] == program
    ]


SELF_TESTS = [words for words in of("pytest") if "--self-test" in words]
SERVED = [words for words in of("conformance") if "udp_multicast" in words]
# Those that read or list something: what they need is a report folder. Of a right EDS there is
# nothing to say; tests/commands has others.
READING = [
    words
    for words in of("conformance")
    if words[0] not in ("serve", "replay", "restore", "eds")
    and not (words[0] == "init" and "--node-id" in words)
    and not any(word == "-" or word.startswith("--can-channel") for word in words)
]


def test_the_commands_are_found() -> None:
    assert len(of("pytest")) > 20
    assert len(SELF_TESTS) == 3
    assert len(SERVED) == 1
    assert {words[0] for words in READING} == {
        "compare", "decode", "faults", "init", "overview", "report", "rules",
    }  # fmt: skip


@pytest.mark.parametrize("words", of("conformance"), ids=" ".join)
def test_a_command_has_these_options(words: list[str]) -> None:
    assert command_line().parse_args(words).run


@pytest.mark.parametrize("words", of("pytest"), ids=" ".join)
def test_pytest_has_these_options(words: list[str], pytester: pytest.Pytester) -> None:
    """Neither files nor devices are looked for; an unknown option raises UsageError."""
    options = pytester.parseconfig(*words).option
    assert options.node_id or options.self_test or options.sdo_device


def test_the_pictures_are_there_and_small() -> None:
    pictures = [
        page.parent / picture
        for page in PAGES
        for picture in re.findall(r"!\[[^]]+\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    ]
    assert pictures
    for picture in pictures:
        data = picture.read_bytes()
        assert data.startswith(b"\x89PNG")
        assert len(data) < 200_000


def test_the_described_device_can_be_read(tmp_path: Path) -> None:
    """The example of a device.toml that opens its page."""
    text = (ROOT / "docs" / "device.md").read_text(encoding="utf-8")
    example = text[text.index("    node-id") : text.index("\nAll of it is optional")]
    path = tmp_path / "drive.toml"
    path.write_text(textwrap.dedent(example), encoding="utf-8")
    described = read_description(path)
    assert len(described[WRITABLE]) == 3
    assert described[LARGE] is not None
    assert Multiplexer(0x2100, 0) in described[NEVER]
    assert described[ALLOW] == ("nmt",)


def test_make_knows_its_targets() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    pages = [*PAGES, ROOT / "CONTRIBUTING.md"]
    targets = [word for words in of("make", pages) for word in words if "=" not in word]
    assert targets
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def started(folder: Path, words: Sequence[str]) -> subprocess.Popen[str]:
    """Start a program of this Python, as from a shell of its own."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PYTEST_", "COV_")) and name != "COLUMNS"
    }
    return subprocess.Popen(  # noqa: S603 - it is our own
        [sys.executable, "-m", *words],
        cwd=folder,
        env=environment | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def run(folder: Path, *words: str) -> tuple[int, str]:
    """Run a command to its end; return its exit status and what it prints."""
    with started(folder, words) as process:
        text, _ = process.communicate(timeout=300)
    return process.returncode, text


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder in which the self-tests have run, with few cases where these may do."""
    folder = tmp_path_factory.mktemp("reader")
    for words in SELF_TESTS:
        guarded = any("@" in word for word in words)
        status, text = run(folder, "pytest", *words, *([] if guarded else ["--sdo-quick"]))
        assert status == any(word.startswith("--sdo-fault") for word in words), text
        assert "= conformance =" in text
    last = max((folder / "reports").glob("*-node-5"))
    for name in ("RUN", "OLD", "NEW"):
        shutil.copytree(last, folder / "reports" / name)
    shutil.copy(EDS, folder / "drive.eds")
    return folder


# Found in the log of a faulty server.
WRONG = {"--judge": 3}


@pytest.mark.parametrize("words", READING, ids=" ".join)
def test_a_command_without_hardware(words: list[str], reports: Path) -> None:
    status, text = run(reports, "conformance", *words)
    assert status == next((WRONG[word] for word in words if word in WRONG), 0), text
    assert len(text.splitlines()) > 1


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        port: int = found.getsockname()[1]
    return port


def test_a_server_and_a_run_beside_it(tmp_path: Path) -> None:
    """On a port of their own: other tests on this machine may use the same bus."""
    port = f"--can-option=port={free_port()}"
    (serve,) = SERVED
    (test,) = (words for words in of("pytest") if any("udp_multicast" in word for word in words))
    with started(tmp_path, ["conformance", *serve, port]) as server:
        try:
            assert server.stdout is not None
            assert server.stdout.readline().startswith("serving node 5 on udp_multicast")
            status, text = run(tmp_path, "pytest", *test, port, "--sdo-quick")
        finally:
            server.send_signal(signal.SIGTERM)
    assert status == 0, text
    assert re.search(r"^\d+ pass, ", text, re.MULTILINE)
