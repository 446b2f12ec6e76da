"""What each line of results.jsonl holds, and the check that a line holds it.

A record comes from a file, which anybody may have changed: what is made of it reads it without
looking again.
"""

import math
from collections.abc import Mapping
from datetime import datetime
from enum import StrEnum
from pathlib import PurePath
from types import UnionType
from typing import Any, NotRequired, TypedDict, get_args, get_origin, get_type_hints, is_typeddict

from conformance.device.not_testable import Missing
from conformance.eds.findings import FindingRecord
from conformance.reporting.bus_log import Place
from conformance.run.trace import TraceLine
from conformance.run.verdict import CaseResult
from conformance.sdo.cob_id import HIGHEST_NODE_ID, ChannelIds
from conformance.sdo.rules import Cause


class WrongShape(ValueError):
    """A line of a record has another shape; the text says where."""


class NamedFile(TypedDict):
    """A file that a run was given."""

    name: str
    sha256: str
    revision: NotRequired[str]
    objects: NotRequired[int]
    entries: NotRequired[int]
    findings: NotRequired[list[FindingRecord]]


class About(TypedDict):
    """The first line: what was asked for, where and with what. Times are as in ISO 8601."""

    begun: str
    begun_utc: str
    suite: str
    python: str
    platform: str
    packages: dict[str, str]
    command: list[str]
    node_ids: list[int]
    interface: str | None
    channel: str | None
    self_test: bool
    permissions: list[str]
    writable: list[str]
    all_rw: bool
    strict: bool
    properties: dict[str, str]
    host: NotRequired[str]
    folder: NotRequired[str]
    bitrate: NotRequired[int | None]
    bus_options: NotRequired[dict[str, str]]
    bus_arguments: NotRequired[list[str]]
    server: NotRequired[str | None]
    eds: NotRequired[NamedFile | None]
    description: NotRequired[NamedFile | None]
    response_timeout: NotRequired[float]
    server_timeout: NotRequired[float | None]
    seed: NotRequired[int]
    examples: NotRequired[int]
    budget: NotRequired[float | None]
    quick: NotRequired[bool]


class Discovered(TypedDict):
    """A line on a device: what was found out before its first case."""

    node_id: int
    sdo_channel: str
    identity: dict[str, str]
    texts: dict[str, str]
    properties: dict[str, str]


class Ended(TypedDict):
    """The last line: how the run ended."""

    at: str
    how: str
    exit_status: int
    properties: dict[str, str]
    bench_errors: list[str]
    unrestored: list[str]


def check_about(values: Mapping[str, Any]) -> None:
    """Raise WrongShape for a first line that is none."""
    _check("the run", values, About)
    for name in ("begun", "begun_utc"):
        _check_time(name, values[name])
    node_ids = values["node_ids"]
    within = all(1 <= node_id <= HIGHEST_NODE_ID for node_id in node_ids)
    if not node_ids or not within or len(set(node_ids)) < len(node_ids):
        raise WrongShape("node_ids are no node-IDs")


def check_device(values: Mapping[str, Any], node_ids: list[int]) -> None:
    """Raise WrongShape for a line on a device that is none of this run."""
    _check("the device", values, Discovered)
    _check_node(values["node_id"], node_ids)
    ChannelIds.parse(values["sdo_channel"])


def check_end(values: Mapping[str, Any]) -> None:
    """Raise WrongShape for a last line that is none."""
    _check("the end", values, Ended)
    _check_time("at", values["at"])


def check_selected(values: Mapping[str, Any]) -> None:
    """Raise WrongShape for a line that does not say how many cases were selected."""
    if not _fits(values.get("cases"), int):
        raise WrongShape("cases is no number")


