"""The foreign servers of the fleet: what each is, how it is built, and what is wrong with it.

Each has a folder in ``servers`` with a small program around it and a ``server.toml``:

- ``title`` names package and version, ``needs`` the programs that building and running take;
- ``build`` lists commands and ``start`` is one; they run in a folder outside the tracked files,
  and ``start`` is given the name of a CAN interface;
- ``server-timeout`` are the seconds after which it gives up a transfer, where it does that;
- the device has the objects of ``device.eds`` but for ``eds-without``, and with the texts of
  ``eds-replaced`` changed;
- ``causes`` are the defects that the suite finds, each judged by hand: ``cause`` as the run prints
  it, * for what varies; ``why`` it is a defect; ``frames`` that show it, sent (>) and received (<);
  ``now-and-then`` of one that only a certain moment or random conversation shows.
"""

import hashlib
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from configparser import ConfigParser
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

SERVERS = Path(__file__).with_name("servers")
DEVICE_EDS = SERVERS / "device.eds"
LISTS = ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects")
PROGRAM_FILES = ("server.toml", "__pycache__")


class Unavailable(Exception):
    """A server cannot be had on this machine; the text says what is missing."""


@dataclass(frozen=True, slots=True)
class ExpectedCause:
    """A defect of a server that the suite finds, judged by hand.

    ``lacking``: it is a service that CiA 301 leaves to the server and that this one does not have,
    so that the cases which need it cannot reach their point. A service that is there and refuses
    what it has to take is no such thing. ``now_and_then``: a run need not meet it, as it takes a
    certain moment or a certain random conversation.
    """

    cause: str
    why: str
    frames: tuple[str, ...]
    lacking: bool = False
    now_and_then: bool = False

    def covers(self, cause: str) -> bool:
        """Return whether a run that names this cause has found this defect."""
        return fnmatchcase(cause, self.cause)


@dataclass(frozen=True, slots=True)
class ForeignServer:
    """A server that others wrote, with the program of ours around it."""

    name: str
    title: str
    needs: tuple[str, ...]
    build: tuple[tuple[str, ...], ...]
    start: tuple[str, ...]
    without: tuple[str, ...]
    replaced: Mapping[str, str]
    causes: tuple[ExpectedCause, ...]
    server_timeout: float | None = None

    def missing(self) -> list[str]:
        """Return the programs that this machine lacks."""
        return [program for program in self.needs if shutil.which(program) is None]

    def prepare(self, folder: Path) -> None:
        """Build the server in a folder, where it is started, unless that has been done."""
        if missing := self.missing():
            raise Unavailable(f"needs {' and '.join(missing)}")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "device.eds").write_text(self.eds(DEVICE_EDS.read_text()))
        stamp, digest = folder / "built", self._digest()
        if stamp.exists() and stamp.read_text() == digest:
            return
        copied = shutil.ignore_patterns(*PROGRAM_FILES)
        shutil.copytree(SERVERS / self.name, folder, ignore=copied, dirs_exist_ok=True)
        for command in self.build:
            filled = [sys.executable if word == "{python}" else word for word in command]
            if subprocess.run(filled, cwd=folder, check=False).returncode:  # noqa: S603 - our own
                raise Unavailable(f"could not be built: {' '.join(command)}")
        stamp.write_text(digest)

    def _digest(self) -> str:
        """Return what is another text when the server has to be built anew."""
        digest = hashlib.sha256(repr(self.build).encode())
        for path in sorted((SERVERS / self.name).rglob("*")):
            if path.is_file() and path.name not in PROGRAM_FILES:
                digest.update(path.read_bytes())
        return digest.hexdigest()

    def eds(self, common: str) -> str:
        """Return the EDS of this server, from the one that all have in common."""
        for old, new in self.replaced.items():
            common = common.replace(old, new)
        parser = ConfigParser(interpolation=None)
        parser.optionxform = str  # type: ignore[assignment, method-assign]
        parser.read_string(common)
        for section in parser.sections():
            if section.partition("sub")[0] in self.without:
                parser.remove_section(section)
        for section in LISTS:
            indices = [value for key, value in parser[section].items() if key != "SupportedObjects"]
            kept = [index for index in indices if index.removeprefix("0x") not in self.without]
            parser[section] = {"SupportedObjects": str(len(kept))} | {
                str(number): index for number, index in enumerate(kept, 1)
            }
        return "\n".join(_lines(parser))


def _lines(parser: ConfigParser) -> Iterator[str]:
    for name in parser.sections():
        yield f"[{name}]"
        yield from (f"{key}={value}" for key, value in parser[name].items())
        yield ""


def foreign_servers() -> list[ForeignServer]:
    """Return all servers, by name."""
    return [_read(path) for path in sorted(SERVERS.glob("*/server.toml"))]


def _read(path: Path) -> ForeignServer:
    table: dict[str, Any] = tomllib.loads(path.read_text())
    return ForeignServer(
        name=path.parent.name,
        title=table["title"],
        needs=tuple(table.get("needs", ())),
        build=tuple(tuple(command) for command in table["build"]),
        start=tuple(table["start"]),
        without=tuple(table.get("eds-without", ())),
        replaced=table.get("eds-replaced", {}),
        causes=tuple(
            ExpectedCause(
                entry["cause"],
                entry["why"],
                tuple(entry["frames"]),
                lacking=entry.get("lacking", False),
                now_and_then=entry.get("now-and-then", False),
            )
            for entry in table.get("causes", ())
        ),
        server_timeout=table.get("server-timeout"),
    )
