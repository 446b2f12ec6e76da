"""How much a string or domain takes: found out by writing, and remembered for the run."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from conformance.device.effort import MOST_MEASURED, MUCH_ROOM, SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import Lack, Missing, NotTestable
from conformance.device.object_roles import Roles
from conformance.dialogue.payload import MOST_PLAIN
from conformance.dialogue.room_trials import Trials
from conformance.dialogue.transfers import Transfers
from conformance.dialogue.value_access import NO_ROOM, WAYS, ValueAccess
from conformance.dialogue.values import not_stored
from conformance.sdo.abort_codes import AbortCode, describe_code
from conformance.sdo.frames import Abort
from conformance.sdo.objects import TEXT_TYPES
from conformance.sdo.rules import NOT_REFUSED, Violation
from conformance.sdo.rules.download_initiates import TOO_LONG
from conformance.sdo.seen import Received


class Room:
    """Writes to strings and domains that may be too small for what is written."""

    def __init__(self, sdo: Transfers) -> None:
        """Take what writes; what was found out is known of its device."""
        self._sdo = sdo
        self._device = sdo.device
        self._trials = Trials(sdo)

    def store(
        self,
        known: KnownObject,
        data: bytes,
        *,
        segmented: bool | None = None,
        sized: bool = True,
        exactly: bool = False,
    ) -> None:
        """Write ``data`` to a string or domain that may be too small for it.

        How it gets there matters only if ``exactly``: a device that refuses one way is told so, and
        written to by another. Raises NotTestable when the object is too small, or takes one length
        only. A device that refuses this length alone is at fault.
        """
        self.check_length(known, len(data))
        way = self._device.learned.way_to_store
        if way is not None and not exactly and self._trials.write_otherwise(known, data, (way,)):
            return
        always_long = self._device.learned.lengths[known.mux].least > SHORT_VALUE
        if always_long and not exactly and ValueAccess(self._sdo).write_in_blocks(known.mux, data):
            return
        try:
            # What matters exactly is what went before as well: it is the case that is repeated.
            write = self._sdo.try_download if exactly else self._trials.write
            abort = write(known, data, segmented=segmented, sized=sized)
            asked = self._sdo.wire.last_sent
        except Violation as broken:
            if exactly:
                raise
            self._sdo.end_transfer()
            self._store_by_any_way(known, data, broken)
            return
        if abort is None:
            if not exactly and self._sdo.record.causes.nothing_is_stored:
                raise not_stored(known, data)
            return
        # What has begun is not refused for a length that it announced.
        by_length = abort.code not in NO_ROOM and self._sdo.wire.refusal is not None
        if by_length and not exactly and self._trials.is_too_long(known, data):
            self._note_code(known, len(data), abort)
        elif abort.code not in NO_ROOM or self._trials.takes_otherwise(known, data):
            refused = Violation(
                NOT_REFUSED,
                expected=f"a download of {len(data)} bytes to {known}, as another way",
                actual=Received(abort),
                asked=asked,
            )
            if exactly:
                raise refused
            self._store_by_any_way(known, data, refused)
            return
        self._device.learned.lengths[known.mux].refused.add(len(data))
        if len(data) <= MOST_MEASURED and self._device.learned.lengths[known.mux].most is None:
            self._trials.measure(known, len(data), abort)
            self.check_length(known, len(data))
        raise self.refused(known, len(data), abort)

    def _store_by_any_way(self, known: KnownObject, data: bytes, refused: Violation) -> None:
        refused.asked = refused.asked or self._sdo.wire.last_sent
        self._sdo.note(refused)
        if not self._trials.write_otherwise(known, data, WAYS):
            self._trials.learn_that_nothing_is_taken(known, data, refused)
            raise refused

    def check_length(self, known: KnownObject, size: int) -> None:
        """Raise NotTestable for a length of which it was found out that an object does not take it.

        Nothing is sent: what was found out holds for the run.
        """
        lengths = self._device.learned.lengths[known.mux]
        lengths.check_lasting(known, size)
        cut = self._device.known[known.mux].habits.cut
        if 0 < cut < size:
            raise NotTestable(
                f"{known} keeps the first {cut} bytes of a longer value: name a larger string or "
                "domain"
            )
        if lengths.fixed and size != lengths.most:
            raise NotTestable(
                f"{known} takes values of {lengths.most} bytes only (others are refused with "
                f"{lengths.refusal}): name a string or domain of variable length"
            )
        if lengths.most == 0:
            raise NotTestable(
                f"{known} takes no value, however it is written ({lengths.refusal}): name another "
                "string or domain"
            )
        if lengths.most is not None and size > lengths.most:
            raise NotTestable(
                f"{known} takes values of {lengths.most} bytes at most (more are refused with "
                f"{lengths.refusal}): name a larger string or domain"
            )

    def need(self, known: KnownObject, size: int) -> None:
        """Raise NotTestable unless a string or domain takes ``size`` bytes.

        Most devices are asked twice in a run: for little, which is all that few cases need, and
        then for more room than most do. The object has its own value again then, unless that is
        long and may be away until it is needed.
        """
        lengths = self._device.learned.lengths[known.mux]
        if self.has(known, size):
            return
        lengths.check_lasting(known, size)
        if not lengths.lasting and lengths.asked and lengths.much is None:
            much = MUCH_ROOM if self._device.learned.nowhere else MOST_PLAIN
            lengths.much = much if self._trials.takes(known, much) else 0
        lengths.asked = True
        if not self.has(known, size) and (lengths.much or 0) < size:
            self.store(known, self._sdo.payload(size), segmented=True)
            lengths.taken.add(size)
        self._restore_short(known)
        if not self.has(known, size):
            # It took much, and its own value: that may be one and the same length.
            self.store(known, self._sdo.payload(size), segmented=True)
            self._device.learned.lengths[known.mux].taken.add(size)
            self._restore_short(known)

    @contextmanager
    def for_length(self, known: KnownObject, size: int) -> Iterator[None]:
        """Ask, where a download of ``size`` bytes fails within, whether there is room for them.

        Raises NotTestable instead where there is not.
        """
        try:
            yield
        except Violation as broken:
            broken.asked = broken.asked or self._sdo.wire.last_sent
            self._sdo.silence.recover()
            self.need(known, size)
            raise

    def _restore_short(self, known: KnownObject) -> None:
        long = len(self._device.values[known.mux]) > SHORT_VALUE
        if not (long and self._device.contents.may_be_left(known.mux)):
            self.restore_own(known)

    def restore_own(self, known: KnownObject) -> None:
        """Write the value that an object had before the run."""
        value = self._device.values[known.mux]
        self.store(known, value)
        self._device.contents.settle(known.mux)
        self._device.learned.lengths[known.mux].taken.add(len(value))

    def has(self, known: KnownObject, size: int) -> bool:
        """Say whether an object surely takes ``size`` bytes, by what it has taken in this run.

        A text is commonly shorter than it might be; others may take one length and not the next.
        """
        lengths = self._device.learned.lengths[known.mux]
        is_text = known.data_type in TEXT_TYPES
        return size in lengths.taken or (is_text and size <= (lengths.surely or 0))

    def refused(self, known: KnownObject, size: int, abort: Abort) -> NotTestable | Violation:
        """Build what a refusal of ``size`` bytes means: too small an object, or a breach."""
        lengths = self._device.learned.lengths[known.mux]
        if abort.code not in NO_ROOM and lengths.most is None and size > MOST_MEASURED:
            with suppress(NotTestable):
                self.store(known, self._sdo.payload(MOST_MEASURED))
        too_long = lengths.most is not None and size > lengths.most
        if abort.code not in NO_ROOM and not too_long and size not in lengths.refused:
            return Violation(
                NOT_REFUSED,
                expected=f"a download of {size} bytes to {known}, or that it is too small",
                actual=Received(abort),
            )
        why = f"(refused with {describe_code(abort.code)})"
        longer = any(taken > size for taken in self._device.learned.lengths[known.mux].taken)
        if longer or abort.code == AbortCode.LENGTH_TOO_LOW:
            return NotTestable(
                f"{known} takes no value of {size} bytes {why}: name a string or domain of "
                "variable length"
            )
        return NotTestable(
            f"{known} has no room for {size} bytes {why}: name a larger string or domain"
        )

    def _note_code(self, known: KnownObject, size: int, abort: Abort) -> None:
        """Tell a wrong code of a refusal that is right; the length is known from then on."""
        due = f"a refusal of {size} bytes by {known} with {describe_code(TOO_LONG.codes[0])}"
        self._sdo.note(Violation(TOO_LONG, expected=due, actual=Received(abort)))

    def object_beyond(self, size: int) -> tuple[KnownObject, bytes]:
        """Return an object of ``size`` bytes or more, and its value.

        That is what reads so long by itself, else what takes it, in segments or in blocks.
        """
        for known in self._device.objects:
            value = self._device.contents.value(known.mux) or b""
            if len(value) >= size and known.is_steady:
                return known, value
        known, data = Roles(self._device).variable(size), self._sdo.payload(size)
        self.check_length(known, size)
        abort = self._sdo.try_download(known, data, segmented=True)
        if abort is not None:
            in_blocks = self._sdo.client.block_download(known.mux, data)
            if abort.code not in NO_ROOM or self._sdo.abort_of(in_blocks) is not None:
                raise self.refused(known, size, abort)
        return known, data

    # As many bytes as an object takes

    def fit(self, known: KnownObject, wanted: int, least: int = 1) -> int:
        """Return how many bytes to write to a string or domain: ``wanted``, if it takes them.

        Else it is the most that it takes, or the only length that it has, which may be more. What
        was found out is remembered for the run. Raises NotTestable where that is less than
        ``least``.
        """
        lengths = self._device.learned.lengths[known.mux]
        untried = lengths.fit(wanted) == wanted and not self.has(known, wanted)
        if lengths.fit(wanted) is None or untried:
            self._try(known, self._sdo.payload(wanted))
        size = lengths.fit(wanted) or 0
        if size < least:
            self.check_length(known, least)
            raise NotTestable(f"{known} takes no value of {least} bytes: name a larger one")
        return size

    def prepare(self, known: KnownObject, wanted: int, least: int = 1) -> bytes:
        """Store a value of ``wanted`` bytes, or of as many as ``fit`` says, and return it.

        What the device leaves behind it of a longer one is a part of it then.
        """
        data = self._sdo.payload(wanted)
        if not (
            self._device.learned.lengths[known.mux].fit(wanted) is None and self._try(known, data)
        ):
            size = self.fit(known, wanted, least)
            if size != wanted:
                data = self._sdo.payload(size)
            self.store(known, data)
        habits = known.habits
        return self._sdo.upload(known) if habits.keeps_tails or habits.lacks else data

    def _try(self, known: KnownObject, data: bytes) -> bool:
        """Write a value; where it is refused for its length, find out which lengths are not."""
        try:
            self.store(known, data)
        except NotTestable:
            return False
        self._device.learned.lengths[known.mux].taken.add(len(data))
        return True

    def long_object(self, segments: int = 3) -> tuple[KnownObject, bytes]:
        """Return an object whose upload takes ``segments`` or more, and its value.

        That is a string or domain that may be written, else what reads long enough by itself.
        """
        needed = 7 * (segments - 1) + 1
        try:
            known = Roles(self._device).variable(needed)
            data = known.habits.filling(self.prepare(known, 7 * segments - 1, least=needed))
        except (NotTestable, Violation):
            # What only the device changes may be another value the next time.
            for known in sorted(self._device.objects, key=self._last_to_be_read):
                data = self._device.values.get(known.mux, b"")
                if len(data) >= needed:
                    ValueAccess(self._sdo).write_own(known.mux)
                    return known, data
            raise NotTestable(
                f"needs an object of {needed} bytes or more: name a string or domain, "
                "--sdo-object=2010=visible_string or in device.toml [objects] writable = "
                '["2010=visible_string"]',
                Missing(Lack.OBJECT, "2010=visible_string"),
            ) from None
        return known, data

    def _last_to_be_read(self, known: KnownObject) -> tuple[bool, int]:
        return not known.is_steady, len(self._device.values.get(known.mux, b""))
