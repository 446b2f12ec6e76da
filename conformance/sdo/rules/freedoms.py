"""Choices of a server that belong to no single state: what each of them may never lead to."""

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, SHOULD, Rule

PROTOCOLS = "7.2.4.3"
DOWNLOAD = "7.2.4.3.2"
ABORT = "7.2.4.3.17"

RESTART = Rule(
    "server.new-initiate-served",
    DOWNLOAD,
    SHOULD,
    "A new initiate ends the running transfer and is served.",
    reaction="served; an abort and idle are tolerated",
    codes=accepted.ANY,
    open="a server may refuse it, in segmented and in block transfers",
)

RESERVED_BITS = Rule(
    "request.reserved-bits",
    PROTOCOLS,
    MAY,
    "Reserved bits of a request may be ignored, or refused as no valid command.",
    reaction="served, or abort",
    codes=accepted.NOT_VALID,
    open="served or refused",
)
RESERVED_BYTES = Rule(
    "request.reserved-bytes",
    PROTOCOLS,
    MAY,
    "Reserved bytes of a request are ignored, or at most refused.",
    reaction="served, or abort",
    tolerated=(*accepted.IMPRECISE, AbortCode.PARAMETER_INCOMPATIBLE),
    open="served or refused",
)
FOREIGN_MULTIPLEXER = Rule(
    "abort.foreign-multiplexer",
    ABORT,
    MAY,
    "An abort that names another object ends the transfer or is ignored.",
    reaction="silence, or abort",
    codes=accepted.NOT_VALID,
    open="whether the multiplexer of an abort counts",
)
BEHIND_ANOTHER = Rule(
    "request.behind-another",
    PROTOCOLS,
    MAY,
    "A request sent before the one in front was answered is served, refused or dropped.",
    reaction="served in order, silence, or abort",
    codes=accepted.NOT_VALID,
    open="which of the three; the answers are not mixed up",
)

FREEDOM_RULES = (
    RESERVED_BITS,
    RESERVED_BYTES,
    Rule(
        "request.out-of-transfer",
        PROTOCOLS,
        MAY,
        "A frame that belongs inside a transfer has no positive answer while none runs.",
        reaction="abort, or silence",
        codes=accepted.NOT_VALID,
        tolerated=accepted.ANY,
        open="abort or silence",
    ),
    Rule(
        "abort.any-multiplexer",
        ABORT,
        MAY,
        "Without a transfer, and for a frame without a multiplexer, an abort may carry any.",
        reaction="abort with any multiplexer",
        open="the multiplexer",
    ),
    FOREIGN_MULTIPLEXER,
    RESTART,
    BEHIND_ANOTHER,
)
