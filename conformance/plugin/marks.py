"""The marks of a case, for ``-m``: its level, its service, and its effects on a device."""

import re
from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from functools import cache

import pytest

from conformance.plugin.items import CaseFunction
from conformance.run.risks import Kind
from conformance.sdo.nearest import meant

MARKS = {
    "must": "fails the device if it is broken",
    "should": "fails the device only with --strict",
    "may": "is about what CiA 301 leaves open",
    "expedited": "is about expedited transfers",
    "segmented": "is about segmented transfers",
    "block": "is about block transfers",
    "upload": "is about uploads",
    "download": "is about downloads",
    "matrix": "sends one frame in one state of the server",
    "random": "generates conversations",
    "od": "compares the device with its EDS, object by object",
    "writes": "may send a download; others only read",
    "nmt": "sends NMT commands to the device: resets and stops it",
    "risky": "sends what servers have stopped at: odd frames, and lost segments",
    "slow": "waits for a time that the device declares",
}
SERVICES = ("segmented", "block", "upload", "download")
GROUPS = ("matrix", "random", "od")
# The cases that send no download, with any device and any permission.
READS = (
    *("upload.*", "segmented-upload.read-only-text", "segmented-upload.without-initiate"),
    *("segmented-download.without-initiate", "sequence.uploads"),
    *(f"block-upload.{point}" for point in ("constant", "*-missing", "write-only")),
    *(f"abort.{point}" for point in ("frame", "many", "not-answered", "repeated")),
    *("abort.own-multiplexer", "abort.reserved-bits"),
    *(f"channel.{point}" for point in ("count", "default-count", "default-parameter")),
    *("channel.missing-refused", "channel.records"),
    *(f"communication.{point}" for point in ("error-register", "reserved-entry", "stor*")),
    "communication.vendor-id",
    *(f"frame.{point}" for point in ("*-identifier", "extended-ignored", "mirror")),
    *(f"frame.{point}" for point in ("one-answer", "other-node", "remote", "remote-ignored")),
    "frame.short",
    *(f"od.{point}" for point in ("block-of-write-only", "block-read", "default", "error-list")),
    *(f"od.{point}" for point in ("gap", "highest-sub-index", "identity", "length", "read")),
    *(f"od.{point}" for point in ("structure", "sub-index-beyond", "unlisted", "within-limits")),
    "od.write-only",
    "pdo.mapping-in-use",
    *("run.*", "specifier.block-upload*", "specifier.out-of-block"),
    *("specifier.sub-command", "specifier.unknown*"),
)
# A name in an expression, which is neither a parameter of a mark nor in quotes.
_NAME = re.compile(r"""["'][^"']*["']|[^\W\d]\w*\s*=[^=,)]*|([^\W\d]\w*)""")
_SERVICE = re.compile(rf"(?<![a-z])(?:{'|'.join(SERVICES)})(?![a-z])")
_WORDS = ("and", "or", "not", "True", "False", "None")
_DECORATORS = {name: getattr(pytest.mark, name) for name in MARKS}


def mark(items: Sequence[CaseFunction]) -> None:
    """Give the cases that are made of one function their marks."""
    shared = list(_shared_names(items[0])) if items else []
    for item in items:
        for name in (*shared, *_own_names(item)):
            item.add_marker(_DECORATORS[name])


def check_expression(config: pytest.Config, items: Iterable[pytest.Item]) -> None:
    """Raise pytest.UsageError for a name in ``-m`` that nothing bears and is nearly one of ours.

    pytest would select no case by it, or all.
    """
    used = {name for name in _NAME.findall(config.option.markexpr) if name and name not in _WORDS}
    registered = {re.split(r"\W", line.strip())[0] for line in config.getini("markers")}
    unknown = used - registered
    if not unknown:
        return
    for name in sorted(unknown - {mark.name for item in items for mark in item.iter_markers()}):
        if hint := meant(name, MARKS):
            raise pytest.UsageError(f"-m: there is no mark {name!r}.{hint}")


def _shared_names(item: CaseFunction) -> Iterator[str]:
    """Yield the marks that all variations of a case have, on each device."""
    family = item.case.rule.id
    yield item.case.rule.level.value.lower()
    if "expedited" in item.service:
        yield "expedited"
    yield from (name for name in GROUPS if family.startswith(f"{name}."))
    if not _reads(family):
        yield "writes"
    if item.asks_for("network") or item.asks_for("storage"):
        yield "nmt"
    if item.case.slow:
        yield "slow"


def _own_names(item: CaseFunction) -> Iterator[str]:
    """Yield the marks that depend on the variation."""
    yield from dict.fromkeys(_SERVICE.findall(item.case_id))
    if item.risk is not None and item.risk.kind is not Kind.ORDINARY:
        yield "risky"


@cache
def _reads(family: str) -> bool:
    return any(fnmatchcase(family, pattern) for pattern in READS)
