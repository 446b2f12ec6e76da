"""Requests of fewer than 8 bytes: nothing is required but that no harm is done."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, Rule

PROTOCOLS = "7.2.4.3"
REACTION = "silence, abort, or served with the bytes that were sent"
OPEN = "the reaction to a request of fewer than 8 bytes"
CODES = (
    AbortCode.COMMAND_NOT_VALID,
    AbortCode.LENGTH_MISMATCH,
    AbortCode.LENGTH_TOO_HIGH,
    AbortCode.LENGTH_TOO_LOW,
    AbortCode.GENERAL_ERROR,
)


def _short(id_: str, sentence: str) -> Rule:
    return Rule(id_, PROTOCOLS, MAY, sentence, REACTION, CODES, accepted.ANY, OPEN)


SHORT = _short(
    "frame.short",
    "A request cut short has no positive answer from bytes that were not sent.",
)

SHORT_REQUEST_RULES = (
    SHORT,
    _short(
        "frame.short-download",
        "An expedited download whose data is cut off changes nothing.",
    ),
    _short(
        "frame.short-download-whole",
        "A short download that has all its data is stored rightly, if at all.",
    ),
    _short(
        "frame.short-segment",
        "A segment of a download that is cut off is not filled up with other bytes.",
    ),
    _short(
        "frame.short-segment-request",
        "A request for a segment that is cut short brings the right segment, if any.",
    ),
    _short(
        "frame.short-block-segment",
        "A segment of a block download that is cut off is not filled up with other bytes.",
    ),
    _short(
        "frame.short-abort",
        "An abort without its code ends the transfer or is ignored; it is not served.",
    ),
)
