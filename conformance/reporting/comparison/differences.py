"""What differs between two runs beside their cases: devices, options, choices, response times."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from conformance.reporting.comparison.sides import Side, pairs
from conformance.reporting.page.profile import Chosen
from conformance.reporting.page.traffic import Times
from conformance.reporting.recorded import TEXT_NAMES

# Of the first line of results.jsonl, in the words of the reports.
OPTIONS = {
    "suite": "suite version",
    "python": "Python",
    "platform": "machine",
    "packages": "packages",
    "self_test": "self-test",
    "server": "built-in server",
    "interface": "interface",
    "channel": "channel",
    "bitrate": "bit rate",
    "bus_options": "options of the bus",
    "eds": "EDS",
    "description": "description of the device",
    "permissions": "permissions",
    "writable": "writable objects",
    "all_rw": "all rw objects are writable",
    "response_timeout": "response time-out in s",
    "server_timeout": "time-out of the server in s",
    "seed": "seed",
    "examples": "random conversations",
    "budget": "budget in s",
    "strict": "strict",
}
NONE = "none"
# The choices of each device by their matters, by its node-ID.
Profile = Mapping[int, Chosen]
# What counts as slower: the factor, the least milliseconds, and the least number of answers.
FACTOR, MILLISECONDS, ANSWERS = 1.5, 1.0, 20


@dataclass(frozen=True, slots=True)
class Difference:
    """Something that was otherwise in the old run."""

    what: str
    old: str
    new: str


@dataclass(frozen=True, slots=True)
class TimesOfKind:
    """Response times to one kind of request: half within, 95 % within, the longest; in ms."""

    kind: str
    answers: tuple[int, int]
    old: list[float]
    new: list[float]

    @property
    def both(self) -> list[tuple[float, float]]:
        """The old and the new times side by side."""
        return list(zip(self.old, self.new, strict=True))

    @property
    def slower(self) -> bool:
        """Whether half of the answers, or 95 % of them, take clearly longer."""
        return min(self.answers) >= ANSWERS and any(
            new > FACTOR * old and new - old > MILLISECONDS for old, new in self.both[:-1]
        )


def devices(old: Side, new: Side) -> list[Difference]:
    """Return how the devices differ: in their node-IDs, identity and texts."""
    found = [
        Difference("device", f"node {node_id}", NONE)
        for node_id in old.node_ids
        if node_id not in pairs(old, new)
    ]
    found += [
        Difference("device", NONE, f"node {node_id}")
        for node_id in new.node_ids
        if node_id not in pairs(old, new).values()
    ]
    for before, after in pairs(old, new).items():
        of_node = "" if len(new.node_ids) == 1 else f"node {after}: "
        found += _differing(of_node, {"node-ID": before}, {"node-ID": after})
        found += _differing(of_node, _identity(old, before), _identity(new, after))
    return found


def _identity(side: Side, node_id: int) -> dict[str, Any]:
    device = side.device(node_id)
    texts = {TEXT_NAMES.get(name, name): text for name, text in device["texts"].items()}
    return {f"{name} (1018h)": value for name, value in device["identity"].items()} | texts


def options(old: Side, new: Side) -> list[Difference]:
    """Return how the runs differ in what was asked for, and in what they were made with."""
    before, after = old.run.about, new.run.about
    # Built-in servers are on a bus of their own, whose name is another each time.
    left_out = {"channel"} if before["self_test"] and after["self_test"] else set()
    chosen = {key: name for key, name in OPTIONS.items() if key not in left_out}
    old_values, new_values = (
        {name: about.get(key) for key, name in chosen.items()} for about in (before, after)
    )
    return list(_differing("", old_values, new_values))


def profile(node_ids: Mapping[int, int], old: Profile, new: Profile) -> list[Difference]:
    """Return what devices choose otherwise than before, where both runs have shown a choice."""
    found: list[Difference] = []
    for before, after in node_ids.items():
        of_node = "" if len(node_ids) == 1 else f"node {after}: "
        chosen, choose = old.get(before, {}), new.get(after, {})
        shared = [topic for topic in chosen if topic in choose]
        before_and_after = ({topic: each[topic] for topic in shared} for each in (chosen, choose))
        found += _differing(of_node, *before_and_after)
    return found


def times(old: Mapping[str, Times], new: Mapping[str, Times]) -> list[TimesOfKind]:
    """Return the response times to each kind of request that both runs have sent."""
    return [
        TimesOfKind(
            kind,
            (len(old[kind].all), len(new[kind].all)),
            old[kind].percentiles(),
            new[kind].percentiles(),
        )
        for kind in sorted(old.keys() & new.keys())
    ]


def _differing(
    of_node: str, old: Mapping[str, Any], new: Mapping[str, Any]
) -> Iterator[Difference]:
    for what in {**old, **new}:
        before, after = old.get(what), new.get(what)
        if before != after:
            yield Difference(f"{of_node}{what}", *_told(before, after))


def _told(old: Any, new: Any) -> tuple[str, str]:
    """Return two values in words; of two lists only what the other has not."""
    if isinstance(old, list) and isinstance(new, list):
        return _words([each for each in old if each not in new]), _words(
            [each for each in new if each not in old]
        )
    return _words(old), _words(new)


def _words(value: Any) -> str:
    if value is None or value in ([], {}, ""):
        return NONE
    match value:
        case bool():
            return "yes" if value else "no"
        case list():
            return ", ".join(map(str, value))
        case {"name": name, "sha256": digest}:
            return f"{name} (SHA-256 {digest[:12]}…)"
        case dict():
            return ", ".join(f"{name} {each}" for name, each in value.items())
    return str(value)
