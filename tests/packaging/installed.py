"""Use an installed suite as somebody does who has nothing else: from an empty folder.

    python tests/packaging/installed.py [OPTION...]

with the Python of the environment that has it; the options are further ones of pytest.
"""

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

SCRIPTS = Path(sysconfig.get_path("scripts"))
CHECKOUT = Path(__file__).parents[2]


def call(folder: Path, program: str, *arguments: str) -> str:
    """Run a program of this environment; return what it prints; it has to succeed."""
    mine = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    done = subprocess.run(  # noqa: S603 - these are our own commands
        (SCRIPTS / program, *arguments),
        cwd=folder,
        env={name: value for name, value in mine.items() if name != "PYTHONPATH"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"{program} {' '.join(arguments)}: {done.returncode}\n{done.stdout}")
    return done.stdout


def use(folder: Path, *options: str) -> str:
    """Go from the self-test to what its report says; return the summary of the run."""
    place = call(folder, "python", "-c", "import conformance; print(conformance.__file__)")
    if CHECKOUT / "conformance" in Path(place.strip()).parents:
        raise SystemExit(f"this is the checkout, not what is installed: {place}")
    printed = call(folder, "pytest", "--self-test", "-p", "no:cacheprovider", *options)
    (run,) = (folder / "reports").iterdir()
    whole = {path.name: path.read_bytes() for path in run.glob("*.*")}
    (run / "junit.xml").unlink()
    call(folder, "conformance", "report", str(run))
    for name in ("junit.xml", "causes.xml", "report.html", "results.jsonl", "bus.log"):
        if not whole.get(name) or not (run / name).is_file():
            raise SystemExit(f"{name} is missing or empty")
    if "download" not in call(folder, "conformance", "decode", str(run / "bus.log")):
        raise SystemExit("the frames of the run cannot be read")
    if "decode" not in call(folder, "conformance", "--help"):
        raise SystemExit("conformance --help does not list its commands")
    return printed.splitlines()[-1]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as empty:
        summary = use(Path(empty), *sys.argv[1:])
    version = call(Path.cwd(), "conformance", "--version").strip()
    print(f"{version} on Python {sys.version.partition(' ')[0]}: {summary}")
