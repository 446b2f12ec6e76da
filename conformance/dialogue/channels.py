"""What a case does with further SDO channels of a device: it configures them and talks on them.

A channel is configured as CiA 301 has it (7.5.2.33): it is disabled first, then it gets its new
COB-IDs, and then it is enabled. The values of before are put back after the case.
"""

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress

from conformance.bus.channel import Channel
from conformance.device.device import VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable, Unimplemented
from conformance.device.protected_objects import SDO_PARAMETERS
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.parameters import Parameters
from conformance.dialogue.values import not_stored
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.block_client import Step
from conformance.sdo.checks import ServerAborted
from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.frames import Abort, Response, UploadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.limits import EXPEDITED_LENGTH
from conformance.sdo.objects import DataType
from conformance.sdo.rules import IDLE_AFTERWARDS, NOT_REFUSED, Violation
from conformance.sdo.rules.defects import DISTURBED
from conformance.sdo.seen import Received, Said
from conformance.sdo.stepping import Ended, advance

DEFAULT_RECORD = 0x1200
LAST_RECORD = 0x127F
FIRST_CLIENT, LAST_CLIENT = 0x1280, 0x12FF
EMERGENCY_ID = Multiplexer(0x1014)
RECEIVED_PDO, SENT_PDO, PDOS = 0x1400, 0x1800, 0x200
COUNT, REQUEST, RESPONSE, CLIENT = range(4)
NOT_THERE = (AbortCode.OBJECT_MISSING, AbortCode.GENERAL_ERROR)
NO_SUCH_ENTRY = (*NOT_THERE, AbortCode.SUB_INDEX_MISSING)
BAD_VALUE = (AbortCode.VALUE_INVALID, AbortCode.GENERAL_ERROR)
# CAN-IDs that the predefined connection set leaves free, for requests and responses.
TEST_CHANNELS = (
    ChannelIds(CobId(0x681), CobId(0x6A1)),
    ChannelIds(CobId(0x682), CobId(0x6A2)),
)
LONG_CHANNEL = ChannelIds(CobId(0x18FF_0681, True), CobId(0x18FF_06A1, True))

Running = tuple[Dialogue, Generator[Step, Response, object]]


def is_cob_id(mux: Multiplexer) -> bool:
    """Say whether an entry is a COB-ID that is disabled before it is moved: 1200h is not."""
    in_record = DEFAULT_RECORD < mux.index <= LAST_CLIENT
    of_pdo = any(first <= mux.index < first + PDOS for first in (RECEIVED_PDO, SENT_PDO))
    if of_pdo:
        return mux.sub_index == REQUEST
    return mux == EMERGENCY_ID or (in_record and mux.sub_index in (REQUEST, RESPONSE))


