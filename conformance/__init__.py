"""Conformance suite for CANopen SDO servers (CiA 301): a pytest plugin and what it stands on."""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from conformance.own_tests import *  # noqa: F403

__version__ = version("canopen-sdo-conformance")


def __getattr__(name: str) -> object:
    """Give tests of the user's own what they need, once they ask: the protocol needs none of it."""
    own_tests = import_module("conformance.own_tests") if not name.startswith("_") else None
    if name not in getattr(own_tests, "__all__", ()):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(own_tests, name)
