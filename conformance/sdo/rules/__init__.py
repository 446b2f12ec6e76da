"""What is required of a server: the one registry of rules, and what a breach of one is."""

from conformance.sdo.rules.after_transfer import (
    CONSTANT,
    FIRST_REQUEST,
    IDLE_AFTERWARDS,
    NO_REBOOT,
    PART_WRITTEN,
    SUBSTITUTE,
)
from conformance.sdo.rules.block_details import BLOCK_ACK
from conformance.sdo.rules.block_download import BLOCK_PROGRESS
from conformance.sdo.rules.chapters import (
    CHAPTERS,
    RULES,
    RULES_BY_ID,
    Chapter,
    UnknownRule,
    rule_of,
)
from conformance.sdo.rules.freedoms import RESTART
from conformance.sdo.rules.idle import MISSING_REFUSED, NOT_REFUSED
from conformance.sdo.rules.model import Cause, Level, Rule, Violation, cited
from conformance.sdo.rules.responses import (
    ABORT_CODE,
    ANSWERED,
    BLOCK_CRC,
    BLOCK_SEQUENCE,
    BLOCK_SIZE,
    FILLER,
    FRAME_SHAPE,
    MULTIPLEXER,
    OTHER_SERVICE,
    RESERVED,
    SIZE,
    SPECIFIER,
    TOGGLE,
    UNSOLICITED,
    UNUSED_COUNT,
    UPLOAD_ENDS,
)

__all__ = [
    "ABORT_CODE",
    "ANSWERED",
    "BLOCK_ACK",
    "BLOCK_CRC",
    "BLOCK_PROGRESS",
    "BLOCK_SEQUENCE",
    "BLOCK_SIZE",
    "CHAPTERS",
    "CONSTANT",
    "FILLER",
    "FIRST_REQUEST",
    "FRAME_SHAPE",
    "IDLE_AFTERWARDS",
    "MISSING_REFUSED",
    "MULTIPLEXER",
    "NOT_REFUSED",
    "NO_REBOOT",
    "OTHER_SERVICE",
    "PART_WRITTEN",
    "RESERVED",
    "RESTART",
    "RULES",
    "RULES_BY_ID",
    "SIZE",
    "SPECIFIER",
    "SUBSTITUTE",
    "TOGGLE",
    "UNSOLICITED",
    "UNUSED_COUNT",
    "UPLOAD_ENDS",
    "Cause",
    "Chapter",
    "Level",
    "Rule",
    "UnknownRule",
    "Violation",
    "cited",
    "rule_of",
]
