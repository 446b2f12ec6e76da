"""The table of options, as pytest declares it: arguments, and settings of a project or a CI job.

Settings stand in pytest's ini file and in environment variables. They become arguments before those
of the command line, which therefore override them.
"""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from conformance.device.options import DEVICE, NODE_ID, OPTIONS, SELF_TEST, Option
from conformance.sdo.nearest import nearest

NAMED = [option for option in OPTIONS if option.name]
SETTINGS = [option for option in NAMED if option.setting]
# How our options begin, and two with names of their own.
PREFIXES, OTHERS = ("--sdo-", "--can-"), (NODE_ID.name, SELF_TEST.name)
# Whether the command line itself asks for a device: settings do not choose what is run.
ASKED = pytest.StashKey[bool]()


def add_options(parser: pytest.Parser) -> None:
    """Declare the options. ``--strict`` is pytest's own; the suite listens to it."""
    group = parser.getgroup("conformance", "CANopen SDO conformance")
    for option in NAMED:
        group.addoption(option.name, default=None, **option.argument())
    for option in SETTINGS:
        text = f"as {option.name}; also the environment variable {option.variable}"
        if option.is_repeated:
            parser.addini(option.destination, text, type="linelist", default=[])
        else:
            parser.addini(option.destination, text, type="string", default="")


def check_names(unknown: Iterable[str], options: Iterable[str]) -> None:
    """Raise pytest.UsageError for an ``unknown`` argument that is nearly one of our ``options``.

    pytest itself would not name the nearest option. Other unknown arguments are left to pytest.
    """
    names = [name for name in options if name.startswith(PREFIXES) or name in OTHERS]
    for name in (argument.partition("=")[0] for argument in unknown):
        if not name.startswith("--"):
            continue
        near = " or ".join(nearest(name, names))
        if near:
            raise pytest.UsageError(f"There is no option {name}. Did you mean {near}?")
        if name.startswith(PREFIXES):
            raise pytest.UsageError(f"There is no option {name}. pytest --help lists them.")


def put_before(config: pytest.Config, arguments: list[str]) -> None:
    """Put the settings before the ``arguments`` of the command line.

    A self-test has a device of its own. A worker has been handed all options.
    """
    given = config.known_args_namespace
    config.stash[ASKED] = any(_value(given, option) for option in (SELF_TEST, NODE_ID, DEVICE))
    handed = any(_value(config.option, option) for option in SETTINGS)
    if not _value(given, SELF_TEST) and not handed:
        arguments[:0] = [part for option in SETTINGS for part in _arguments(config, option)]


def _value(namespace: object, option: Option[Any]) -> object:
    return getattr(namespace, option.destination, None)


def _arguments(config: pytest.Config, option: Option[Any]) -> list[str]:
    value = os.environ.get(option.variable, "")
    if not value:
        found = _from_ini(config, option)
    elif option.is_of_bus:
        found = []
    else:
        found = value.split() if option.is_repeated else [value]
    return [f"{option.name}={each}" for each in found]


def _from_ini(config: pytest.Config, option: Option[Any]) -> list[str]:
    value = config.getini(option.destination)
    if option.is_repeated:
        return list(value)
    if value and option.kind.parse is Path and config.inipath is not None:
        return [str(config.inipath.parent / value)]
    return [value] if value else []
