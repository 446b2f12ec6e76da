"""What the objects of a device hold: their own values, from before the run, or what came since.

Every request that is sent is shown to ``Contents``, and so is every value that is read. Each change
is told to the journal before it is made; from there on its object is ``outstanding`` until it was
seen to hold its own value again.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

from conformance.device.change_journal import (
    BACK,
    CHANGED,
    STORED,
    STORED_AGAIN,
    TAKEN,
    Tell,
    Values,
    untold,
)
from conformance.device.effort import (
    ENDLESS,
    LITTLE_PADDING,
    LONGEST_STATED_TEXT,
    LONGEST_TEXT,
    PADDING,
    UPLOADED,
)
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.sdo.emergency import ERROR_LIST
from conformance.sdo.frames import (
    BlockDownloadInitiate,
    BlockSegment,
    DownloadInitiate,
    DownloadSegment,
    Request,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import SEGMENT_LENGTH
from conformance.sdo.nmt import NmtCommand
from conformance.sdo.objects import TEXT_TYPES, Access
from conformance.sdo.storage_commands import COMMANDS

LAST_COMMUNICATION_PARAMETER = 0x1FFF


class Holds(Enum):
    """What an object holds.

    OWN: its own value. PRESUMED: its own value, if the device has done as it should: the value was
    written back, or the object held it when a reset came, and was not read since. LEFT: another
    value, which a case has left in a string or domain. UNKNOWN: whatever the running case has
    written, or an earlier one, behind which its own value could not be put back.
    """

    OWN = auto()
    PRESUMED = auto()
    LEFT = auto()
    UNKNOWN = auto()


@dataclass(slots=True)
class Brought:
    """The bytes that a device may have taken of the latest download to an object, and of any.

    ``is_empty`` as long as the latest has brought none.
    """

    size: int = 0
    most: int = 0
    is_empty: bool = False


@dataclass(slots=True)
class Contents:
    """What each object of one device holds, and what has to be there again.

    ``own`` has the values that were read when the run began, ``parameters`` those of communication
    parameters before the first write that a permission allows, and of read-only objects that have
    taken a write. ``current`` is what objects read since anything was sent that might have changed
    one. ``outstanding`` are the values of before of all that may hold another one now; ``taken``
    are objects that could not be read and have taken a write: nobody knows what they held.

    ``to_store`` is what the device had stored and a case has changed: it is stored again.
    ``stored`` is what was found to be stored and no default, None where that is not known, or
    something was stored since. ``brought_back`` are the objects that a reset was seen to bring back
    as they have to be, by its command, since anything was stored: the next one will. ``endless``
    counts uploads that had no end. ``is_used``: anything was written, or reset. ``tell`` is handed
    each change before it is made, and what is back.
    """

    own: Values = field(default_factory=dict)
    known: Mapping[Multiplexer, KnownObject] = field(default_factory=dict)
    parameters: Values = field(default_factory=dict)
    current: Values = field(default_factory=dict)
    outstanding: Values = field(default_factory=dict)
    taken: set[Multiplexer] = field(default_factory=set)
    to_store: Mapping[Multiplexer, bytes] = field(default_factory=dict)
    stored: Mapping[Multiplexer, bytes] | None = None
    brought_back: defaultdict[NmtCommand, set[Multiplexer]] = field(
        default_factory=lambda: defaultdict(set)
    )
    endless: int = 0
    is_used: bool = False
    tell: Tell = untold
    # What does not hold its own value for certain.
    _others: dict[Multiplexer, Holds] = field(default_factory=dict)
    _brought: defaultdict[Multiplexer, Brought] = field(
        default_factory=lambda: defaultdict(Brought)
    )
    # By the latest download: that to no object as long as there was none.
    _open: Brought = field(default_factory=Brought)

    # What an object holds

    def holds(self, mux: Multiplexer) -> Holds:
        """Return which value an object holds."""
        return self._others.get(mux, Holds.OWN)

    def value(self, mux: Multiplexer) -> bytes | None:
        """Return what an object holds that only the suite writes; None where that is not known."""
        return self.own.get(mux) if self.holds(mux) is Holds.OWN else self.current.get(mux)

    def read_last(self, mux: Multiplexer) -> bytes | None:
        """Return what an object read last, if it was ever read."""
        return self.current.get(mux, self.own.get(mux))

    def kept(self, mux: Multiplexer) -> bytes | None:
        """Return the value that an object has to have again.

        So has a constant: a wrong device may take what it has to refuse. What is read-only may
        change by itself, and has one only once a write to it was confirmed.
        """
        known = self.known.get(mux)
        keeps = (
            known is not None
            and (known.access.writable or known.access is Access.CONST)
            and mux.index not in (ERROR_LIST, *COMMANDS)
        )
        return self.own[mux] if keeps and mux in self.own else self.parameters.get(mux)

    def due(self, changed: Iterable[Multiplexer]) -> Values:
        """Return the values that objects have to have again."""
        due = ((mux, self.kept(mux)) for mux in sorted(changed))
        return {mux: value for mux, value in due if value is not None}

    def left(self, *states: Holds) -> set[Multiplexer]:
        """Return what may hold another value until a case needs its own, or the run ends."""
        states = states or (Holds.LEFT, Holds.PRESUMED)
        return {mux for mux, holds in self._others.items() if holds in states}

    def may_be_left(self, mux: Multiplexer) -> bool:
        """Say whether an object may stay as a case has left it until another needs what it held.

        A string or domain that the user has named does nothing by what it holds. A number may, and
        so may any communication parameter.
        """
        known = self.known.get(mux)
        return known is not None and known.varies and mux.index > LAST_COMMUNICATION_PARAMETER

    # What changes it

    def sent(self, request: Request) -> None:
        """Take a request that goes out: whatever a device takes of its data, it is not more."""
        match request:
            case BlockSegment() | DownloadSegment():
                no_data = isinstance(request, DownloadSegment) and not request.data
                self._open.is_empty = self._open.is_empty and no_data
                size = self._open.size = self._open.size + SEGMENT_LENGTH
                if size > self._open.most:
                    self._open.most = size
            case DownloadInitiate() | BlockDownloadInitiate():
                self.is_used = True
                self._open = self._brought[request.mux]
                self._open.size = 0
                expedited = isinstance(request, DownloadInitiate) and request.expedited
                self._open.is_empty = not expedited
                if request.mux.index in COMMANDS and request.mux.sub_index:
                    self.brought_back.clear()
                    self.stored = None

    def will_change(self, mux: Multiplexer) -> None:
        """Note, before it is done, that an object may be changed."""
        value = self.kept(mux)
        if value is None:
            return
        self.lose(mux)
        if mux in self.outstanding:
            return
        known = self.known.get(mux)
        data_type = None if known is None else known.data_type
        kind = {} if data_type is None else {"type": data_type.name}
        self.tell({"record": CHANGED, "object": str(mux), "value": value.hex(), **kind})
        self.outstanding[mux] = value

    def takes(self, mux: Multiplexer) -> None:
        """Note that an object that could not be read has taken a write."""
        if mux not in self.taken:
            self.taken.add(mux)
            self.tell({"record": TAKEN, "object": str(mux)})

    def reset(self, command: NmtCommand, muxes: Iterable[Multiplexer]) -> set[Multiplexer]:
        """Note that a reset may change objects; return these: not what the next one brings back."""
        brought_back = self.brought_back[command]
        changed = set(muxes) - brought_back
        presumed = {mux for mux in changed if self.holds(mux) in (Holds.OWN, Holds.PRESUMED)}
        presumed |= brought_back & self.left()
        for mux in changed:
            self.is_used = True
            self.will_change(mux)
        self._others |= dict.fromkeys(presumed, Holds.PRESUMED)
        return changed

    def leave(self, mux: Multiplexer) -> None:
        """Take that an object stays as a case has left it."""
        if self.holds(mux) is not Holds.PRESUMED:
            self._others[mux] = Holds.LEFT

    def presume(self, mux: Multiplexer) -> None:
        """Take that an object holds its own value again, though nobody has read it."""
        self._others[mux] = Holds.PRESUMED

    def lose(self, mux: Multiplexer) -> None:
        """Take that an object may hold anything, unless a case has left another value there."""
        if self.holds(mux) is not Holds.LEFT:
            self._others[mux] = Holds.UNKNOWN

    def settle(self, mux: Multiplexer) -> None:
        """Take that an object holds its own value again, as it was written back."""
        self._others.pop(mux, None)

    def is_back(self, mux: Multiplexer, value: bytes) -> None:
        """Take that an object was seen to hold a value; it is back if that is its own."""
        if value == self.kept(mux):
            self.settle(mux)
        if self.outstanding.get(mux) == value:
            del self.outstanding[mux]
            self.tell({"record": BACK, "object": str(mux)})

    def case_begins(self) -> None:
        """Forget what was read, unless only the suite writes it: that reads the same again."""
        for mux in self.current.keys() - self.left():
            del self.current[mux]

    # What the device has stored

    def will_lose(self, stored: Mapping[Multiplexer, bytes]) -> None:
        """Take that something else is about to be stored than this: it is stored again."""
        self.to_store = stored
        if stored:
            values = {str(mux): data.hex() for mux, data in stored.items()}
            self.tell({"record": STORED, "values": values})

    def nothing_was_lost(self) -> None:
        """Take that it is stored still."""
        self.stored = self.to_store
        self.is_stored_again()

    def is_stored_again(self) -> None:
        """Take that what was stored before is stored again."""
        if self.to_store:
            self.tell({"record": STORED_AGAIN})
        self.to_store = {}

    # How much an object can hold

    def latest(self, mux: Multiplexer) -> Brought:
        """Return what the latest download to an object has brought."""
        return self._brought.get(mux, Brought())

    def longest(self, mux: Multiplexer) -> int:
        """Return the most bytes that an upload of an object may bring: with more it has no end.

        That follows from its type, from its own value, and from what was written to it since. Of an
        object that the device itself changes, or that was not read yet, nothing is known: there a
        text is taken for no book, and anything else may have a mebibyte; less once the device was
        seen to bring data without an end. An object of one length may bring a segment more before
        it is stopped: that its value is too long is then for others to say.
        """
        known, own = self.known.get(mux), self.own.get(mux)
        if known is not None and known.length is not None:
            return known.length + SEGMENT_LENGTH
        allowed = next(most for endless, most in UPLOADED if self.endless <= endless)
        if known is None:
            return allowed
        brought = self._brought.get(mux)
        is_cut = known.is_steady and not known.habits.keeps_tails
        if own is not None and is_cut and self.endless > ENDLESS:
            latest = len(own) if brought is None else brought.size
            return max(latest, known.habits.filled) + LITTLE_PADDING
        most = 0 if brought is None else brought.most
        least = max(len(own or b""), len(known.stated or b""), known.habits.filled, most)
        if own is not None and known.is_steady:
            return least + PADDING
        if known.data_type in TEXT_TYPES:
            allowed = min(allowed, LONGEST_STATED_TEXT if known.stated else LONGEST_TEXT)
        return least + allowed


@dataclass(slots=True)
class Defaults:
    """What each parameter reads with the defaults loaded; they are loaded once in a run.

    ``values`` are None as long as they were not loaded; ``why_not`` says why they cannot be.
    """

    values: Mapping[Multiplexer, bytes] | None = None
    why_not: NotTestable | None = None
