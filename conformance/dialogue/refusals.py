"""What a refusal says: it is about the service that was asked for, or known of the device."""

from conformance.device.device import Device
from conformance.device.serving import Service, service_of
from conformance.sdo.abort_codes import OF_DOWNLOADS, OF_UPLOADS
from conformance.sdo.frames import Abort, Request
from conformance.sdo.rules import OTHER_SERVICE, Violation
from conformance.sdo.seen import Received


def of_other_service(refusal: Abort, asked: Request) -> Violation | None:
    """Return what is wrong where a read is refused by a code about writing, or the reverse."""
    service = service_of(asked)
    if service is None:
        return None
    foreign = OF_DOWNLOADS if service is Service.UPLOAD else OF_UPLOADS
    if refusal.code not in foreign:
        return None
    expected = f"a code of the service that was asked for: {service.value}"
    return Violation(OTHER_SERVICE, expected=expected, actual=Received(refusal))


def step_aside(refusal: Abort, asked: Request, device: Device) -> None:
    """Raise NotTestable for a refusal that is known of the device in the state that it is in.

    Whatever the case is about, no server could have served or refused it for that.
    """
    service = service_of(asked)
    if service is None:
        return
    refused = device.learned.serving.excuse(service, refusal.mux, refusal.code)
    if refused is not None and refusal.mux == getattr(asked, "mux", None):
        raise device.learned.serving.way_out(refused, device.permissions)