class Channels:
    """The SDO channels of one device, and the same case on several of them."""

    def __init__(self, sdo: Dialogue) -> None:
        """Take what talks on the channel of the case, and configures the others."""
        self._sdo = sdo
        self._device = sdo.device
        self._channel = sdo.channel
        self._parameters = Parameters(sdo)

    # Which channels there are

    def records(self) -> tuple[int, ...]:
        """Return the records behind 1200h, those first that are not in use; looks once in a run."""
        if self._device.learned.further_channels is None:
            found = []
            for index in range(DEFAULT_RECORD + 1, LAST_RECORD + 1):
                try:
                    request = CobId.from_bytes(self._sdo.read(Multiplexer(index, REQUEST)))
                except ServerAborted:
                    break
                found.append((request.valid, index))
            self._device.learned.further_channels = tuple(index for _, index in sorted(found))
        return self._device.learned.further_channels

    def require_records(self, count: int = 1) -> tuple[int, ...]:
        """Return ``count`` records behind 1200h, none of them that of this channel.

        Raises Unimplemented, with the refusal, when the device has fewer.
        """
        found = self.records()
        if len(found) < count:
            raise Unimplemented(self.refusal(Multiplexer(DEFAULT_RECORD + 1 + len(found), REQUEST)))
        others = tuple(index for index in found if not self._is_own(index))[:count]
        if len(others) < count:
            raise NotTestable(
                f"needs {count} SDO channel(s) beside the default one and {self._channel.ids}"
            )
        return others

    def _is_own(self, index: int) -> bool:
        if self._channel.is_default:
            return False
        return self.cob_id(index, REQUEST).can_id == self._channel.ids.request.can_id

    def require(self, count: int = 1) -> tuple[int, ...]:
        """Return ``count`` records that may be configured; raises NotTestable, Unimplemented."""
        found = self.require_records(count)
        self.require_parameters()
        return found

    def require_parameters(self) -> None:
        """Raise NotTestable unless SDO parameters may be written."""
        self._device.permits.require(SDO_PARAMETERS)

    def require_client_entry(self) -> int:
        """Return a record with a sub-index 03h that may be configured."""
        self.require()
        found = [index for index in self.records() if not self._is_own(index)]
        for index in found:
            if self._sdo.upload(Multiplexer(index, COUNT))[:1] == bytes((CLIENT,)):
                return index
        raise Unimplemented(self.refusal(Multiplexer(found[0], CLIENT)))

    def refusal(self, mux: Multiplexer) -> Received:
        """Read an entry that does not exist, and so has to be refused; return the refusal."""
        try:
            self._sdo.read(mux)
        except ServerAborted as aborted:
            refusal = Received(aborted.abort)
            if aborted.abort.code in (NO_SUCH_ENTRY if mux.sub_index == CLIENT else NOT_THERE):
                return refusal
            raise self._sdo.breach(f"{mux} to be refused as missing", refusal) from aborted
        raise self._sdo.breach(f"{mux} to be refused as before", "it is served")

    # COB-IDs

    def cob_id(self, index: int, sub_index: int) -> CobId:
        """Read a COB-ID of a record."""
        return CobId.from_bytes(self._sdo.upload(Multiplexer(index, sub_index)))

    def try_cob_id(self, index: int, sub_index: int, cob_id: CobId) -> Abort | None:
        """Write a COB-ID to a record; return the abort if the server refuses."""
        return self._parameters.write(Multiplexer(index, sub_index), bytes(cob_id))

    def set_cob_id(self, index: int, sub_index: int, cob_id: CobId) -> None:
        """Write a COB-ID to a record, which the server has to take."""
        abort = self.try_cob_id(index, sub_index, cob_id)
        if abort is not None:
            raise Violation(
                NOT_REFUSED,
                expected=f"{cob_id} to be taken for {Multiplexer(index, sub_index)}",
                actual=Received(abort),
            )

    def take_confirmation(self, index: int, sub_index: int) -> Abort | None:
        """Take the answer to a write to a record: a confirmation, or an abort to be judged."""
        try:
            self._sdo.checks.download_initiate(self._sdo.receive(), Multiplexer(index, sub_index))
        except ServerAborted as aborted:
            return aborted.abort
        return None

    def refused_value(self, index: int, sub_index: int) -> bool:
        """Take the answer to a write to a record: taken, or refused for its value."""
        abort = self.take_confirmation(index, sub_index)
        if abort is not None and abort.code not in BAD_VALUE:
            raise self._sdo.breach(
                "a confirmation, or an abort for the value (06090030h)",
                Received(abort),
            )
        return abort is not None

    def disable(self, mux: Multiplexer, found: bytes | None = None) -> None:
        """Set bit 31 of a COB-ID that is in use; ``found`` is what it holds, if that was read."""
        known = self._sdo.device.contents.current.get(mux) if found is None else found
        before = CobId.from_bytes(self._sdo.upload(mux) if known is None else known)
        if before.valid:
            self.set_cob_id(mux.index, mux.sub_index, before.disabled())

    def disable_channel(self, index: int) -> None:
        """Take a channel out of use: bit 31 of both its COB-IDs is set."""
        for sub_index in (REQUEST, RESPONSE):
            self.disable(Multiplexer(index, sub_index))

    def configure(self, index: int, ids: ChannelIds) -> None:
        """Give a channel its COB-IDs and put it into use."""
        if ids == self._channel.ids:
            raise NotTestable(f"needs {ids}, which are those of the channel under test")
        self.disable_channel(index)
        for cob_ids in (
            (ids.request.disabled(), ids.response.disabled()),
            (ids.request, ids.response),
        ):
            for sub_index, cob_id in zip((REQUEST, RESPONSE), cob_ids, strict=True):
                self.set_cob_id(index, sub_index, cob_id)

    # Talking on them

    @contextmanager
    def on(self, ids: ChannelIds) -> Iterator[Dialogue]:
        """Talk on a channel that was configured; its server has to be idle in the end."""
        with self.listen_on(ids) as other:
            other.silence.calms_down = True
            try:
                yield other
            finally:
                other.end_transfer()
            stray = other.fence()
            if stray:
                raise Violation(
                    IDLE_AFTERWARDS,
                    expected=f"nothing but the answer to a read of 1000h on {ids}",
                    actual=Received(stray[0], stray[1:]),
                )

    @contextmanager
    def listen_on(self, ids: ChannelIds) -> Iterator[Dialogue]:
        """Talk on a channel that need not be there; what is found counts for this case."""
        own = self._channel
        channel = Channel(own.link, self._device.node_id, own.response_timeout, ids, own.pace)
        other = self._sdo.beside(channel)
        other.silence.calms_down = False
        try:
            yield other
        finally:
            channel.close()
            self._sdo.wire.timing.include(other.wire.timing)

    def expect_no_server(self, ids: ChannelIds) -> None:
        """Expect that a request on a channel is not answered, and that this channel still serves.

        The request is followed by two reads on this channel: a server that answers late is heard
        while it answers these.
        """
        with self.listen_on(ids) as other:
            other.send(UploadInitiate(VENDOR_ID.mux))
            self._sdo.fence()
            self._sdo.fence()
            answers = other.drain()
        if answers:
            raise self._sdo.breach(f"no answer on {ids}", Said(str(answers[0]), "…#…"))

    @contextmanager
    def further(self, number: int = 0) -> Iterator[Dialogue]:
        """Configure a further channel, the first or the second, and talk on it."""
        index = self.require(number + 1)[number]
        ids = TEST_CHANNELS[number]
        self.configure(index, ids)
        try:
            with self.on(ids) as other:
                yield other
        except (Violation, ServerAborted):
            self._check_stored(index, ids)
            raise

    def _check_stored(self, index: int, ids: ChannelIds) -> None:
        """Raise Violation where the device is known to store no COB-IDs that it confirms."""
        unstored = self._sdo.record.causes.unstored(number=True, size=EXPEDITED_LENGTH)
        if unstored is None or not self._sdo.silence.recover():
            return
        for sub_index, due in ((REQUEST, ids.request), (RESPONSE, ids.response)):
            known = KnownObject(Multiplexer(index, sub_index), DataType.UNSIGNED32)
            if self._sdo.upload(known) != bytes(due):
                raise not_stored(known, bytes(due), unstored)

    @contextmanager
    def side_by_side(self, number: int = 0) -> Iterator[Dialogue]:
        """Talk on a further channel while transfers run on this one.

        What goes wrong then is that the one disturbs the other, unless it was met elsewhere.
        """
        with self.further(number) as other:
            try:
                yield other
            except ServerAborted as aborted:
                raise self._sdo.breach(
                    "both transfers served", Received(aborted.abort), told_as=DISTURBED
                ) from aborted
            except Violation as found:
                if not self._sdo.record.is_known(found, self._sdo.wire.last_sent):
                    found.told_as = DISTURBED
                raise


def interleave(*running: Running) -> list[object]:
    """Run transfers at the same time, each on its own channel; return their results.

    In each round all send their requests before the answer to any of them is taken. A transfer
    that the server aborts has the abort for its result. A breach by one ends all of them.
    """
    try:
        return _interleaved(running)
    except Violation as violation:
        for sdo, _ in running:
            # What it owes on this channel would be a stray answer to whatever comes next.
            with suppress(Violation, ServerAborted):
                violation.asked = violation.asked or sdo.wire.last_sent
                sdo.end_transfer()
                sdo.fence()
        raise


def _interleaved(running: Sequence[Running]) -> list[object]:
    results: list[object] = [None] * len(running)
    due: dict[int, Step] = {number: next(transfer) for number, (_, transfer) in enumerate(running)}
    while due:
        awaited = {number: running[number][0].ask(step) for number, step in due.items()}
        for number, answer_due in awaited.items():
            sdo, transfer = running[number]
            step: Step | Ended[object]
            try:
                step = advance(transfer, sdo.receive() if answer_due else None)
            except ServerAborted as aborted:
                step = Ended(aborted.abort)
            if isinstance(step, Ended):
                results[number] = step.result
                del due[number]
            else:
                due[number] = step
    return results
