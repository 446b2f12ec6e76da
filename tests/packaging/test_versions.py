"""The versions that pyproject.toml names: of Python and of the dependencies."""

import re
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT, TOX = SETTINGS["project"], SETTINGS["tool"]["tox"]


def lower_ends(requirements: list[str]) -> dict[str, tuple[int, ...]]:
    """Return the version after ">=" or "==" of each package; 2.13 and 2.13.0 are the same."""
    found = {}
    for requirement in requirements:
        name, _, version = requirement.replace("==", ">=").partition(">=")
        numbers = [int(part) for part in version.split(".")]
        found[name] = (*numbers, 0, 0)[:3]
    return found


def test_the_lower_ends_are_those_that_are_tested() -> None:
    oldest = lower_ends(TOX["env"]["oldest"]["deps"])
    workers = {"pytest-xdist": oldest.pop("pytest-xdist")}
    assert oldest == lower_ends(PROJECT["dependencies"])
    assert workers.items() <= lower_ends(PROJECT["optional-dependencies"]["beside"]).items()
    beside = lower_ends(TOX["env"]["beside-oldest"]["deps"])
    del beside["pytest"]
    assert beside == lower_ends(PROJECT["optional-dependencies"]["beside"])


def test_each_python_that_is_named_is_tested() -> None:
    start = "Programming Language :: Python :: 3."
    named = [line.rpartition(" ")[2] for line in PROJECT["classifiers"] if line.startswith(start)]
    assert named == [name for name in TOX["env_list"] if name.startswith("3.")]
    assert PROJECT["requires-python"] == f">={named[0]}"


def test_an_archive_of_a_commit_says_which() -> None:
    """Services hand out repositories so, without the history that the version comes from."""
    command = ("git", "archive", "HEAD", ".git_archival.txt")
    done = subprocess.run(command, cwd=ROOT, capture_output=True, check=True)  # noqa: S603
    assert re.search(rb"node: [0-9a-f]{40}\n", done.stdout)
    assert b"$Format" not in done.stdout
