"""Time-outs: the specification gives no value, and lets a server wait for ever."""

from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, Rule

ABORT = "7.2.4.3.17"

SERVER_TIME_OUT = Rule(
    "time-out.server",
    ABORT,
    MAY,
    "A server may give up a transfer that does not go on, and says so by its abort.",
    reaction="silence, or abort with the multiplexer of the transfer",
    codes=accepted.TIMED_OUT,
    tolerated=(),
    open="whether there is a time-out, and its length",
)

TIMING_RULES = (
    Rule(
        "time-out.value",
        "7.2.4.2",
        MAY,
        "Within which time a server answers is for its maker to say.",
        open="the time",
        untestable="There is no value to hold a server to; --sdo-response-timeout sets the wait.",
    ),
    SERVER_TIME_OUT,
    Rule(
        "time-out.client",
        ABORT,
        MUST,
        "When the client gives up, by an abort for the time-out, the server is idle.",
        reaction="silence, idle",
    ),
)
