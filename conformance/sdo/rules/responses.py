"""What every response of a server is held to, whatever it answers."""

from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

PROTOCOLS = "7.2.4.3"
SERVICES = "7.2.4.2"

FRAME_SHAPE = Rule(
    "response.frame",
    PROTOCOLS,
    MUST,
    "A response is one data frame of 8 bytes on the COB-ID of the channel, in its format.",
)
SPECIFIER = Rule(
    "response.specifier",
    PROTOCOLS,
    MUST,
    "The command specifier of a response fits the request.",
)
ANSWERED = Rule(
    "response.answered",
    SERVICES,
    MUST,
    "Every request of a confirmed service is answered.",
    reaction="one answer, positive or an abort",
)
UNSOLICITED = Rule(
    "response.unsolicited",
    SERVICES,
    MUST,
    "A server sends nothing that no request asked for.",
    reaction="silence, also after an abort and inside a sub-block of a download",
)
MULTIPLEXER = Rule(
    "response.multiplexer",
    PROTOCOLS,
    MUST,
    "The response to an initiate, and the abort of a transfer, repeat its multiplexer.",
    open="the multiplexer of an abort that answers a frame without one while no transfer runs",
)
RESERVED = Rule(
    "response.reserved",
    PROTOCOLS,
    MUST,
    "Reserved bits and bytes of a response are sent as 0.",
)
UNUSED_COUNT = Rule(
    "response.unused-count",
    "7.2.4.3.6",
    MUST,
    "n is 0 unless a response is expedited with its size.",
)
FILLER = Rule(
    "response.filler",
    PROTOCOLS,
    SHOULD,
    "Bytes of a response that hold no data are 0: nothing else leaks there.",
)
TOGGLE = Rule(
    "response.toggle",
    "7.2.4.3.4",
    MUST,
    "The response to a segment repeats its toggle bit.",
)
SIZE = Rule(
    "upload.size",
    "7.2.4.3.6",
    MUST,
    "An upload delivers as many bytes as it announces.",
)
BLOCK_SIZE = Rule(
    "block.size",
    "7.2.4.3.9, 7.2.4.3.10, 7.2.4.3.13 and 7.2.4.3.14",
    MUST,
    "A sub-block has 1 to 127 segments, and not more than asked for.",
)
BLOCK_SEQUENCE = Rule(
    "block.sequence",
    "7.2.4.3.14",
    MUST,
    "The segments of a sub-block count from 1 without gaps.",
)
UPLOAD_ENDS = Rule(
    "upload.ends",
    "7.2.4.3.7 and 7.2.4.3.14",
    MUST,
    "An upload ends: its last segment, and only that one, is marked.",
)
BLOCK_CRC = Rule(
    "block.crc",
    "7.2.4.3.16",
    MUST,
    "The CRC covers the data set; where none is used the field is 0.",
)
ABORT_CODE = Rule(
    "abort.code",
    "7.2.4.3.17",
    MUST,
    "An abort of the server carries one of the codes of table 22.",
)
OTHER_SERVICE = Rule(
    "abort.other-service",
    "7.2.4.3.17",
    MUST,
    "An upload is refused with no code about writing, and a download with none about reading.",
)
UNUSUAL_FORMS = Rule(
    "response.unusual-forms",
    PROTOCOLS,
    MAY,
    "A size may stay unsaid, segments in the middle may be short, and the last may be empty.",
    reaction="40h and 42h, short segments before the last, an empty last segment are all right",
)

RESPONSE_RULES = (
    FRAME_SHAPE,
    SPECIFIER,
    ANSWERED,
    UNSOLICITED,
    MULTIPLEXER,
    RESERVED,
    UNUSED_COUNT,
    FILLER,
    TOGGLE,
    SIZE,
    BLOCK_SIZE,
    BLOCK_SEQUENCE,
    UPLOAD_ENDS,
    BLOCK_CRC,
    ABORT_CODE,
    OTHER_SERVICE,
    UNUSUAL_FORMS,
)
