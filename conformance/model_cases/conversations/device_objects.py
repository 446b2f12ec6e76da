"""What random conversations may be about: the objects of a device, and what is put into them.

A careless device may take any frame for the beginning of a download. Whatever is sent therefore
names, where a download initiate has its multiplexer, an object that may be written.
"""

import random
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import islice

from conformance.device.device import IDENTITY_COUNT, Device
from conformance.device.effort import LONG_VALUE, TEXTS_OF_CONVERSATION
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.device.object_roles import Roles
from conformance.device.safety import written_by
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.missing_objects import missing_object, missing_sub_index
from conformance.dialogue.payload import MOST_PLAIN, mux_bytes, text
from conformance.dialogue.value_access import NO_ROOM
from conformance.model_cases.conversations.conversation import Service, Transfer
from conformance.model_cases.lockstep import knowledge_of
from conformance.model_cases.matrix.stimuli import Targets
from conformance.sdo.decoding import decode_request
from conformance.sdo.layout import Multiplexer, whole_frame
from conformance.sdo.oracle import Knowledge
from conformance.sdo.rules import NOT_REFUSED, Violation
from conformance.sdo.seen import Received

# Room for much more than a conversation writes: frames may be repeated and inserted.
ROOMS = (MOST_PLAIN, 64, 20)
# Each conversation begins with a value in each string and domain that it may be about.
DOWNLOADS = Service.EXPEDITED, Service.DOWNLOAD, Service.BLOCK_DOWNLOAD


@dataclass(slots=True)
class DeviceObjects:
    """The objects of a device that transfers may be about.

    ``rooms`` has the bytes that each string or domain surely takes, ``first`` what it holds when a
    conversation begins. ``values`` has what objects hold as far as the last conversation told.
    """

    device: Device
    targets: Targets
    rooms: dict[Multiplexer, int]
    first: dict[Multiplexer, bytes]
    values: dict[Multiplexer, bytes] = field(default_factory=dict)

    @property
    def numbers(self) -> list[Multiplexer]:
        """The objects that may be written and whose values have one length."""
        return [
            known.mux
            for known in Roles(self.device).all_writable(lambda known: known.length is not None)
        ]

    @property
    def readable(self) -> list[Multiplexer]:
        """What can be read in few requests, and what the device does not have."""
        brief = (mux for mux, value in self.device.values.items() if len(value) <= LONG_VALUE)
        return [*brief, self.targets.missing, self.targets.missing_sub_index]

    def known(self, mux: Multiplexer) -> KnownObject | None:
        """Return what is known of an object."""
        return self.device.known.get(mux)

    def offers(self, transfer: Transfer) -> bool:
        """Say whether a transfer, drawn on this device or kept from an earlier run, can be tried.

        An object that was there then may be gone, or be left alone by now.
        """
        if transfer.service in DOWNLOADS or transfer.size:
            return transfer.target in self.rooms or transfer.target in self.numbers
        return transfer.target in self.readable

    def data(self, transfer: Transfer) -> bytes:
        """Return what a download writes; to a number its value with the lowest bit as it may be."""
        if transfer.target not in self.rooms:
            value = self.device.values[transfer.target]
            return bytes([value[0] ^ (transfer.content & 1)]) + value[1:]
        chosen = random.Random(f"{transfer.content}/{transfer.size}")
        return text(chosen, transfer.size, self.device.learned.nowhere)

    def longest(self, mux: Multiplexer) -> int:
        """Return the most bytes that an upload of an object may bring."""
        return self.device.contents.longest(mux)

    def knowledge(self) -> Knowledge:
        """Return what the oracle may take for granted before the next conversation."""
        knowledge = knowledge_of(self.device, self.rooms)
        changed = {
            mux: replace(facts, value=self.values.get(mux))
            for mux, facts in knowledge.objects.items()
            if facts.access is not None and facts.access.writable
        }
        return Knowledge({**knowledge.objects, **changed})

    def restore(self, sdo: Dialogue) -> None:
        """Write what strings and domains are to hold at first, where they do not."""
        for mux, value in self.first.items():
            if self.values.get(mux) != value:
                sdo.download(mux, value)
                self.values[mux] = value
        sdo.fence()

    def remember(self, values: Mapping[Multiplexer, frozenset[bytes] | None]) -> None:
        """Keep what objects hold for sure; of the others forget it."""
        for mux, possible in values.items():
            self.values.pop(mux, None)
            if possible is not None and len(possible) == 1:
                self.values[mux] = next(iter(possible))

    def harmless(self, data: bytes) -> bytes:
        """Return a request that, whatever a device takes it for, writes where it may."""
        return harmless(data, self.device, self.targets.own)


def harmless(data: bytes, device: Device, own: Multiplexer) -> bytes:
    """Put ``own`` where a download initiate would name an object that must not be written.

    Nor does chance write to an object that takes a permission: it does more than to keep a value.
    What only a probe may write to is sent the value that it has: a wrong device takes it.
    """
    request = decode_request(whole_frame(data))
    target = written_by(request)
    if target is None or device.lacks(target) or device.may_be_sent(request, target):
        return data
    return data[:1] + mux_bytes(own) + data[4:]


def survey(sdo: Dialogue) -> DeviceObjects:
    """Find out what a device offers; raises NotTestable without a string or domain."""
    device = sdo.device
    roles = Roles(device)
    roles.variable()
    varying = roles.all_writable(lambda known: known.varies)
    quick = [known for known in varying if not roles.is_long(known)]
    having_room = ((known.mux, room) for known in quick or varying if (room := _room(sdo, known)))
    rooms = dict(islice(having_room, TEXTS_OF_CONVERSATION))
    if not rooms:
        raise NotTestable(f"needs a string or domain of {ROOMS[-1]} bytes: name one")
    targets = Targets(
        device.node_id,
        next(iter(rooms)),
        missing_object(sdo),
        # Of a simple object many servers serve any sub-index: other cases say so.
        missing_sub_index(sdo, IDENTITY_COUNT.index),
        device.device_type,
    )
    first = {mux: sdo.payload(ROOMS[-1]) for mux in rooms}
    held = {
        mux: value for mux in device.values if (value := device.contents.value(mux)) is not None
    }
    return DeviceObjects(device, targets, rooms, first, held)


def _room(sdo: Dialogue, known: KnownObject) -> int:
    """Return the bytes that a string or domain surely takes, 0 where they are few."""
    lengths = sdo.device.learned.lengths[known.mux]
    for room in ROOMS:
        if lengths.lasting and room > lengths.lasting:
            continue
        if room <= (lengths.surely or 0):
            return room
        abort = sdo.try_download(known, sdo.payload(room), segmented=True)
        if abort is None:
            lengths.taken.add(room)
            # It may be the only length that is taken.
            shorter = sdo.try_download(known, sdo.payload(room - 1), segmented=True)
            return room if shorter is None else 0
        if abort.code not in NO_ROOM:
            raise Violation(
                NOT_REFUSED,
                expected=f"a download of {room} bytes to {known}, or too few bytes of room",
                actual=Received(abort),
            )
    return 0
