"""``conformance init``: a draft of device.toml, from a device, its EDS or both."""

import argparse
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from conformance.bus.channel import Channel
from conformance.bus.link import Link
from conformance.bus.opening import BusSettings, open_bus
from conformance.commands.notes import tell
from conformance.commands.options import NODE_ID, add_bus_options, add_option, bus_settings
from conformance.commands.status import DONE
from conformance.device.eds_listing import Listing
from conformance.device.options import EDS, RESPONSE_TIMEOUT
from conformance.eds.reading import read_eds
from conformance.proposing.proposals import Proposals, by_eds, by_reading
from conformance.proposing.reading import about, differences, read_device, search
from conformance.proposing.text import Draft, draft_text
from conformance.sdo.printable_text import inert

HELP = "draft a device.toml: read a device, its EDS or both, and propose what may be written"
FILE = Path("device.toml")
STANDARD_OUTPUT = Path("-")
MOST_REMARKS = 10
# Seconds between two words on how far the reading is.
OFTEN = 5.0


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_option(
        parser,
        NODE_ID,
        help="read this device; nothing is written to it, and nothing sent to other nodes",
    )
    add_option(
        parser,
        EDS,
        help="propose by this EDS or DCF; without one, all indices from 1000h to 9FFFh are read",
    )
    add_bus_options(parser)
    add_option(parser, RESPONSE_TIMEOUT)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=FILE,
        metavar="FILE",
        help=f"the file to write ({FILE}); - for the standard output",
    )
    parser.add_argument("--force", action="store_true", help="overwrite the file if there is one")


def run(options: argparse.Namespace) -> int:
    """Read, and write the draft."""
    node_id, output = options.node_id, options.output
    if node_id is None and options.eds is None:
        raise ValueError(
            "say what to read: a device with --node-id=N, an EDS with --eds=FILE, or both"
        )
    if output != STANDARD_OUTPUT and output.exists() and not options.force:
        raise ValueError(
            f"{output} exists: overwrite it with --force, or name another with -o FILE"
        )
    if output != STANDARD_OUTPUT:
        _check_folder(output)
    listing = read_eds(options.eds, node_id or 1) if options.eds else None
    draft = _from_device(options, listing) if node_id is not None else _from_eds(options, listing)
    text = draft_text(draft)
    if output == STANDARD_OUTPUT:
        sys.stdout.write(text)
        tell(_notes(draft))
    else:
        output.write_text(text, encoding="utf-8")
        for line in (*_notes(draft), f"written: {output}", f"next: {draft.command}"):
            print(inert(line))
    return DONE


def _check_folder(output: Path) -> None:
    """Raise ValueError where a file cannot be created: a device is read for minutes before."""
    folder = output.parent
    if not folder.is_dir():
        raise ValueError(f"there is no folder {folder}: create it, or name another with -o FILE")
    if not os.access(output if output.exists() else folder, os.W_OK):
        raise ValueError(f"{output} cannot be written: name another file with -o FILE, or -o -")


def _from_eds(options: argparse.Namespace, listing: Listing | None) -> Draft:
    entries = listing.entries if listing else []
    return Draft(
        output=options.output,
        source=f"{options.eds}",
        node_id=None,
        bus=_named_bus(options),
        eds=_from_output(options),
        proposals=by_eds(entries, {}),
        indices={known.mux.index for known in entries},
    )


def _from_device(options: argparse.Namespace, listing: Listing | None) -> Draft:
    settings = bus_settings(options, BusSettings())
    link = Link(open_bus(settings), str(settings))
    progress = Progress()
    try:
        channel = Channel(link, options.node_id, options.response_timeout)
        device = read_device(channel, listing, progress)
        found = None if listing else search(channel, device, progress)
    finally:
        link.close()
    source = f"node {options.node_id} on {settings}" + (f" and {options.eds}" if listing else "")
    draft = Draft(
        output=options.output,
        source=source,
        node_id=options.node_id,
        bus=settings,
        eds=_from_output(options),
        proposals=Proposals(),
        indices={mux.index for mux in device.values},
        about=list(about(device)),
    )
    if found is None:
        draft.proposals = by_eds(device.objects, device.values)
        draft.remarks = differences(device)
    else:
        draft.proposals = by_reading(found, options.node_id)
        draft.indices |= found.indices
        draft.remarks = [found.ended] if found.ended else []
    return draft


def _notes(draft: Draft) -> Iterator[str]:
    """Yield the findings, in a few lines."""
    yield from draft.about
    yield from draft.remarks[:MOST_REMARKS]
    if len(draft.remarks) > MOST_REMARKS:
        yield f"{len(draft.remarks) - MOST_REMARKS} more differences: see the file"
    proposals = draft.proposals
    yield (
        f"proposed as writable: {len(proposals.own)} of the device's own objects, "
        f"{len(proposals.profile)} of its profile; all are comments until you delete their #"
    )


def _named_bus(options: argparse.Namespace) -> BusSettings | None:
    """Return the bus if the command line names one."""
    named = options.can_interface or options.can_channel or options.can_bitrate
    return bus_settings(options, BusSettings()) if named or options.can_option else None


def _from_output(options: argparse.Namespace) -> str | None:
    """Return the path of the EDS as it has to be written in the file."""
    if options.eds is None:
        return None
    folder = Path() if options.output == STANDARD_OUTPUT else options.output.parent
    try:
        return Path(os.path.relpath(options.eds, folder)).as_posix()
    except ValueError:  # on another drive
        return Path(options.eds).resolve().as_posix()


class Progress:
    """Says how far a reading is, if it takes long."""

    def __init__(self) -> None:
        """Begin now."""
        self._said = self._begin = time.monotonic()

    def __call__(self, read: object, number: int, count: int) -> None:
        """Take the object that is read next, behind ``number`` of ``count`` others."""
        now = time.monotonic()
        if number == 0:
            self._begin = now
        if now < self._said + OFTEN or not number:
            return
        self._said = now
        left = (now - self._begin) / number * (count - number)
        tell([f"reading {read}, about {left:.0f} s left"])
