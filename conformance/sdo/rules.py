"""What is required of a server: rules, how binding they are, and what a breach of one is."""

from dataclasses import dataclass
from enum import StrEnum


class Level(StrEnum):
    """How binding a rule is."""

    MUST = "MUST"
    SHOULD = "SHOULD"
    MAY = "MAY"


@dataclass(frozen=True, slots=True)
class Rule:
    """One requirement on a server: a stable id, the clause of CiA 301, and one sentence."""

    id: str
    clause: str
    level: Level
    sentence: str


class Violation(Exception):
    """A response, or its absence, that a rule does not allow."""

    def __init__(self, rule: Rule, *, expected: str, actual: str) -> None:
        """Say in words what the rule asked for and what came instead."""
        super().__init__(f"{rule.id}: expected {expected}; got {actual}")
        self.rule = rule
        self.expected = expected
        self.actual = actual


def _must(id_: str, clause: str, sentence: str) -> Rule:
    return Rule(id_, clause, Level.MUST, sentence)


FRAME_SHAPE = _must(
    "response.frame",
    "7.2.4.3",
    "A response is one data frame of 8 bytes on the COB-ID of the channel, in its format.",
)
ANSWERED = _must(
    "response.answered", "7.2.4.2", "Every request of a confirmed service is answered."
)
UNSOLICITED = _must(
    "response.unsolicited", "7.2.4.2", "A server sends nothing that no request asked for."
)
SPECIFIER = _must(
    "response.specifier", "7.2.4.3", "The command specifier of a response fits the request."
)
NOT_REFUSED = _must(
    "response.not-refused", "7.2.4.3", "A request that the protocol and the object allow is served."
)
MULTIPLEXER = _must(
    "response.multiplexer",
    "7.2.4.3",
    "The response to an initiate, and the abort of a transfer, repeat its multiplexer.",
)
RESERVED = _must(
    "response.reserved", "7.2.4.3", "Reserved bits and bytes of a response are sent as 0."
)
UNUSED_COUNT = _must(
    "response.unused-count", "7.2.4.3.6", "n is 0 unless a response is expedited with its size."
)
FILLER = Rule(
    "response.filler",
    "7.2.4.3",
    Level.SHOULD,
    "Bytes of a response that hold no data are 0: nothing else leaks there.",
)
TOGGLE = _must("response.toggle", "7.2.4.3.4", "The response to a segment repeats its toggle bit.")
SIZE = _must("upload.size", "7.2.4.3.6", "An upload delivers as many bytes as it announces.")
UPLOAD_ENDS = _must(
    "upload.ends", "7.2.4.3.7", "An upload ends: its last segment, and only that one, is marked."
)
BLOCK_SIZE = _must(
    "block.size", "7.2.4.3.9", "A sub-block has 1 to 127 segments, and not more than asked for."
)
BLOCK_SEQUENCE = _must(
    "block.sequence", "7.2.4.3.14", "The segments of a sub-block count from 1 without gaps."
)
BLOCK_ACK = _must(
    "block.acknowledgement", "7.2.4.3.10", "An acknowledgement names the last segment in sequence."
)
BLOCK_CRC = _must(
    "block.crc", "7.2.4.3.16", "The CRC covers the data set; where none is used the field is 0."
)
BLOCK_PROGRESS = _must(
    "block.progress", "7.2.4.2.10", "What is sent again is taken: a block transfer comes to an end."
)
ABORT_CODE = _must(
    "abort.code", "7.2.4.3.17", "An abort of the server carries one of the codes of table 22."
)
MISSING_REFUSED = _must(
    "object.missing-refused", "7.2.4.3.17", "What does not exist in the device is not served."
)
CONSTANT = _must(
    "object.constant", "7.4.7", "A constant reads the same from the beginning of a run to its end."
)
IDLE_AFTERWARDS = _must(
    "server.idle-afterwards",
    "7.2.4.2",
    "After a transfer has ended, whoever ended it, the server is idle and serves the next one.",
)

RESPONSE_RULES = (
    FRAME_SHAPE,
    ANSWERED,
    UNSOLICITED,
    SPECIFIER,
    NOT_REFUSED,
    MULTIPLEXER,
    RESERVED,
    UNUSED_COUNT,
    FILLER,
    TOGGLE,
    SIZE,
    UPLOAD_ENDS,
    BLOCK_SIZE,
    BLOCK_SEQUENCE,
    BLOCK_ACK,
    BLOCK_CRC,
    BLOCK_PROGRESS,
    ABORT_CODE,
    MISSING_REFUSED,
    CONSTANT,
    IDLE_AFTERWARDS,
)
