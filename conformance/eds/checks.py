"""What is held against each other when a whole description was read."""

from conformance.device.eds_listing import Listing
from conformance.eds.findings import Findings
from conformance.eds.info_checks import check_device_info, check_info
from conformance.eds.lists import check_lists
from conformance.eds.object_checks import check_objects
from conformance.eds.pdo_checks import check_pdos
from conformance.eds.text import Sections


def check_text(sections: Sections, findings: Findings) -> None:
    """Check what EDS and DCF alone have: lists, and what they say of themselves."""
    check_lists(sections, findings)
    check_info(sections, findings)


def check(sections: Sections, listing: Listing, findings: Findings) -> Listing:
    """Add what contradicts itself in the file, or a specification; return the rest of the list."""
    check_device_info(sections, findings)
    check_objects(sections, listing, findings)
    return check_pdos(sections, listing, findings)
