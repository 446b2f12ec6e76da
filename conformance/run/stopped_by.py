"""Cases that have stopped a device in this run: the same is not tried again and again.

A device that can be brought back is lost as often as it takes to know why. A cause is the kind of
stimulus that a case is about, or the case itself, in all its variations, where it did not come to
that. A cause that has stopped the device twice is not tried a third time.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from conformance.device.effort import MOST_LOSSES
from conformance.run.risks import Risk
from conformance.sdo.can_frame import CanFrame

# A device that is lost in this number of ordinary cases in a row does not run at all. Other cases
# may well stop it that often.
MOST_IN_A_ROW = 20


@dataclass(slots=True)
class Losses:
    """The cases in which one device was lost, by cause; ``total`` is their number."""

    total: int = 0
    _in_a_row: int = 0
    _wrong_in_a_row: int = 0
    _by_cause: dict[str, list[str]] = field(default_factory=dict)
    # The same, without what the device has survived since.
    _open: dict[str, list[str]] = field(default_factory=dict)

    def add(self, case_id: str, risk: Risk | None, sent: Iterable[CanFrame]) -> str:
        """Take a case in which the device was lost after these frames; return the cause."""
        everywhere = risk is not None and risk.is_everywhere
        cause = _of_risk(case_id, risk) if risk and risk.was_met(sent) else _family(case_id)
        self.total += 1
        self._in_a_row += not everywhere
        self._by_cause.setdefault(cause, []).append(case_id)
        self._open.setdefault(cause, []).append(case_id)
        return cause

    def survived(self, case_id: str) -> None:
        """Take a case that the device survived: so it is not the case itself that stops it."""
        self._in_a_row = 0
        if len(self._open.get(_family(case_id), ())) < MOST_LOSSES:
            self._open.pop(_family(case_id), None)

    def is_wedged(self, *, answers_wrongly: bool) -> bool:
        """Say whether to bring a device back that answers: not what it is asked, not even 1000h.

        Two cases in a row have left it so. Where bringing it back did not help it is left alone.
        """
        self._wrong_in_a_row = self._wrong_in_a_row + 1 if answers_wrongly else 0
        return self._wrong_in_a_row == MOST_LOSSES

    @property
    def is_hopeless(self) -> bool:
        """Whether bringing the device back leads nowhere."""
        return self._in_a_row >= MOST_IN_A_ROW

    def why_not(self, case_id: str, risk: Risk | None) -> str:
        """Say why a case is not to be tried; empty where it is."""
        causes = [_family(case_id), *([_of_risk(case_id, risk)] if risk else [])]
        for cause in causes:
            stopped = self._open.get(cause, [])
            if len(stopped) >= MOST_LOSSES:
                cases = " and ".join(stopped[:MOST_LOSSES])
                return f"{cause} has stopped the device twice (in {cases})"
        return ""

    def lines(self) -> list[str]:
        """Return a line for each cause."""
        return [
            f"{cause} stopped the device: {', '.join(cases)}"
            for cause, cases in self._by_cause.items()
        ]


def _of_risk(case_id: str, risk: Risk) -> str:
    return risk.text if risk.is_everywhere else f"{risk.text} in {_family(case_id)}"


def _family(case_id: str) -> str:
    return case_id.partition("[")[0]
