"""Settings of a project and of a CI job: in pytest's ini file, and in environment variables.

They become arguments before those of the command line, which therefore override them.
"""

import os
from dataclasses import dataclass
from enum import Enum

import pytest

DEFAULT_REPORT_DIR = "reports"
VARIABLE = "CANOPEN_"


class Kind(Enum):
    """What a setting is; a path is relative to the ini file, or to the folder of the command."""

    TEXT = "text"
    LIST = "list"
    PATH = "path"


@dataclass(frozen=True, slots=True)
class Setting:
    """An option that may stand in an ini file and in an environment variable."""

    name: str
    kind: Kind = Kind.TEXT

    @property
    def option(self) -> str:
        """The option of the command line."""
        return "--" + self.name.replace("_", "-")

    @property
    def variable(self) -> str:
        """The environment variable; those of the bus are python-can's own."""
        if self.is_of_bus:
            return self.name.upper() if self.kind is Kind.TEXT else "CAN_CONFIG"
        return VARIABLE + self.name.removeprefix("sdo_").upper()

    @property
    def is_of_bus(self) -> bool:
        """Whether python-can reads the environment variable itself, after its files."""
        return self.name.startswith("can_")


SETTINGS = (
    Setting("node_id"),
    Setting("can_interface"),
    Setting("can_channel"),
    Setting("can_bitrate"),
    Setting("can_option", Kind.LIST),
    Setting("sdo_device", Kind.PATH),
    Setting("sdo_eds", Kind.PATH),
    Setting("sdo_object", Kind.LIST),
    Setting("sdo_allow", Kind.LIST),
    Setting("sdo_channel"),
    Setting("sdo_response_timeout"),
    Setting("sdo_server_timeout"),
    Setting("sdo_process"),
    Setting("sdo_recover"),
    Setting("sdo_deviations", Kind.PATH),
    Setting("sdo_report_dir", Kind.PATH),
    Setting("sdo_require", Kind.LIST),
    Setting("sdo_examples"),
    Setting("sdo_budget"),
)
# Whether the command line itself asks for a device: settings do not choose what is run.
ASKED = pytest.StashKey[bool]()


def add_settings(parser: pytest.Parser) -> None:
    """Declare the settings to pytest."""
    for setting in SETTINGS:
        text = f"as {setting.option}; also the environment variable {setting.variable}"
        if setting.kind is Kind.LIST:
            parser.addini(setting.name, text, type="linelist", default=[])
        else:
            parser.addini(setting.name, text, type="string", default="")


def put_before(config: pytest.Config, arguments: list[str]) -> None:
    """Put what is set before the ``arguments`` of the command line.

    A self-test has a device of its own. A worker has been handed all options.
    """
    given = config.known_args_namespace
    config.stash[ASKED] = given.self_test or bool(given.node_id or given.sdo_device)
    handed = any(getattr(config.option, setting.name, None) for setting in SETTINGS)
    if not given.self_test and not handed:
        arguments[:0] = [part for setting in SETTINGS for part in _arguments(config, setting)]


def _arguments(config: pytest.Config, setting: Setting) -> list[str]:
    value = os.environ.get(setting.variable, "")
    if not value:
        found = _from_ini(config, setting)
    elif setting.is_of_bus:
        found = []
    else:
        found = value.split() if setting.kind is Kind.LIST else [value]
    return [f"{setting.option}={each}" for each in found]


def _from_ini(config: pytest.Config, setting: Setting) -> list[str]:
    value = config.getini(setting.name)
    if setting.kind is Kind.LIST:
        return list(value)
    if value and setting.kind is Kind.PATH and config.inipath is not None:
        return [str(config.inipath.parent / value)]
    return [value] if value else []
