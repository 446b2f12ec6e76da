"""The oracle: says of each response of an SDO server whether it was allowed, and by which rule."""

from conformance.sdo.oracle import (
    block_download,
    block_upload,
    segmented_download,
    segmented_upload,
)
from conformance.sdo.oracle.branch import Freedom
from conformance.sdo.oracle.endings import Ended
from conformance.sdo.oracle.knowledge import Facts, Knowledge, Presence
from conformance.sdo.oracle.oracle import Oracle
from conformance.sdo.oracle.standing import Awaited

# Each of them registers the initiates that begin with it.
SERVICES = (segmented_download, segmented_upload, block_download, block_upload)

__all__ = ["SERVICES", "Awaited", "Ended", "Facts", "Freedom", "Knowledge", "Oracle", "Presence"]
