"""The examples for CI: they fit their schemas, and their commands do what they are there for.

The commands run as they stand, with other programs in their PATH: one installs nothing, and the run
of the suite is a self-test with a faulty server, as if that were the device.
"""

import json
import os
import re
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples" / "ci"
SELF_TEST = "--self-test --sdo-simulated -k toggle --sdo-fault=upload-toggle-ignored"
# What stands for the programs of the machine, by name; each notes how it was called.
NOTED = '#!/bin/sh\nprintf "%s\\n" "$(basename "$0") $*" >> "$CALLS"\n'
PYTEST = NOTED + f'exec "{sys.executable}" -m pytest -p no:cacheprovider {SELF_TEST}\n'
PYTHON = NOTED + (
    'case "$1 $2" in\n'
    '"-m pytest") shift 2; exec pytest "$@";;\n'
    '"-m pip") exit 0;;\n'
    '"-m venv") mkdir -p "$3"; ln -sfn "$BIN" "$3/bin"; exit 0;;\n'
    f'*) exec "{sys.executable}" "$@";;\n'
    "esac\n"
)
PROGRAMS = {"pytest": PYTEST, "python": PYTHON, "python3": PYTHON} | dict.fromkeys(
    ("sudo", "make", "pip"), NOTED
)


class Machine:
    """A folder of a project, and what runs a step of a job there."""

    def __init__(self, folder: Path) -> None:
        self.project, self.calls = folder / "project", folder / "calls"
        self.bin = folder / "bin"
        for path in (self.project, self.bin):
            path.mkdir()
        for name, text in PROGRAMS.items():
            (self.bin / name).write_text(text, encoding="utf-8")
            (self.bin / name).chmod(0o755)

    def run(self, *command: str, **more: str) -> tuple[int, str]:
        """Run a command; return its exit status and what it prints."""
        mine = {name: os.environ[name] for name in os.environ if not name.startswith("PYTEST_")}
        path = {"PATH": f"{self.bin}{os.pathsep}{mine['PATH']}", "PYTHONPATH": str(ROOT)}
        notes = {"CALLS": str(self.calls), "BIN": str(self.bin)}
        done = subprocess.run(  # noqa: S603 - these are our own commands
            command,
            cwd=self.project,
            env=mine | path | notes | more,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout

    def shell(self, script: str, **more: str) -> tuple[int, str]:
        """Run a script as all of these services do: it ends with the first error."""
        return self.run("bash", "-eo", "pipefail", "-c", script, **more)

    def noted(self, program: str) -> list[str]:
        """Return the arguments of each call of a program."""
        lines = self.calls.read_text(encoding="utf-8").splitlines()
        return [line.partition(" ")[2] for line in lines if line.startswith(f"{program} ")]

    def failures(self, pattern: str) -> int:
        """Return how many test cases have failed in the only file that the pattern names."""
        (path,) = self.project.glob(pattern)
        assert path.stat().st_size < 30_000_000
        return len(list(ElementTree.parse(path).iter("failure")))  # noqa: S314 - it is ours


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def read(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("schema", "path"),
    [
        ("github-actions", "action.yml"),
        ("github-workflows", "examples/ci/github.yml"),
        ("github-workflows", ".github/workflows/check.yml"),
        ("gitlab-ci", "examples/ci/gitlab.yml"),
    ],
)
def test_a_file_fits_its_schema(schema: str, path: str) -> None:
    command = ("-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}", ROOT / path)
    done = subprocess.run(  # noqa: S603 - it is our own
        (sys.executable, *command), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_what_the_suite_itself_has_to_pass_is_there() -> None:
    jobs = read(ROOT / ".github" / "workflows" / "check.yml")["jobs"]
    commands = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    tox = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["tox"]
    targets = re.findall(r"^make (\w+)", "\n".join(commands), re.MULTILINE)
    assert targets == ["check", "installed"]
    for target in targets:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)
    pythons = jobs["installed"]["strategy"]["matrix"]["python"]
    assert pythons == [name for name in tox["env_list"] if name.startswith("3.")]
    (chosen,) = re.findall(r'TOX="-e (.*)"', "\n".join(commands))
    assert set(chosen.split(",")) <= set(tox["env"])


def known(options: str, pytester: pytest.Pytester) -> pytest.Config:
    """Return what pytest takes the options for; an unknown one raises UsageError."""
    return pytester.parseconfig(*options.split())


def test_a_job_of_github(machine: Machine, pytester: pytest.Pytester) -> None:
    (job,) = read(EXAMPLES / "github.yml")["jobs"].values()
    for step in job["steps"]:
        if "run" in step:
            status, printed = machine.shell(step["run"])
            assert status == 0, printed
    assert machine.noted("sudo")[-2:] == [
        "ip link add dev vcan0 type vcan",
        "ip link set dev vcan0 up",
    ]
    (inputs,) = (step["with"] for step in job["steps"] if step.get("uses", "").startswith("./"))
    act(machine, inputs["options"])
    (called,) = machine.noted("pytest")
    assert called.endswith("--can-channel=vcan0 --sdo-process=./my_server vcan0")
    assert known(inputs["options"].rpartition(" --sdo-process")[0], pytester).option.can_channel


def act(machine: Machine, options: str) -> None:
    """Run our own action as a job does, and look at what comes of a device that fails."""
    action = read(ROOT / "action.yml")
    inputs = {name: each.get("default", "") for name, each in action["inputs"].items()}
    inputs["options"] = options
    printed = {}
    for step in action["runs"]["steps"]:
        if "run" not in step:
            assert step["if"] == "always()"
            assert step["with"]["path"] == "${{ inputs.report-dir }}"
            continue
        values = {
            name: re.sub(r"\$\{\{ inputs\.(\S+) }}", lambda found: inputs[found[1]], value)
            for name, value in step.get("env", {}).items()
        }
        if step["shell"] == "python":
            assert step["if"] == "always()"
            done = machine.run(sys.executable, "-c", step["run"], **values)
        else:
            done = machine.shell(step["run"], GITHUB_ACTION_PATH="/suite", **values)
        printed[step["name"]] = done
    assert "-m pip install --quiet /suite" in machine.noted("python")
    assert printed["Test"][0] == 1, printed["Test"][1]
    status, annotations = printed["Annotate"]
    lines = annotations.splitlines()
    assert status == 0
    assert len(lines) == machine.failures("reports/*/causes.xml") > 0
    (toggle,) = (line for line in lines if "title=segmented-upload.toggle::" in line)
    assert toggle.startswith("::error title=segmented-upload.toggle::MUST, CiA 301 clause 7.2.4")
    assert "%0A" in toggle


def test_a_job_of_gitlab(machine: Machine, pytester: pytest.Pytester) -> None:
    job = read(EXAMPLES / "gitlab.yml")["conformance"]
    status, printed = machine.shell("\n".join(job["script"]))
    assert status == 1, printed
    assert machine.noted("pip") == ["install ./canopen-sdo-conformance"]
    (options,) = machine.noted("pytest")
    assert known(options, pytester).option.sdo_device
    kept = job["artifacts"]
    assert kept["when"] == "always"
    assert kept["paths"] == ["reports/"]
    assert machine.failures(kept["reports"]["junit"]) > 0


def test_a_stage_of_jenkins(machine: Machine, pytester: pytest.Pytester) -> None:
    pipeline = (EXAMPLES / "Jenkinsfile").read_text(encoding="utf-8")
    assert pipeline.count("{") == pipeline.count("}")
    (script,) = re.findall(r"sh '''\n(.*?)'''", pipeline, re.DOTALL)
    status, printed = machine.shell(textwrap.dedent(script))
    assert status == 1, printed
    assert machine.noted("pip") == ["install ./canopen-sdo-conformance"]
    (options,) = machine.noted("pytest")
    assert known(options, pytester).option.sdo_device
    (pattern,) = re.findall(r"junit '(.*)'", pipeline)
    assert machine.failures(pattern) > 0


def test_a_container(machine: Machine) -> None:
    """There is no engine here: each instruction does what it would, outside of a container."""
    text = (EXAMPLES / "Dockerfile").read_text(encoding="utf-8")
    lines = [line.split(" ", 1) for line in text.splitlines() if not line.startswith("#")]
    said = dict(lines)
    assert [name for name, _ in lines] == ["FROM", "COPY", "RUN", "WORKDIR", "ENTRYPOINT"]
    python = re.fullmatch(r"python:(\d\.\d+)-slim", said["FROM"])
    assert python
    assert python[1] in (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert said["COPY"] == "dist/*.whl /tmp/"
    assert "--outdir dist" in (ROOT / "Makefile").read_text(encoding="utf-8")
    (machine.project / "suite.whl").touch()
    status, printed = machine.shell(said["RUN"].replace("/tmp/", "./"))  # noqa: S108
    assert status == 0, printed
    assert machine.noted("pip") == ["install --no-cache-dir ./suite.whl"]
    (documented,) = re.findall(rf"docker run .*:{said['WORKDIR']}\" \S+ (.*)", text)
    status, printed = machine.run(*json.loads(said["ENTRYPOINT"]), documented)
    assert status == 1, printed
    assert machine.noted("pytest") == ["-p no:cacheprovider --node-id=5"]
