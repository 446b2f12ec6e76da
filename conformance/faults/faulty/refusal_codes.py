"""Servers that refuse what they have to refuse, and say something else of it."""

from conformance.faults.registry import About, Defect, fault
from conformance.reference.server import Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Request, Response
from conformance.sdo.objects import ObjectDictionary

SMALL = 13


class _SaysOtherwise(Server):
    """Refuses with another code."""

    right = wrong = AbortCode.GENERAL_ERROR

    def refuse(self, request: Request, code: AbortCode) -> list[Response]:
        return super().refuse(request, self.wrong if code is self.right else code)


@fault("long-strings-refused-as-invalid", Defect.ABORT, "download.too-long", about=About.LENGTHS)
class LongRefusedAsInvalid(_SaysOtherwise):
    """Has strings and domains of 13 bytes, and calls what is too long an invalid value."""

    right, wrong = AbortCode.LENGTH_TOO_HIGH, AbortCode.VALUE_INVALID

    def __init__(self, objects: ObjectDictionary) -> None:
        super().__init__(objects)
        for entry in objects:
            if entry.data_type.length is None and entry.access.writable:
                entry.capacity = SMALL


@fault("missing-objects-refused-as-no-data", Defect.ABORT, "upload.object-missing")
class MissingRefusedAsNoData(_SaysOtherwise):
    """Says of objects that it lacks that there are no data."""

    right, wrong = AbortCode.OBJECT_MISSING, AbortCode.NO_DATA
