"""What a run says at its end, and what describes it in every report."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence

from conformance import __version__
from conformance.device.device import Device
from conformance.device.not_testable import Missing
from conformance.run.bench import RunSettings
from conformance.run.verdict import NOT_TESTED, CaseResult, Verdict
from conformance.sdo.describe import in_words

FOUND = "found-by-reading"
# What a device refuses by its state.
BY_STATE = "serves-by-state"
# Which cases a quick run has left out.
QUICK = "quick"
# So many lines of a kind are shown unless all are wanted; what is missing says what to do.
MOST_REMARKS, MOST_REASONS = 3, 8
# Seconds; a run that waited less in total has not waited.
SHORTEST_WAIT = 0.05
# Values of more bytes than one frame takes count alike.
LONG = 5


def run_properties(settings: RunSettings) -> dict[str, str]:
    """Return the data of the run, as names and values."""
    return {
        "suite-version": __version__,
        "bus": str(settings.bus),
        "bit-rate": str(settings.bus.bitrate or "as the interface is set"),
        "response-timeout-ms": f"{settings.response_timeout * 1000:g}",
        "seed": str(settings.seed),
        "writable-objects": written_objects(
            [str(known) for known in settings.permits.named if known.access.writable],
            all_rw=settings.permits.all_rw,
        ),
    }


def written_objects(named: Sequence[str], *, all_rw: bool) -> str:
    """Say what may be written: objects by name, or ``all_rw``; empty for nothing."""
    every = ["all from 2000h on that the EDS says can be written"] if all_rw else []
    return ", ".join([*every, *named])


def device_properties(device: Device, *, alone: bool) -> dict[str, str]:
    """Return the node-ID and the identity (1018h) of a device; it may be ``alone`` in its run.

    Of a device without an EDS it says as well what was found by reading.
    """
    prefix = "" if alone else f"node-{device.node_id}."
    values = {"node-id": str(device.node_id), **device.identity}
    if not device.listing.is_complete:
        values[FOUND] = found_by_reading(device)
    if facts := device.learned.serving.lines():
        values[BY_STATE] = "; ".join(facts)
    return {f"{prefix}{name}": value for name, value in values.items()}


def found_by_reading(device: Device) -> str:
    """Say how many objects a device let read, how long they are, and whether in blocks."""
    lengths = Counter(min(len(value), LONG) for value in device.values.values())
    counts = [
        f"{'more' if length == LONG else length}: {count}"
        for length, count in sorted(lengths.items())
    ]
    found = f"{len(device.values)} objects"
    if counts:
        longest = max(device.values, key=lambda mux: (len(device.values[mux]), mux))
        found += f", by length in bytes {', '.join(counts)} (up to {len(device.values[longest])}, "
        found += f"{longest})"
    refusal = device.learned.block_upload_refusal
    served = f"refused ({in_words(refusal)})" if refusal else "served"
    blocks = "unknown" if refusal is None else served
    return f"{found}; block upload: {blocks}"


def found_lines(properties: Mapping[str, str]) -> list[str]:
    """Return the lines on what was found by reading, and on what a quick run has left out."""
    return [
        f"{name.replace('-', ' ').replace('.', ': ')}: {value}"
        for name, value in properties.items()
        if name.endswith((FOUND, BY_STATE, QUICK))
    ]


def device_lines(node_ids: Sequence[int], results: Sequence[CaseResult]) -> list[str]:
    """Return a row for each device: its verdicts with their numbers. None for a single device."""
    if len(node_ids) < 2:
        return []
    lines = []
    for node_id in node_ids:
        row = verdict_counts([result for result in results if result.node_id == node_id])
        lines.append(f"node {node_id}: {', '.join(row) or 'no case was run'}")
    return lines


def verdict_counts(results: Sequence[CaseResult]) -> list[str]:
    """Return each verdict that was given, with its number."""
    counts = Counter(result.verdict for result in results)
    return [f"{counts[verdict]} {verdict.value}" for verdict in Verdict if counts[verdict]]


def tested_share(results: Sequence[CaseResult]) -> str:
    """Say how many cases say something of the device, and of how many.

    >>> tested_share([])
    '0 cases tested'
    """
    tested = sum(result.verdict not in NOT_TESTED for result in results)
    of_all = "" if tested == len(results) else f" of {len(results)}"
    return f"{tested}{of_all} {'case' if len(results) == 1 else 'cases'} tested"


def summary_lines(results: Sequence[CaseResult], *, whole: bool) -> list[str]:
    """Return the number of each verdict, and what is to be said of those that did not just pass.

    ``whole``: all of what else would be long.
    """
    waited = sum(result.waited for result in results)
    return [
        ", ".join(verdict_counts(results)),
        *_share_lines(results),
        *_remark_lines(results, whole=whole),
        *_known_lines(results),
        *(_progress_lines(results) if whole else []),
        *_missing_lines(results, whole=whole),
        *(
            [f"waited {waited:.1f} s in total for answers that did not come"]
            if waited >= SHORTEST_WAIT
            else []
        ),
    ]


def _share_lines(results: Sequence[CaseResult]) -> list[str]:
    """Return the share of the cases that were tested, where some were not."""
    tested = sum(result.verdict not in NOT_TESTED for result in results)
    if tested == len(results):
        return []
    return [f"{tested_share(results)} ({100 * tested // len(results)} %)"]


def _remark_lines(results: Sequence[CaseResult], *, whole: bool) -> list[str]:
    """Return a line for each result that passed with a remark."""
    lines = dict.fromkeys(  # several devices may say the same
        f"{result.verdict.value}: {result.case_id}: {result.actual or '; '.join(result.notes)}"
        for verdict in (Verdict.NON_STRICT, Verdict.INFO)
        for result in results
        if result.verdict is verdict
    )
    return list(lines) if whole else _first(list(lines), MOST_REMARKS, "more with a remark")


def _progress_lines(results: Sequence[CaseResult]) -> list[str]:
    """Return how far random cases came; one that had no time for all has a remark as well."""
    searches = (result for result in results if result.progress)
    return list(dict.fromkeys(f"{result.case_id}: {result.progress}" for result in searches))


def _missing_lines(results: Sequence[CaseResult], *, whole: bool) -> list[str]:
    """Return a line for each thing that cases lack, most cases first."""
    missing = lacks(
        (result, result.actual)
        for result in results
        if result.verdict is Verdict.NOT_TESTABLE and not result.cause
    )
    lines = [f"not testable ({counted(cases)}): {reason}" for reason, cases in missing]
    more = "more reasons why cases are not testable"
    return lines if whole else _first(lines, MOST_REASONS, more)


def lacks(reasons: Iterable[tuple[CaseResult, str]]) -> list[tuple[str, int]]:
    """Return what cases lack with their number, most first; what one addition gives is one reason.

    Each case has its reason in words; that of one addition is told in the words of most cases.
    """
    groups: defaultdict[Missing | str, Counter[str]] = defaultdict(Counter)
    for result, reason in reasons:
        groups[result.missing or reason][reason] += 1
    told = [(words.most_common(1)[0][0], words.total()) for words in groups.values()]
    return sorted(told, key=lambda reason: -reason[1])


def _first(lines: list[str], most: int, more: str) -> list[str]:
    """Return the lines, or the first of many and how many more there are."""
    if len(lines) <= most + 1:
        return lines
    return [*lines[:most], f"{len(lines) - most} {more}: see the reports, or -v"]


def _known_lines(results: Sequence[CaseResult]) -> list[str]:
    """Return a line for each reason why cases may fail, and how many it has excused."""
    excused: dict[str, list[str]] = {}
    for result in results:
        if result.verdict is Verdict.KNOWN_DEVIATION:
            excused.setdefault(result.reason, []).append(result.case_id)
    return [
        f"{Verdict.KNOWN_DEVIATION.value}: {cases[0]}{_and_more(cases)}: {reason}"
        for reason, cases in excused.items()
    ]


def _and_more(cases: Sequence[str]) -> str:
    return f" and {counted(len(cases) - 1)} more" if len(cases) > 1 else ""


def not_run_lines(results: Sequence[CaseResult]) -> list[str]:
    """Return a line for each reason why cases of a device were not run."""
    missing = Counter(
        (result.node_id, result.actual) for result in results if result.verdict is Verdict.NOT_RUN
    )
    return [
        f"not run: {counted(cases)} of node {node_id}: {reason}"
        for (node_id, reason), cases in missing.items()
    ]


def counted(cases: int) -> str:
    """Write a number of cases."""
    return "1 case" if cases == 1 else f"{cases} cases"
