"""Nodes that are wrong in what their PDOs map, and in when that changes."""

from functools import partial

from conformance.faults import registry
from conformance.faults.altered_nodes import AlteredNode
from conformance.faults.registry import About, Defect
from conformance.reference.communication import ENTRIES, RECEIVED, SENT, Mapping
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.channel_parameters import CheckedEntry, anything
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry, Refusal
from conformance.sdo.pdos import INHIBIT_TIME, MAPPING_OF, SYNC_START, Mapped

fault = partial(registry.fault, about=About.OBJECTS)
RECEIVED_MAPPING, SENT_MAPPING = RECEIVED + MAPPING_OF, SENT + MAPPING_OF
MEASURED = Multiplexer(0x2130)


class _Mappings(AlteredNode):
    """Checks otherwise what is mapped."""

    mapping: type[Mapping] = Mapping

    def alter(self) -> None:
        for index in (RECEIVED_MAPPING, SENT_MAPPING):
            self.mapping(self.objects, index).attach()


class _Maps(AlteredNode):
    """Maps other objects from the beginning."""

    index = SENT_MAPPING
    mapped: tuple[Mapped, ...] = ()

    def alter(self) -> None:
        self.objects.find(Multiplexer(self.index)).value = bytes([len(self.mapped)])
        for sub_index, mapped in enumerate(self.mapped, 1):
            self.objects.find(Multiplexer(self.index, sub_index)).value = bytes(mapped)
        self.defaults = self.power_on = self.present()


# What is mapped


@fault("pdo-maps-missing-object-in-use", Defect.ACCESS_OR_SIZE, "pdo.mapping-in-use[1A00h]")
class InUseMissing(_Maps):
    """Has mapped an object that does not exist."""

    mapped = (Mapped(Multiplexer(0x2FFF), 32),)


@fault("pdo-maps-half-of-an-object", Defect.ACCESS_OR_SIZE, "pdo.mapping-in-use[1A00h]")
class InUseShort(_Maps):
    """Has mapped 16 bits of an object of 32."""

    mapped = (Mapped(MEASURED, 16),)


@fault("pdo-maps-three-long-objects", Defect.ACCESS_OR_SIZE, "pdo.mapping-in-use[1A00h]")
class InUseLong(_Maps):
    """Has mapped 12 bytes."""

    mapped = (Mapped(MEASURED, 32),) * ENTRIES


@fault("pdo-maps-device-type-in-use", Defect.ACCESS_OR_SIZE, "pdo.mapping-in-use[1A00h]")
class InUseUnmappable(_Maps):
    """Has mapped 1000h, of which its EDS says that no PDO maps it."""

    mapped = (Mapped(Multiplexer(0x1000), 32),)


@fault("pdo-receives-read-only-object", Defect.ACCESS_OR_SIZE, "pdo.mapping-in-use[1600h]")
class InUseReadOnly(_Maps):
    """Has mapped a read-only object for what it receives."""

    index = RECEIVED_MAPPING
    mapped = (Mapped(MEASURED, 32),)


@fault("pdo-maps-long-dummy", Defect.ACCESS_OR_SIZE, "pdo.mapping-in-use[1600h]")
class InUseLongDummy(_Maps):
    """Has mapped 16 bits for a dummy of 8."""

    index = RECEIVED_MAPPING
    mapped = (Mapped(Multiplexer(0x0005), 16),)


class _MapsUnmappable(Mapping):
    """Maps any number."""

    def may_map(self, mux: Multiplexer, entry: Entry) -> bool:
        """Map it."""
        return True


@fault("pdo-maps-unmappable-object", Defect.ACCESS_OR_SIZE, "pdo.mappable")
class MapsUnmappable(_Mappings):
    """Maps objects of which its EDS says that no PDO maps them."""

    mapping = _MapsUnmappable


class _MapsWithoutAccess(Mapping):
    """Maps whatever the access."""

    def has_access(self, entry: Entry) -> bool:
        """Map it."""
        return True


@fault("pdo-maps-without-access", Defect.ACCESS_OR_SIZE, "pdo.mapped-access")
class MapsWithoutAccess(_Mappings):
    """Maps read-only objects for what it receives, and write-only ones for what it sends."""

    mapping = _MapsWithoutAccess


class _AnyCount(Mapping):
    """Takes any number of entries."""

    def check_count(self, old: bytes, new: bytes) -> None:
        """Look whether the PDO is valid, and no further."""
        if new != old:
            self.check_changeable()


@fault("pdo-mapping-of-any-count", Defect.ACCESS_OR_SIZE, "pdo.mapping-count")
class AnyCount(_Mappings):
    """Takes any number of entries for a mapping."""

    mapping = _AnyCount


# How it changes


class _ChangesWhileValid(Mapping):
    """Changes at any time."""

    def check_changeable(self) -> None:
        """Change it."""


@fault("pdo-mapping-changes-while-valid", Defect.ACCESS_OR_SIZE, "pdo.mapping-while-valid")
class ChangesWhileValid(_Mappings):
    """Lets a mapping change while its PDO is valid."""

    mapping = _ChangesWhileValid


class _ChangesWhileCounted(Mapping):
    """Changes entries that are in use."""

    def check_unused(self) -> None:
        """Change it."""


@fault("pdo-mapping-changes-while-counted", Defect.ACCESS_OR_SIZE, "pdo.mapping-while-counted")
class ChangesWhileCounted(_Mappings):
    """Lets an entry of a mapping change while some are in use."""

    mapping = _ChangesWhileCounted


class _NotMappedAgain(Mapping):
    """Never maps what it has mapped once."""

    def check_entry(self, old: bytes, new: bytes) -> None:
        """Refuse the value that is there as well."""
        self.check_changeable()
        raise Refusal(AbortCode.VALUE_INVALID)


@fault("pdo-mapping-not-taken", Defect.ACCESS_OR_SIZE, "pdo.mapping-taken")
class NotMappedAgain(_Mappings):
    """Refuses entries of a mapping that it has let go."""

    mapping = _NotMappedAgain


@fault("pdo-times-change-while-valid", Defect.ACCESS_OR_SIZE, "pdo.kept-while-valid")
class TimesChange(AlteredNode):
    """Lets inhibit time and SYNC start value change while the PDO is valid."""

    def alter(self) -> None:
        for sub_index in (INHIBIT_TIME, SYNC_START):
            entry = self.objects.find(Multiplexer(SENT, sub_index))
            if isinstance(entry, CheckedEntry):
                entry.check = anything
