"""What a device has to hold again as before the run, beside the values of its objects."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from conformance.device.change_journal import Changes
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand


@dataclass(slots=True)
class Keeping:
    """What cases have changed, or are about to, and what has to be there again.

    ``parameters`` holds the values of communication parameters that cases write by permission,
    before the first write. ``to_store`` is what the device had stored and a case has changed: it is
    stored again. ``stored`` is what was found to be stored and no default, None where that is not
    known, or something was stored since. ``left`` are strings and domains as cases have left them:
    what they held before is put back where a case needs it, and at the end of the run. ``doubtful``
    are those that ought to hold it and were not read since: it was written, or they held it when a
    reset came. ``astray``
    are objects that a case has written and that could not be put back: what they hold is not known.
    ``seen`` is what objects read since anything was sent that might have changed one.
    ``brought_back`` are those that a reset was seen to bring back as they have to be, by its
    command, since anything was stored: the next one will. ``changes`` are told before they are
    made.
    """

    parameters: dict[Multiplexer, bytes] = field(default_factory=dict)
    to_store: Mapping[Multiplexer, bytes] = field(default_factory=dict)
    stored: Mapping[Multiplexer, bytes] | None = None
    left: set[Multiplexer] = field(default_factory=set)
    doubtful: set[Multiplexer] = field(default_factory=set)
    astray: set[Multiplexer] = field(default_factory=set)
    seen: dict[Multiplexer, bytes] = field(default_factory=dict)
    brought_back: defaultdict[NmtCommand, set[Multiplexer]] = field(
        default_factory=lambda: defaultdict(set)
    )
    changes: Changes = field(default_factory=Changes)

    def will_lose(self, stored: Mapping[Multiplexer, bytes]) -> None:
        """Take that something else is about to be stored than this: it is stored again."""
        self.to_store = stored
        self.changes.stores(stored)

    def nothing_was_lost(self) -> None:
        """Take that it is stored still."""
        self.stored, self.to_store = self.to_store, {}
        self.changes.is_stored_again()


@dataclass(slots=True)
class Defaults:
    """What each parameter reads with the defaults loaded; they are loaded once in a run.

    ``values`` are None as long as they were not loaded; ``why_not`` says why they cannot be.
    """

    values: Mapping[Multiplexer, bytes] | None = None
    why_not: str = ""
