"""Values of a wrong length for a number: refused, and no part of them is written anywhere."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from conformance.device.device import Device
from conformance.device.effort import SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.changing import changes_by_itself
from conformance.dialogue.dialogue import Dialogue
from conformance.sdo.describe import shown
from conformance.sdo.layout import Multiplexer
from conformance.sdo.seen import Data


@dataclass(frozen=True, slots=True)
class OtherValue:
    """A value that a number takes and does not hold, and what is put behind it."""

    value: bytes
    filler: bytes

    def longer(self, length: int) -> bytes:
        """Return it with more bytes than the number has."""
        return self.value.ljust(length, self.filler)

    def shorter(self, length: int) -> bytes:
        """Return its first bytes."""
        return self.value[:length]


@contextmanager
def refusing(sdo: Dialogue, known: KnownObject) -> Iterator[OtherValue]:
    """Expect a number to keep its value, and those next to it theirs, whatever it refuses within.

    Hands out the value that it had before: another one is written first, where it takes one, so
    that a part of what is refused shows if it is written all the same. It is one that the number
    takes: a device may look at a value before it looks at its length.
    """
    before = sdo.upload(known)
    with suppress(NotTestable):
        sdo.write_number(known)
    near = {mux: sdo.upload(mux) for mux in _next_to(sdo.device, known.mux)}
    filler = b"\1" if any(value[:1] == b"\0" for value in near.values()) else b"\0"
    with sdo.unchanged(known):
        yield OtherValue(before, filler)
    for mux, value in near.items():
        if (found := sdo.upload(mux)) != value and not changes_by_itself(sdo, mux):
            sdo.device.contents.will_change(mux)
            sdo.record.written.add(mux)
            raise sdo.breach(f"{mux}, next to {known}, reads {shown(value)}", Data(found))


def _next_to(device: Device, mux: Multiplexer) -> list[Multiplexer]:
    """Return the nearest objects on either side that only the suite writes."""
    kept = [
        one
        for one in device.steady()
        if (device.may_put_back(one) or device.is_constant(one))
        and len(device.values[one]) <= SHORT_VALUE
    ]
    below, above = [one for one in kept if one < mux], [one for one in kept if one > mux]
    return [*below[-1:], *above[:1]]
