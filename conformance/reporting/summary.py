"""What a run says at its end, and what describes it in every report."""

from collections import Counter
from collections.abc import Sequence

from conformance import __version__
from conformance.device.device import Device
from conformance.run.bench import RunSettings
from conformance.run.verdict import CaseResult, Verdict


def run_properties(settings: RunSettings, devices: Sequence[Device]) -> dict[str, str]:
    """Return the identity of the devices (1018h) and the data of the run, as names and values."""
    properties = {
        "suite-version": __version__,
        "bus": str(settings.bus),
        "bit-rate": str(settings.bus.bitrate or "as the interface is set"),
        "response-timeout-ms": f"{settings.response_timeout * 1000:g}",
        "seed": str(settings.seed),
        "writable-objects": ", ".join(
            str(known) for known in settings.objects if known.access.writable
        ),
    }
    for device in devices:
        prefix = f"node-{device.node_id}." if len(devices) > 1 else ""
        properties[f"{prefix}node-id"] = str(device.node_id)
        for name, value in device.identity.items():
            properties[f"{prefix}{name}"] = value
    return properties


def summary_lines(results: Sequence[CaseResult]) -> list[str]:
    """Return the verdicts with their numbers, and each result that passed with a remark."""
    counts = Counter(result.verdict for result in results)
    lines = [
        ", ".join(f"{counts[verdict]} {verdict.value}" for verdict in Verdict if counts[verdict])
    ]
    lines += [
        f"{result.verdict.value}: {result.case_id}: {result.actual or '; '.join(result.notes)}"
        for result in results
        if result.verdict in (Verdict.NON_STRICT, Verdict.INFO)
    ]
    lines += [f"{result.case_id}: {result.progress}" for result in results if result.progress]
    missing = {
        result.actual: result.case_id
        for result in results
        if result.verdict is Verdict.NOT_TESTABLE
    }
    for reason in missing:
        cases = sum(result.actual == reason for result in results)
        lines.append(f"not testable ({cases} cases): {reason}")
    waited = sum(result.waited for result in results)
    if waited > 0:
        lines.append(f"waited {waited:.1f} s in all for answers that did not come")
    return lines
