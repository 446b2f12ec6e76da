"""Puts back what cases wrote, by the values of the beginning of the run."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from conformance.device.contents import Holds
from conformance.device.device import DEVICE_TYPE, TWO_SEGMENTS, Device
from conformance.device.effort import (
    LITTLE_PADDING,
    LONG_VALUE,
    SHORT_VALUE,
    SILENCES_OF_OBJECT,
    TRIES_OF_REFUSED,
)
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.channels import Channels, is_cob_id
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.storage import write_signature
from conformance.dialogue.value_access import ValueAccess
from conformance.dialogue.values import restored_value
from conformance.run.leaving import take_the_rest
from conformance.run.pdo_mapping import in_order, is_0_meanwhile, needed_for
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.describe import shown
from conformance.sdo.frames import UploadInitiateResponse
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access
from conformance.sdo.rules import ANSWERED, NOT_REFUSED, UNSOLICITED, Violation
from conformance.sdo.storage_commands import SAVE_ALL


@dataclass(slots=True)
class Restorer:
    """Puts back what cases wrote.

    Strings and domains may stay as a case has left them: another that writes them need not find
    what they held before the run. They are put back for one that does, and at the end of the run.

    ``late`` has what came in the way: answers that belong to none of the requests. What could not
    be put back twice is left alone until the end of the run: else a device that refuses it would be
    written to after each case. A device that is ``gone`` meanwhile is asked no more.
    """

    device: Device
    late: list[Violation] = field(default_factory=list)
    gone: bool = False
    _not_stored: str = ""
    _why: dict[Multiplexer, str] = field(default_factory=dict)
    _tries: Counter[Multiplexer] = field(default_factory=Counter)
    _silences: Counter[Multiplexer] = field(default_factory=Counter)

    @property
    def unrestored(self) -> dict[Multiplexer, str]:
        """What is not back yet: the value due, and why it could not be put back."""
        contents = self.device.contents
        pending = {mux: shown(value) for mux, value in contents.outstanding.items()}
        if not_stored := self._to_store() or self._not_stored:
            pending[SAVE_ALL] = not_stored
        return {mux: text + self._why.get(mux, "") for mux, text in pending.items()}

    def _to_store(self) -> str:
        stored = self.device.contents.to_store
        values = ", ".join(f"{mux} {shown(value)}" for mux, value in stored.items())
        return f'"save" behind what was stored there: {values}' if stored else ""

    def restore(
        self,
        sdo: Dialogue,
        *,
        leaves_values: bool = False,
        in_doubt: bool = False,
        found: Mapping[Multiplexer, bytes | None] | None = None,
    ) -> None:
        """Write the values of the start of the run to what this case wrote, and read them back.

        Where it ``leaves_values``, strings and domains stay as they are: if it is ``in_doubt`` what
        they hold, with a short value in place of a long one. What the case has ``found`` in place
        of a long value it finds again when it is tried again.
        """
        written = {mux for mux in sdo.record.written if self._tries[mux] < TRIES_OF_REFUSED}
        written -= self._as_found(sdo, found or {})
        if leaves_values:
            written -= self._leave(sdo, written, in_doubt=in_doubt)
        else:
            written -= self._left_still(sdo, written)
        self._put_back(sdo, written)
        if self.late or (sdo.record.causes.noisy and sdo.record.written):
            take_the_rest(sdo)

    def put_back_left(self, sdo: Dialogue) -> None:
        """Write what strings and domains held before the run where cases have left them changed."""
        self._put_back(sdo, self.device.contents.left())

    def restore_pending(self, sdo: Dialogue) -> None:
        """Try once more what is listed, as with a device that was lost meanwhile."""
        # Ends what an interrupted case may have left running.
        sdo.channel.abort(DEVICE_TYPE, AbortCode.GENERAL_ERROR)
        sdo.drain()
        self._put_back(sdo, self.device.contents.outstanding)

    def audit(self, sdo: Dialogue) -> list[Multiplexer]:
        """Put back what reads otherwise than before the run though it was put back, or not written.

        A wrong device may write elsewhere than it was asked to. Returns what was found. What may
        not be written is not looked at, nor what takes long to read; nor any more at all of a
        device that cannot be read.
        """
        found: list[Multiplexer] = []
        contents = self.device.contents
        for mux, value in contents.due(self.device.values).items():
            if len(value) > LONG_VALUE or mux in contents.outstanding:
                continue
            if not self.device.may_put_back(mux) or self._reads(sdo, self._known(mux), value):
                continue
            if mux not in sdo.device.contents.current:
                break
            found.append(mux)
        for mux in found:
            contents.will_change(mux)
        self._put_back(sdo, found)
        return found

    def _leave(
        self, sdo: Dialogue, written: Iterable[Multiplexer], *, in_doubt: bool
    ) -> set[Multiplexer]:
        """Note which of some objects stay as a case has left them, and return these.

        What is empty, or may be, does not: a device may refuse to read it. Nor what is very long,
        which another case may read as it is, unless it was as long before; nor what is
        ``in_doubt``.
        """
        contents, staying = self.device.contents, set[Multiplexer]()
        for mux, value in contents.due(written).items():
            if not contents.may_be_left(mux):
                continue
            found, latest = contents.current.get(mux), contents.latest(mux)
            fits = latest.size <= max(LONG_VALUE, len(value))
            has_bytes = not latest.is_empty if found is None else bool(found)
            stays = fits and has_bytes and not in_doubt
            if not stays and not self._stands_in(sdo, mux, value):
                continue
            staying.add(mux)
            found = contents.current.get(mux)
            if found is not None and restored_value(self._known(mux), found, value):
                self._is_back(mux, value)
            else:
                contents.leave(mux)
        return staying

    def _left_still(self, sdo: Dialogue, written: Iterable[Multiplexer]) -> set[Multiplexer]:
        """Return the objects that a reset did not change back to their own values.

        A very long value is not read for it: it is in doubt until a case needs it, or the end.
        """
        contents, staying = self.device.contents, set[Multiplexer]()
        for mux, value in contents.due(written).items():
            unread = mux not in contents.current and len(value) > LONG_VALUE
            match contents.holds(mux):
                case Holds.PRESUMED:
                    stays = unread and contents.may_be_left(mux)
                case Holds.LEFT if mux in sdo.record.reset:
                    stays = unread or not self._reads(sdo, self._known(mux), value)
                case _:
                    continue
            if stays:
                staying.add(mux)
        return staying

    def _stands_in(self, sdo: Dialogue, mux: Multiplexer, value: bytes) -> bool:
        """Write a short value for the time being where an object had a long one before the run.

        That may take hundreds of requests, and after each of many cases that fail alike. Says
        whether the object reads so: it takes what it is written, then.
        """
        size = min(self.device.learned.lengths[mux].taken, default=TWO_SEGMENTS)
        if len(value) <= SHORT_VALUE or not 0 < size <= SHORT_VALUE:
            return False
        return self._takes(sdo, mux, sdo.payload(size))

    def _takes(self, sdo: Dialogue, mux: Multiplexer, data: bytes) -> bool:
        known = self._known(mux)
        try:
            self._download(sdo, known, data)
        except Violation:
            return False  # it is told where the value itself is not taken
        return self._reads(sdo, known, data)

    def _as_found(
        self, sdo: Dialogue, found: Mapping[Multiplexer, bytes | None]
    ) -> set[Multiplexer]:
        """Return which objects hold again what was left in them when a case began.

        Where that is not known, or long, a short value stands in; those that ought to hold a short
        one of their own get that.
        """
        again = set[Multiplexer]()
        written = sdo.record.written & found.keys() - sdo.record.reset
        for mux, value in self.device.contents.due(written).items():
            held = found[mux] or b""
            is_short = 0 < len(held) <= SHORT_VALUE < len(value)
            if self._takes(sdo, mux, held) if is_short else self._stands_in(sdo, mux, value):
                self.device.contents.leave(mux)
                again.add(mux)
        return again

    def _put_back(self, sdo: Dialogue, written: Iterable[Multiplexer]) -> None:
        self.gone = False
        contents = self.device.contents
        due = contents.due([*written, *contents.to_store])
        if contents.to_store:
            # What was left would be stored as well.
            self._write(sdo, contents.due(contents.left(Holds.LEFT)))
            self._store_again(sdo)
        self._write(sdo, due)

    def _store_again(self, sdo: Dialogue) -> None:
        """Store what was stored before a case changed that.

        It is tried once: from then on other values are in use, and would be stored as well.
        """
        contents = self.device.contents
        self._write(sdo, contents.to_store)
        try:
            write_signature(sdo, SAVE_ALL)
        except (Violation, NotTestable) as error:
            self._not_stored = f"{self._to_store()} ({error})"
            sdo.end_transfer()
            contents.to_store = {}
        else:
            self._not_stored = ""
            contents.is_stored_again()

    def _write(self, sdo: Dialogue, due: Mapping[Multiplexer, bytes]) -> None:
        contents, pending = self.device.contents, dict[Multiplexer, bytes]()
        for mux, value in due.items():
            self._why.pop(mux, None)
            if self.gone:
                contents.lose(mux)
                continue
            self._tries[mux] += 1
            may_put_back = self.device.may_put_back(mux)
            reads = self._reads(sdo, self._known(mux), value)
            # A device that has taken a number that is too long keeps what lies behind its type.
            too_long = self._known(mux).habits.too_long and may_put_back
            if reads and not too_long:
                self._is_back(mux, value)
                if command := sdo.record.reset.get(mux):
                    contents.brought_back[command].add(mux)
                continue
            contents.lose(mux)
            if may_put_back:
                pending[mux] = value
        for mux in sorted(needed_for(pending) - pending.keys()):
            with _at_will(sdo):
                if contents.kept(mux) is None:
                    contents.parameters[mux] = sdo.upload(mux)
                if self.device.may_put_back(mux):
                    pending |= contents.due([mux])
                    contents.will_change(mux)
        # What these steps are refused is refused again behind them, and listed.
        in_use = {mux: contents.current.get(mux) for mux in pending if is_cob_id(mux)}
        for mux, found in in_use.items():
            with _at_will(sdo):  # it may only be moved while it is not in use
                Channels(sdo).disable(mux, found)
        for mux in pending.keys() & needed_for(pending):
            if is_0_meanwhile(mux):
                with _at_will(sdo):
                    sdo.try_download(mux, bytes(len(pending[mux])))
        for mux, value in in_order(pending):
            if not self.gone:
                self._restore(sdo, self._known(mux), value)

    def _known(self, mux: Multiplexer) -> KnownObject:
        return self.device.known.get(mux) or KnownObject(mux)

    def _restore(self, sdo: Dialogue, known: KnownObject, due: bytes) -> None:
        """Write a value and read it back; once more where it is not taken at once.

        What is neither a confirmation nor a refusal may be a late answer that was in the way.
        """
        try:
            in_blocks = self._download(sdo, known, due)
        except Violation as violation:
            try:
                stray = sdo.fence()
                in_blocks = self._download(sdo, known, due)
            except Violation as again:
                self._why[known.mux] = f" ({violation.actual})"
                self._silences[known.mux] += again.rule is ANSWERED
                self._look_whether_gone(sdo, again)
                busy = self._silences[known.mux] <= SILENCES_OF_OBJECT
                refused = again.rule is not ANSWERED or not busy
                self._tries[known.mux] = TRIES_OF_REFUSED if refused else 0
                return
            if violation.rule is ANSWERED and not stray:
                self.late.append(violation)
            elif stray or violation.rule is not NOT_REFUSED:
                self.late.append(
                    Violation(UNSOLICITED, expected=violation.expected, actual=violation.seen)
                )
        if known.habits.too_long:  # perhaps it was for that value only
            self.device.learn(known, replace(known.habits, too_long=False))
        # What changes by itself: that the value was taken has to do.
        moves = known.floats or known.access is Access.RO
        if self._reads(sdo, known, due) or moves:
            self._is_back(known.mux, due)
        elif in_blocks:
            self.device.learned.stores_in_blocks = False
            self._restore(sdo, known, due)

    def _look_whether_gone(self, sdo: Dialogue, silence: Violation) -> None:
        if silence.rule is ANSWERED and not self.gone:
            self.gone = not sdo.silence.recover()

    def _is_back(self, mux: Multiplexer, value: bytes) -> None:
        self.device.contents.is_back(mux, value)
        self._why.pop(mux, None)
        self._tries.pop(mux, None)

    def _download(self, sdo: Dialogue, known: KnownObject, due: bytes) -> bool:
        """Write a value; say whether it went in blocks."""
        if ValueAccess(sdo).write_in_blocks(known.mux, due):
            return True
        try:
            sdo.download(known, due)
        except Violation:
            sdo.end_transfer()
            raise
        return False

    def _reads(self, sdo: Dialogue, known: KnownObject, due: bytes) -> bool:
        """Say whether an object reads as it should; what cannot be read does not.

        What was read last need not be read again, and what announces far more than is due, or
        far less, need not be read to its end to know that.
        """
        current = self.device.contents.current.get(known.mux)
        if current is not None:
            return restored_value(known, current, due)
        for _ in range(TRIES_OF_REFUSED):
            try:
                response = sdo.initiate_upload(known)
                if response.size is not None and self._is_other_size(response.size, due):
                    sdo.end_transfer()
                    return False
                return self._brings(sdo, known, response, due)
            except Violation as breach:
                sdo.end_transfer()
                self._look_whether_gone(sdo, breach)
                if sdo.record.early.met is None:
                    break
        return False

    def _is_other_size(self, size: int, due: bytes) -> bool:
        return size > len(due) + LITTLE_PADDING or size < len(due) - LITTLE_PADDING

    def _brings(
        self, sdo: Dialogue, known: KnownObject, response: UploadInitiateResponse, due: bytes
    ) -> bool:
        """Say whether an upload that was initiated brings a value; if long, perhaps in blocks."""
        if len(due) > SHORT_VALUE:
            sdo.end_transfer()
            if ValueAccess(sdo).in_blocks(known.mux, due) == due:
                return True
            response = sdo.initiate_upload(known)
        found = self.device.contents.current[known.mux] = sdo.finish_upload(known, response)
        return restored_value(known, found, due)


@contextmanager
def _at_will(sdo: Dialogue) -> Iterator[None]:
    """Let the server break off what is tried within."""
    try:
        yield
    except Violation:
        sdo.end_transfer()
