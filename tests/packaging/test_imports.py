"""What a program imports is most of what it takes to start."""

import subprocess
import sys
from pathlib import Path

ONE_CASE = ("--self-test", "-k", "abort.own-multiplexer")


def imported(program: str, names: str, *arguments: str) -> list[str]:
    """Return which of the modules with these names a program has imported in the end."""
    program += f"; print(*[name for name in {names.split()} if name in sys.modules])"
    done = subprocess.run(  # noqa: S603 - it is our own
        [sys.executable, "-c", program, *arguments], capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()[-1].split()


def test_a_server_does_without_pytest() -> None:
    program = "import sys, conformance.__main__, conformance.commands.serve"
    assert imported(program, "can pytest jinja2 hypothesis") == ["can"]


def test_a_case_that_draws_nothing_does_without_hypothesis(tmp_path: Path) -> None:
    program = "import sys, pytest; assert pytest.main(sys.argv[1:]) == 0"
    quiet = ("-q", "-p", "no:hypothesispytest", "-p", "no:cacheprovider")
    given = (*quiet, f"--sdo-report-dir={tmp_path}", *ONE_CASE)
    assert imported(program, "pytest hypothesis", *given) == ["pytest"]
