"""The text of a drafted device.toml: right as it is, and with every proposal in it."""

import json
import shlex
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from conformance import __version__
from conformance.bus.opening import BusSettings
from conformance.device.known_objects import name_of
from conformance.proposing.additions import ALL_CASES, BY_OBJECT, PERMISSIONS, Permission
from conformance.proposing.proposals import OVERFLOWING, Proposal, Proposals
from conformance.sdo.printable_text import inert

# Where the comment behind a proposal begins.
COLUMN = 32
WIDTH = 96
MOST_LISTED = 20
_HEAD = """\
# What the conformance suite may do with this device: a draft of conformance init {version}, made of
# {source}. Nothing was written to any device.
#
# As it is, this file permits no write. A line that begins with # and no blank is a proposal: delete
# its # if it is right for your device. What is written is read before, and restored afterwards.
#
#     {command}
"""


@dataclass(slots=True)
class Draft:
    """The contents of the file.

    ``about`` are sentences on the device, ``remarks`` its oddities. ``eds`` is the path
    from the file; ``indices`` are all objects that the device is known to have. A bus of None is
    not known.
    """

    output: Path
    source: str
    node_id: int | None
    bus: BusSettings | None
    eds: str | None
    proposals: Proposals
    indices: set[int]
    about: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    @property
    def command(self) -> str:
        """The command that tests the device with the file."""
        name = "device.toml" if str(self.output) == "-" else str(self.output)
        node = "" if self.node_id else " --node-id=N"
        return f"pytest --sdo-device={shlex.quote(name)}{node}"


def draft_text(draft: Draft) -> str:
    """Return the file, which ``read_description`` reads as it is and with all proposals."""
    return "\n".join(_lines(draft)) + "\n"


def _lines(draft: Draft) -> Iterator[str]:
    yield from _HEAD.format(
        version=__version__, source=inert(draft.source), command=inert(draft.command)
    ).splitlines()
    if draft.about or draft.remarks:
        yield ""
    for sentence in (*draft.about, *draft.remarks):
        yield from _comment(sentence)
    yield ""
    yield f"node-id = {draft.node_id}" if draft.node_id else "#node-id = 5"
    if draft.eds is not None:
        yield f"eds = {_quoted(draft.eds)}"
    else:
        yield '# With an EDS, each of its objects is tested: eds = "drive.eds".'
    yield ""
    yield from _bus_lines(draft.bus)
    yield ""
    yield from _object_lines(draft)
    yield ""
    yield from _permission_lines(draft.indices)
    yield from (
        "",
        "[timing]",
        "# Seconds within which a response has to come.",
        "#response = 1.0",
        "# If the device aborts the transfer of a silent client after a time, declare it, as in",
        "# server-timeout = 2.0; about 20 cases need that.",
    )


def _bus_lines(bus: BusSettings | None) -> Iterator[str]:
    yield "[can]"
    if bus is None:
        yield from ('#interface = "socketcan"', '#channel = "can0"', "#bitrate = 500000")
        return
    yield f"interface = {_quoted(bus.interface or '')}"
    if bus.channel is not None:
        yield f"channel = {_quoted(bus.channel)}"
    if bus.bitrate is not None:
        yield f"bitrate = {bus.bitrate}"
    if bus.options:
        options = ", ".join(f"{name} = {_quoted(value)}" for name, value in bus.options)
        yield f"options = {{{options}}}"


def _object_lines(draft: Draft) -> Iterator[str]:
    proposals = draft.proposals
    yield "[objects]"
    needed = "; ".join(f"{what} {cases}" for what, cases in BY_OBJECT.items())
    yield from _comment(f"How many of {ALL_CASES} cases need one that may be written: {needed}.")
    if draft.eds is None:
        yield from _comment(
            "Types are guessed from what was read, and only a write would tell whether an object "
            "can be written: look them up before you delete a #."
        )
    yield "writable = ["
    if proposals.own:
        yield "# The device's own objects, 2000h to 5FFFh:"
        yield from _proposed(proposals.own)
    if proposals.profile:
        yield from _comment(
            "Those of its profile, from 6000h on. OUTPUTS AND DRIVES MAY MOVE when one of these is "
            "written, if only for a moment: disconnect first what could do harm."
        )
        yield from _proposed(proposals.profile)
    if not [*proposals]:
        yield "# Nothing was found; objects are named as in"
        yield '# "2001", "2010:01=unsigned16", "2020=visible_string"'
    yield "]"
    yield from _large_lines(proposals)
    if proposals.never:
        yield "# Never written, whatever else permits it. Add what else nobody may change."
        yield "never = ["
        for mux, why in proposals.never:
            yield _with_note(f"{_quoted(name_of(mux))},", why)
        yield "]"
    else:
        yield '# What is never written, whatever else permits it, is named as in never = ["2100"].'
    for mux, why in proposals.left_out[:MOST_LISTED]:
        yield from _comment(f"Not proposed: {mux}: {why}")
    if len(proposals.left_out) > MOST_LISTED:
        yield f"# and {len(proposals.left_out) - MOST_LISTED} more"


def _proposed(proposals: Iterable[Proposal]) -> Iterator[str]:
    for proposal in proposals:
        yield _with_note(f"#{_quoted(proposal.known.named)},", proposal.note)


def _large_lines(proposals: Proposals) -> Iterator[str]:
    why = f"Transfers of {OVERFLOWING} bytes and more show whether counters overflow."
    long_ones = proposals.long_ones
    if not long_ones:
        yield from _comment(f'{why} No string or domain was found for them: large = "2020=domain".')
        return
    first = long_ones[0]
    if (first.length or 0) >= OVERFLOWING:
        yield from _comment(f"{why} Their first choice, if it may be written:")
    else:
        yield from _comment(f"{why} Nothing was seen to be so long; name what may hold so much:")
    yield _with_note(
        f"#large = {_quoted(first.known.named)}",
        "" if first.length is None else f"reads {first.length} bytes",
    )


def _permission_lines(indices: set[int]) -> Iterator[str]:
    yield "[permissions]"
    yield "# What the suite may do besides, and how many cases need it."
    withheld = []
    for permission in PERMISSIONS:
        if not _concerns(permission, indices):
            continue
        if permission.proposed:
            yield from _comment(f"{permission.needed_by}: {permission.effect}")
            yield f"#{permission.name} = true"
        else:
            withheld.append(f"{permission.name} ({permission.effect})")
    if withheld:
        yield from _comment(f"Not proposed: {', '.join(withheld)}.")


def _concerns(permission: Permission, indices: set[int]) -> bool:
    """Say whether a permission is about no objects, or about some that the device has."""
    ranges = permission.indices
    has_some = any(index in one for one in ranges for index in indices)
    return not ranges or permission.name == "nmt" or has_some


def _with_note(text: str, note: str) -> str:
    return f"{text:<{COLUMN}} # {inert(note)}" if note else text


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(inert(text), WIDTH, break_on_hyphens=False)]


def _quoted(text: str) -> str:
    # A string of JSON is one of TOML, but for DEL.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
