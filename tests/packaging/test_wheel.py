"""The wheel: what is in it, and that it tests a device from any folder without the checkout.

It is built from the sdist, as package indexes do, which shows that nothing is missing there.
"""

import os
import re
import subprocess
import sys
import tomllib
import venv
from collections.abc import Sequence
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[2]
CASES = ROOT / "cases"


def call(command: Sequence[str | Path], folder: Path) -> str:
    """Run a program as from a shell of its own, and return what it prints; it has to succeed."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PYTEST_", "PYTHON", "COV_", "VIRTUAL_ENV"))
    }
    done = subprocess.run(  # noqa: S603 - these are our own commands
        command,
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    call((sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, ROOT), folder)
    assert len(list(folder.glob("*.tar.gz"))) == 1
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def names(wheel: Path) -> list[str]:
    with ZipFile(wheel) as archive:
        return archive.namelist()


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the scripts folder of an environment with the wheel; it borrows the dependencies.

    A path file is enough for that: it does not follow those in the folders that it names, so that
    the checkout, which is installed there in editable form, stays out of sight.
    """
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, symlinks=os.name != "nt")
    scripts = home / ("Scripts" if os.name == "nt" else "bin")
    python = scripts / "python"
    pip = (sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check")
    call((*pip, "install", "--quiet", "--no-index", "--no-deps", wheel), home)
    own = call((python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"), home)
    borrowed = [path for path in sys.path if path.endswith(("site-packages", "dist-packages"))]
    Path(own.strip(), "borrowed.pth").write_text("\n".join(borrowed), encoding="utf-8")
    return scripts


@pytest.fixture
def empty(tmp_path: Path) -> Path:
    return tmp_path


def test_the_cases_are_in_the_wheel(names: list[str]) -> None:
    expected = {f"conformance/cases/{path.name}" for path in CASES.glob("*.py")}
    assert expected
    assert {name for name in names if name.startswith("conformance/cases/")} == expected


def test_the_package_is_complete_and_typed(names: list[str]) -> None:
    package = ROOT / "conformance"
    expected = {path.relative_to(ROOT).as_posix() for path in package.rglob("*.py")}
    assert expected <= set(names)
    assert "conformance/py.typed" in names


def test_nothing_else_is_in_the_wheel(names: list[str]) -> None:
    """Neither the suite's own tests nor reports, caches or a second copy of the cases."""
    assert {name.partition("/")[0].partition("-")[0] for name in names} == {
        "conformance",
        "canopen_sdo_conformance",
    }
    assert not [name for name in names if "/tests/" in name or "__pycache__" in name]
    assert len(set(names)) == len(names)
    suffixes = {Path(name).suffix for name in names if name.startswith("conformance/")}
    assert suffixes == {".py", ".typed", ".json", ".jinja", ".css", ".js"}
    assert [name for name in names if name.endswith(".json")] == [
        "conformance/plugin/case_order.json",
        "conformance/reporting/workload.json",
    ]


def read(wheel: Path, name: str) -> str:
    with ZipFile(wheel) as archive:
        (path,) = (path for path in archive.namelist() if path.endswith(f".dist-info/{name}"))
        return archive.read(path).decode("utf-8")


def test_what_the_wheel_says_of_itself(wheel: Path) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    metadata = read(wheel, "METADATA").splitlines()
    needed = [line.partition(": ")[2] for line in metadata if line.startswith("Requires-Dist")]
    assert sorted(line for line in needed if "extra ==" not in line) == sorted(
        project["dependencies"]
    )
    assert f"Requires-Python: {project['requires-python']}" in metadata
    assert "License-Expression: MIT" in metadata
    assert "conformance = conformance.plugin.hooks" in read(wheel, "entry_points.txt")
    assert read(wheel, "licenses/LICENSE") == (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_the_version_is_that_of_the_last_tag_or_comes_before_the_first(wheel: Path) -> None:
    (line,) = (line for line in read(wheel, "METADATA").splitlines() if line.startswith("Version"))
    assert re.fullmatch(r"Version: \d+\.\d+\.\d+(\.dev\d+)?", line)


def test_no_link_of_the_description_leads_into_the_repository(wheel: Path) -> None:
    """A package index shows it elsewhere, so only whole addresses and its own headings are good."""
    description = read(wheel, "METADATA").partition("\n\n")[2]
    assert description.startswith("# CANopen SDO conformance suite\n")
    targets = re.findall(r"\]\(([^)]*)\)", description)
    headings = re.findall(r"^#+ (.*)$", description, re.MULTILINE)
    for target in targets:
        if target.startswith("#"):
            assert target[1:] in {name.lower().replace(" ", "-") for name in headings}
        else:
            assert target.startswith("https://")
    assert "First run goes on from here." in description


def test_the_self_test_of_the_installed_wheel(installed: Path, empty: Path) -> None:
    """From an empty folder, and with the cases that came with the wheel."""
    files = "test_abort or test_segmented_upload or test_specifiers"
    chosen = ("--sdo-fault=no-block-transfer", "-k", files, "-v", "-rs", "-p", "no:cacheprovider")
    printed = call((installed / "python", "-m", "pytest", "--self-test", *chosen), empty)
    assert "cases/test_abort.py::abort.frame PASSED" in printed
    assert "cases/test_segmented_upload.py::segmented-upload.toggle-first PASSED" in printed
    assert str(ROOT) not in printed.replace(str(empty), "")
    skipped = [line for line in printed.splitlines() if line.startswith("SKIPPED")]
    assert skipped
    for line in skipped:
        assert "site-packages/conformance/cases/test_" in line.replace(os.sep, "/")
    (report,) = (empty / "reports").iterdir()
    assert (report / "junit.xml").is_file()


def test_the_ids_are_the_same_as_in_the_checkout(installed: Path, empty: Path) -> None:
    listing = ("-m", "pytest", "--self-test", "--collect-only", "-q", "-p", "no:cacheprovider")
    here = call((sys.executable, *listing), empty)
    there = call((installed / "python", *listing), empty)

    def ids(printed: str) -> list[str]:
        return [line for line in printed.splitlines() if line.startswith("cases/")]

    assert ids(there) == ids(here)
    assert len(ids(there)) > 400


def test_the_command_of_the_installed_wheel(installed: Path, empty: Path) -> None:
    listed = call((installed / "conformance", "faults"), empty)
    assert "  answers-late " in listed


def test_own_tests_with_the_installed_wheel(installed: Path, empty: Path) -> None:
    """A user's file may have the name of one of the suite's own."""
    own = "def test_mine(sdo):\n    assert sdo.fence() == []\n"
    (empty / "test_abort.py").write_text(own, encoding="utf-8")
    command = (installed / "python", "-m", "pytest", "--self-test", "-p", "no:cacheprovider")
    assert "1 passed" in call((*command, "test_abort.py"), empty)
    printed = call((*command, "-v", "-k", "test_abort"), empty)
    assert "cases/test_abort.py::abort.frame PASSED" in printed
