"""The command line beside pytest: a server, lists of faults and rules, EDS, logs, reports."""

import argparse
import io
import os
import sys
from collections.abc import Collection, Sequence
from importlib import import_module
from typing import Protocol, cast

import can

from conformance import __version__
from conformance.bus.errors import BenchError, OtherDevice, SilentNode
from conformance.commands.status import (
    BROKEN_BENCH,
    DONE,
    INTERRUPTED,
    NOT_THERE,
    SILENT_NODE,
    WRONG_USE,
)
from conformance.faults.catalogue import UnknownServer
from conformance.sdo.nearest import did_you_mean, meant
from conformance.sdo.printable_text import inert
from conformance.sdo.rules import UnknownRule

LINE_END = "\n"


class Command(Protocol):
    """A module of ``conformance.commands``."""

    HELP: str

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the command."""

    def run(self, options: argparse.Namespace) -> int:
        """Run the command; returns the exit status."""


COMMANDS = (
    "init",
    "serve",
    "faults",
    "rules",
    "eds",
    "decode",
    "replay",
    "report",
    "compare",
    "overview",
    "restore",
)


def command_of(name: str) -> Command:
    """Return the module of a command. To import all of them takes half a second."""
    return cast(Command, import_module(f"conformance.commands.{name}"))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status.

    That is 0, 1 for a broken bench or an EDS with errors, 2 for wrong use, 3 when a log shows what
    is not allowed, when a run is worse than an earlier one or an EDS has warnings, 4 where what is
    to be restored is not there, or not on this device, 10 for a device that does not answer.
    """
    given = sys.argv[1:] if arguments is None else arguments
    _open_streams()
    parser = command_line([name for name in COMMANDS if name in given[:1]] or COMMANDS)
    if given and not given[0].startswith("-") and given[0] not in COMMANDS:
        parser.error(f"{given[0]!r} is no command. {did_you_mean(given[0], COMMANDS)}")
    options, unknown = parser.parse_known_args(given)
    if unknown:
        parser.error(f"unrecognized arguments: {' '.join(unknown)}.{_hint(options, unknown[0])}")
    try:
        status = int(options.run(options))
        sys.stdout.flush()
        return status
    except BrokenPipeError as error:
        if options.command == "serve":  # it is the connection to a bus
            return _broken(error, BROKEN_BENCH)
        # The reader has closed the pipe, as ``head`` does; Python would complain once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except SilentNode as error:
        return _broken(error, SILENT_NODE)
    except OtherDevice as error:
        return _broken(error, NOT_THERE)
    except (BenchError, OSError, can.CanError) as error:
        return _broken(error, BROKEN_BENCH)
    except (UnknownServer, UnknownRule, ValueError) as error:
        return _broken(error, WRONG_USE)
    except KeyboardInterrupt:
        return INTERRUPTED


def _open_streams() -> None:
    """Let stdout and stderr take any text, and exist.

    A program that was started with a closed stdout or stderr has none.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - kept open
        elif isinstance(stream, io.TextIOWrapper):  # where it takes less than there may be
            stream.reconfigure(errors="backslashreplace")


def _broken(error: Exception, status: int) -> int:
    print(f"conformance: {inert(str(error), keep=LINE_END)}", file=sys.stderr)
    return status


def _hint(options: argparse.Namespace, unknown: str) -> str:
    """Name the option of the command that is nearest to an unknown one."""
    own = argparse.ArgumentParser()
    command_of(options.command).add_options(own)
    return meant(unknown.partition("=")[0], own.format_usage().replace("[", " ").split())


def command_line(names: Collection[str] = COMMANDS) -> argparse.ArgumentParser:
    """Return the parser of the commands of these names."""
    parser = argparse.ArgumentParser(prog="conformance", description=__doc__)
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name in names:
        command = command_of(name)
        options = commands.add_parser(name, help=command.HELP, description=_sentence(command.HELP))
        command.add_options(options)
        options.set_defaults(run=command.run, command=name)
    return parser


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


if __name__ == "__main__":
    sys.exit(main())
