"""One run of the suite against a foreign server, over SocketCAN or what stands in for it."""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fleet_servers import ForeignServer, Unavailable

ROOT = Path(__file__).parents[2]
STAND_IN = Path(__file__).with_name("vcan")
CHANNEL = "vcan0"
LARGE = "2020"
DEVICE = """\
node-id = 5
eds = "../device.eds"
[objects]
writable = "all-rw"
"""
# What runs of earlier versions or other places set up must not reach this one.
UNWANTED = ("PYTEST_ADDOPTS", "PYTEST_PLUGINS")


@dataclass(frozen=True, slots=True)
class Bus:
    """A CAN interface, and what a program needs in its environment to use it."""

    channel: str
    environment: Mapping[str, str]


@contextmanager
def stand_in(folder: Path) -> Iterator[Bus]:
    """Run a bus that takes no kernel; ``folder`` is for what is built for it."""
    if shutil.which("cc") is None:
        raise Unavailable("the stand-in for SocketCAN needs a C compiler, cc")
    folder.mkdir(parents=True, exist_ok=True)
    library, hub = folder / "fakecan.so", folder / "hub"
    shared = ("-shared", "-fPIC", "-ldl")
    for source, target, options in (("fakecan.c", library, shared), ("hub.c", hub, ())):
        # Another run may be using what stands there.
        built = target.with_name(f"{target.name}.{os.getpid()}")
        command = ["cc", "-O2", "-o", str(built), str(STAND_IN / source), *options]
        subprocess.run(command, check=True)  # noqa: S603 - it is our own
        built.replace(target)
    # The name of a socket may not be long, so it is not in the folder.
    with tempfile.TemporaryDirectory() as short:
        socket = Path(short, "bus")
        with subprocess.Popen([hub, socket], stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
            try:
                assert process.stdout is not None
                process.stdout.readline()
                preloaded = {"FAKECAN": str(socket), "LD_PRELOAD": str(library)}
                yield Bus(CHANNEL, preloaded)
            finally:
                process.terminate()


@contextmanager
def socketcan(channel: str) -> Iterator[Bus]:
    """Use an interface that the kernel has."""
    if not Path("/sys/class/net", channel).exists():
        raise Unavailable(f"this machine has no CAN interface {channel}")
    yield Bus(channel, {})


@dataclass(frozen=True, slots=True)
class Run:
    """A run that has ended: how, in how many seconds, and where its reports are."""

    status: int
    seconds: float
    folder: Path

    @property
    def junit(self) -> Path:
        """Return the results."""
        return self.folder / "junit.xml"


def run_suite(server: ForeignServer, built: Path, bus: Bus, options: Sequence[str]) -> Run:
    """Run the suite against a server that was built in a folder."""
    folder = built / "run"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    large = "" if LARGE in server.without else f'large = "{LARGE}"\n'
    seconds = server.server_timeout
    timing = "" if seconds is None else f"[timing]\nserver-timeout = {seconds}\n"
    (folder / "device.toml").write_text(DEVICE + large + timing)
    # Keeps pytest from taking the configuration of this project for that of the run.
    (folder / "pytest.ini").write_text("[pytest]\n")
    program = [str(built / word) if (built / word).exists() else word for word in server.start]
    command = [
        *(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"),
        *("--sdo-device=device.toml", "--can-interface=socketcan", f"--can-channel={bus.channel}"),
        *("--sdo-report-dir=reports", "--junitxml=junit.xml"),
        f"--sdo-process={shlex.join([*program, bus.channel])}",
        *options,
    ]
    kept = {name: value for name, value in os.environ.items() if name not in UNWANTED}
    python = os.pathsep.join(filter(None, (str(ROOT), kept.get("PYTHONPATH"))))
    own = {"DEVICE_EDS": str(built / "device.eds"), "PYTHONPATH": python}
    began = time.monotonic()
    with (folder / "output.txt").open("w") as output:
        done = subprocess.run(  # noqa: S603 - it is our own
            command,
            cwd=folder,
            env=kept | own | dict(bus.environment),
            stdout=output,
            stderr=subprocess.STDOUT,
            check=False,
        )
    return Run(done.returncode, time.monotonic() - began, folder)
