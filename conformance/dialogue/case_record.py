"""What is found and done in one case, on however many channels it talks to the device."""

from collections import Counter
from dataclasses import dataclass, field

from conformance.dialogue.causes import Causes
from conformance.dialogue.pauses import Pauses
from conformance.dialogue.server_aborts import EarlyAborts
from conformance.sdo.cob_id import ChannelIds
from conformance.sdo.frames import Request
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.rules import Cause, Rule, Violation
from conformance.sdo.rules.block_upload import ENDS
from conformance.sdo.rules.defects import BEHIND_LAST, NOT_STORED

MOST_NOTED = 100


@dataclass(slots=True, eq=False)
class CaseRecord:
    """One case: the ``rule`` that it is about, what it has met, and what it has changed.

    ``causes`` is what is known to be wrong with the device. ``minor`` are breaches that stop
    nothing; ``own`` has breaches that are what the case is about, whatever their rules. ``notes``
    are for the reader of the result. ``written`` are the objects that may have changed, and
    ``reset`` those that a reset has changed last, by its command. ``early`` are the aborts by which
    the server left a transfer, ``channels`` those on which the case has talked, and ``pauses`` the
    silences of the bench on each of them. It is ``in_case`` while the
    case itself runs, and not what goes before it or behind it.
    """

    rule: Rule
    causes: Causes = field(default_factory=Causes)
    minor: list[Violation] = field(default_factory=list)
    own: set[BaseException | None] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)
    written: set[Multiplexer] = field(default_factory=set)
    reset: dict[Multiplexer, NmtCommand] = field(default_factory=dict)
    early: EarlyAborts = field(default_factory=EarlyAborts)
    channels: list[ChannelIds] = field(default_factory=list)
    pauses: list[Pauses] = field(default_factory=list)
    in_case: bool = False
    _noted: Counter[str] = field(default_factory=Counter)

    def note(self, violation: Violation, asked: Request) -> None:
        """Keep a breach that does not stop a transfer; of very many of a rule the first ones.

        ``asked`` is what was sent last: it was broken behind that, unless it says otherwise.
        """
        self._noted[violation.rule.id] += 1
        if self._noted[violation.rule.id] <= MOST_NOTED:
            violation.asked = violation.asked or asked
            self.minor.append(violation)

    def waited(self) -> None:
        """Take that the case has waited up to now for an answer that has not come, on any channel.

        No channel may excuse with that what its server does.
        """
        for each in self.pauses:
            each.waited()

    def cause_of(self, violation: Violation, asked: Request) -> Cause:
        """Return the cause of a breach: it followed its own request, or the one ``asked`` last."""
        return self.causes.of(violation, violation.rule, violation.asked or asked)

    def explains(self) -> Cause | None:
        """Return the cause of whatever ends the case, where that was met before.

        Behind a download, a device that stores nothing holds another value than the case takes it
        for. A segment behind the last one stands for the answers to all that is asked then.
        """
        if self.written and self.causes.nothing_is_stored:
            return NOT_STORED
        return BEHIND_LAST if any(found.rule is ENDS for found in self.minor) else None

    def is_known(self, error: BaseException | None, asked: Request) -> bool:
        """Say whether a breach has a cause that was met before, by whatever rule it was told."""
        if not isinstance(error, Violation):
            return False
        request = error.asked or asked
        cause = self.causes.told_as(
            self.cause_of(error, asked), request, self.rule.id, generated=False
        )
        return self.causes.get(cause) is not None
