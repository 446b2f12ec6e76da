"""An overview as lines for a terminal."""

from collections.abc import Iterator

from conformance.reporting.overview.runs import Outcome, Overview

_OUTCOME = max(map(len, Outcome))


def overview_lines(overview: Overview) -> Iterator[str]:
    """Yield each device with its runs, the latest first."""
    for device in overview.devices:
        yield f"{device.name} ({device.about})"
        counts = max(len(each.counts) for each in device.runs)
        for each in device.runs:
            yield (
                f"  {each.day} {each.time}  {each.outcome:{_OUTCOME}}  {each.counts:{counts}}  "
                f"{each.folder.name}"
            )
    runs = "1 run" if overview.runs == 1 else f"{overview.runs} runs"
    devices = len(overview.devices)
    yield f"{runs}, {devices} {'device' if devices == 1 else 'devices'}"
