"""How many requests a run takes at most, however many objects the device has.

Only the cases on the further ones of very many objects are left out for it: all others run on any
device. A thorough run leaves out nothing.
"""

from math import inf

from conformance.plugin.items import CaseFunction
from conformance.plugin.options import Options

# A request counts when it is answered.
MOST = 60_000
# What the cases need at most that come behind those on further objects: see ``items.ordered``.
BEHIND = 6_000
WHY = (
    f"a run takes {MOST:,} requests at most, and the device has very many objects: "
    "--sdo-thorough runs the cases on all of them"
)


def allowed(options: Options) -> float:
    """Return how many requests a device has to answer in a process at most."""
    return inf if options.thorough else MOST / options.share.parts


def is_beyond(item: CaseFunction, options: Options, answers: int) -> bool:
    """Say whether a case is to be left out behind so many answers of its device."""
    return item.further > 0 and answers > allowed(options) - BEHIND / options.share.parts
