"""What a refusal says of the request: it is about the service that was asked for."""

from conformance.device.serving import Service, service_of
from conformance.sdo.abort_codes import OF_DOWNLOADS, OF_UPLOADS
from conformance.sdo.describe import in_words
from conformance.sdo.frames import Abort, Request
from conformance.sdo.rules import OTHER_SERVICE, Violation


def of_other_service(refusal: Abort, asked: Request) -> Violation | None:
    """Return what is wrong where a read is refused by a code about writing, or the reverse."""
    service = service_of(asked)
    if service is None:
        return None
    foreign = OF_DOWNLOADS if service is Service.UPLOAD else OF_UPLOADS
    if refusal.code not in foreign:
        return None
    expected = f"a code of the service that was asked for: {service.value}"
    return Violation(OTHER_SERVICE, expected=expected, actual=in_words(refusal))
