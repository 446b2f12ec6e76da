"""What a run has to have tested to be green: a share of its cases, services, rules, steps."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import floor

from conformance.reporting.official_steps import OFFICIAL_STEPS, OfficialStep
from conformance.reporting.summary import counted, lacks
from conformance.run.case_files import case_files
from conformance.run.verdict import CaseResult, Verdict
from conformance.sdo.nearest import meant
from conformance.sdo.rules import RULES_BY_ID

TESTED = frozenset(
    {
        *(Verdict.PASS, Verdict.NON_STRICT, Verdict.INFO),
        *(Verdict.FAIL, Verdict.KNOWN_DEVIATION, Verdict.STALE),
    }
)
# A refusal of an optional service is a result, though not of what the service does.
ANSWERED = TESTED | {Verdict.UNIMPLEMENTED}
MOST_REASONS = 3
IsAbout = Callable[[CaseResult], bool]


class RequirementError(ValueError):
    """A text names nothing that could be required."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """What is required, as written: a ``share`` in percent, or a tested case of each part."""

    text: str
    share: float | None = None
    parts: Mapping[str, IsAbout] = field(default_factory=dict)

    def missing(self, results: Sequence[CaseResult]) -> Iterator[str]:
        """Yield a sentence for each thing that the results of a device do not show."""
        if self.share is not None:
            yield from self._missing_share(self.share, results)
        for name, is_about in self.parts.items():
            cases = [result for result in results if is_about(result)]
            if not cases:
                yield f"{name}: the run had no case on it"
            elif not any(case.verdict in TESTED for case in cases):
                yield f"{name}: none of {counted(len(cases))} was tested: {_why(cases, TESTED)}"

    def _missing_share(self, share: float, results: Sequence[CaseResult]) -> Iterator[str]:
        answered = sum(result.verdict in ANSWERED for result in results)
        if answered * 100 < share * len(results):
            percent = floor(answered * 100 / len(results))
            yield (
                f"{answered} of {counted(len(results))} ({percent} %) were tested: "
                f"{_why(results, ANSWERED)}"
            )


def _why(results: Sequence[CaseResult], enough: frozenset[Verdict]) -> str:
    """Return what keeps most cases from being tested, and so what to add."""
    reasons = lacks(
        (
            result,
            f"the device refuses it: {result.actual}"
            if result.verdict is Verdict.UNIMPLEMENTED
            else result.actual,
        )
        for result in results
        if result.verdict not in enough
    )
    said = [f"{reason} ({counted(cases)})" for reason, cases in reasons[:MOST_REASONS]]
    return "; ".join(said)


def parse_requirement(text: str) -> Requirement:
    """Read ``90%``, the words of a service, the id of a rule, or an official step.

    Raises RequirementError.
    """
    name = " ".join(text.split())
    if name.endswith("%"):
        return Requirement(name, share=_share(name))
    steps = {step.name: step for step in OFFICIAL_STEPS}
    if name.upper() in steps:
        return Requirement(name, parts={name.upper(): _by_step(steps[name.upper()])})
    if name in RULES_BY_ID:
        return Requirement(name, parts={name: lambda result: name in result.tested_rules})
    services = {service_of.removeprefix("test_").replace("_", " ") for service_of in _stems()}
    words = set(name.lower().split())
    found = sorted(service for service in services if words and words <= set(service.split()))
    if found:
        return Requirement(name, parts={service: _by_service(service) for service in found})
    parts = {word for service in services for word in service.split()}
    known = [*steps, *RULES_BY_ID, *sorted(services | parts)]
    raise RequirementError(
        f"{text!r} is no share such as 90%, no service such as block, no rule and no official "
        f"step such as 'SDO 09'.{meant(name, known)}"
    )


def _share(name: str) -> float:
    try:
        share = float(name.removesuffix("%"))
    except ValueError:
        share = -1.0
    if not 0 <= share <= 100:
        raise RequirementError(f"{name!r} is no share: write 0% to 100%")
    return share


def _stems() -> list[str]:
    return [path.stem for path in case_files()]


def _by_service(service: str) -> IsAbout:
    return lambda result: result.service == service


def _by_step(step: OfficialStep) -> IsAbout:
    return lambda result: result.case_id.startswith(step.stems)


def untested(
    requirements: Sequence[Requirement], results: Sequence[CaseResult], node_ids: Sequence[int]
) -> list[str]:
    """Return a sentence for each requirement that a device does not meet, and for each part."""
    lines = []
    for node_id in node_ids:
        of_device = [result for result in results if result.node_id == node_id]
        device = "" if len(node_ids) == 1 else f"node {node_id}: "
        for required in requirements:
            lines += [
                f"{device}--sdo-require={required.text!r}: {sentence}"
                for sentence in required.missing(of_device)
            ]
    return lines
