"""The first lines of results.jsonl: the run, and each of its devices."""

import hashlib
import platform
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from conformance import __version__
from conformance.device.device import TEXTS, Device
from conformance.device.effort import Effort
from conformance.device.options import BUDGET, DEVICE, EDS
from conformance.eds.reading import read_file
from conformance.plugin.state import RunState
from conformance.reporting.summary import device_properties, run_properties
from conformance.sdo.cob_id import ChannelIds

# So many findings go into the record of a run; conformance eds shows all.
MOST_FINDINGS = 300
_PACKAGES = ("pytest", "python-can", "canopen", "hypothesis")


def about_run(config: pytest.Config, state: RunState) -> dict[str, Any]:
    """Describe a run: its options, its bus, and the versions of the programs."""
    options = state.options
    run = options.run
    given = options.given
    eds, device = given[EDS], given[DEVICE]
    return {
        "begun": state.begun.astimezone().isoformat(timespec="milliseconds"),
        "begun_utc": f"{state.begun:%Y-%m-%dT%H:%M:%S}",
        "suite": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "host": platform.node(),
        "packages": {name: version(name) for name in _PACKAGES},
        "command": [sys.argv[0], *map(str, config.invocation_params.args)],
        "folder": str(config.invocation_params.dir),
        "node_ids": options.node_ids,
        "interface": run.bus.interface,
        "channel": run.bus.channel,
        "bitrate": run.bus.bitrate,
        "bus_options": dict(run.bus.options),
        "bus_arguments": run.bus.arguments,
        "self_test": options.self_test,
        "server": options.server,
        "eds": None if eds is None else {**_file(eds), **_about_eds(eds, options.node_ids[0])},
        "description": None if device is None else _file(device),
        "permissions": sorted(run.permits.permissions),
        "writable": [str(known.mux) for known in run.permits.named if known.access.writable],
        "all_rw": run.permits.all_rw,
        "response_timeout": run.response_timeout,
        "server_timeout": run.server_timeout,
        "seed": run.seed,
        "examples": options.examples,
        "budget": given[BUDGET],
        "quick": options.effort is Effort.HASTE,
        "strict": options.strict,
        "properties": run_properties(run),
    }


def _about_eds(path: Path, node_id: int) -> dict[str, Any]:
    """Return what the description of the devices lists, and what is wrong with it."""
    file = read_file(path, node_id)
    return {
        "revision": file.listing.revision,
        "objects": sum(bool(listed.entries) for listed in file.listing.objects.values()),
        "entries": len(file.listing.entries),
        "findings": file.records[:MOST_FINDINGS],
    }


def _file(path: Path) -> dict[str, str]:
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        digest = str(error)
    return {"name": str(path), "sha256": digest}


def about_device(device: Device, ids: ChannelIds, *, alone: bool) -> dict[str, Any]:
    """Describe a discovered device on this channel; it may be ``alone`` in its run."""
    return {
        "node_id": device.node_id,
        "sdo_channel": ids.in_digits,
        "identity": device.identity,
        "texts": {
            str(mux): device.values[mux].decode("ascii", "backslashreplace")
            for mux in TEXTS
            if mux in device.values
        },
        "properties": device_properties(device, alone=alone),
    }