def result_of(values: Mapping[str, Any], node_ids: list[int]) -> CaseResult:
    """Return the result on the line of a case; raises WrongShape."""
    found = values.get("result")
    if not isinstance(found, dict):
        raise WrongShape("result is missing")
    hints = _HINTS[CaseResult]
    for name, value in found.items():
        if name not in hints or not _fits(value, hints[name]):
            raise WrongShape(f"{name} is not as in the result of a case")
    try:
        result = CaseResult.from_dict(found)
    except TypeError as error:
        raise WrongShape(f"the result of a case is incomplete: {error}") from error
    marked = result.decisive
    if marked is not None and not (0 <= marked < len(result.trace) and result.trace[marked].frame):
        raise WrongShape("decisive is no frame of the trace")
    _check_node(result.node_id, node_ids)
    return result


def place_of(values: Any) -> Place | None:
    """Return where the frames of a case are; raises WrongShape."""
    if values is None:
        return None
    hints = _HINTS[Place]
    if not isinstance(values, dict) or not values.keys() <= hints.keys():
        raise WrongShape("frames is no place in a log")
    if not all(_fits(value, hints[name]) for name, value in values.items()):
        raise WrongShape("frames is no place in a log")
    if any(value < 0 for value in values.values() if isinstance(value, int)):
        raise WrongShape("frames has a number below 0")
    log = values.get("log", "")
    if PurePath(log).name != log or not log:
        raise WrongShape(f"{log!r} is no log in this folder")
    try:
        return Place(**values)
    except TypeError as error:
        raise WrongShape(f"frames is incomplete: {error}") from error


def places_of(values: Mapping[str, Any]) -> list[Place | None]:
    """Return where the frames of all cases are; raises WrongShape."""
    found = values.get("frames")
    if not isinstance(found, list):
        raise WrongShape("frames is no list")
    return [place_of(each) for each in found]


_HINTS: dict[type, dict[str, Any]] = {
    kind: get_type_hints(kind)
    for kind in (
        CaseResult,
        Cause,
        Missing,
        TraceLine,
        Place,
        About,
        Discovered,
        Ended,
        NamedFile,
        FindingRecord,
    )
}
# Values of a result that are objects in JSON, with exactly their fields.
_VALUES = (Cause, Missing, TraceLine)


def _check(what: str, values: Mapping[str, Any], kind: type) -> None:
    for name, hint in _HINTS[kind].items():
        if name not in values:
            if name in kind.__required_keys__:  # type: ignore[attr-defined]
                raise WrongShape(f"{what} lacks {name}")
        elif not _fits(values[name], hint):
            raise WrongShape(f"{name} of {what} is not as in a record")


def _check_time(name: str, value: str) -> None:
    try:
        datetime.fromisoformat(value)
    except ValueError:
        raise WrongShape(f"{name} is no time") from None


def _check_node(node_id: int, node_ids: list[int]) -> None:
    if node_id not in node_ids:
        raise WrongShape(f"node {node_id} is none of this run")


def _fits(value: object, hint: Any) -> bool:
    """Say whether a value out of JSON is of a type."""
    if isinstance(hint, UnionType):
        return any(_fits(value, each) for each in get_args(hint))
    if is_typeddict(hint):
        hints = _HINTS[hint]
        return isinstance(value, dict) and all(
            _fits(value[name], each) if name in value else name not in hint.__required_keys__
            for name, each in hints.items()
        )
    if hint in _VALUES:
        hints = _HINTS[hint]
        return (
            isinstance(value, dict)
            and value.keys() == hints.keys()
            and all(_fits(value[name], each) for name, each in hints.items())
        )
    arguments = get_args(hint)
    if get_origin(hint) is list:
        return isinstance(value, list) and all(_fits(each, arguments[0]) for each in value)
    if get_origin(hint) is dict:
        return isinstance(value, dict) and all(
            _fits(name, arguments[0]) and _fits(each, arguments[1]) for name, each in value.items()
        )
    if hint is type(None) or hint is None:
        return value is None
    if hint is bool:
        return isinstance(value, bool)
    if isinstance(value, bool):
        return False
    if hint is float:
        return isinstance(value, int | float) and math.isfinite(value)
    if hint is str:
        return isinstance(value, str)
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        return isinstance(value, str) and value in set(hint)
    return isinstance(value, hint)
