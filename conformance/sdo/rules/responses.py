"""What every response of a server is held to, whatever it answers."""

from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

PROTOCOLS = "7.2.4.3"
SERVICES = "7.2.4.2"

FRAME_SHAPE = Rule(
    "response.frame",
    PROTOCOLS,
    MUST,
    "A response is one data frame of 8 bytes on the COB-ID of the channel, in its format.",
    rows=("2.13-frame", "1.2-response"),
)
SPECIFIER = Rule(
    "response.specifier",
    PROTOCOLS,
    MUST,
    "The command specifier of a response fits the request.",
    rows=("2.13-specifier",),
)
ANSWERED = Rule(
    "response.answered",
    SERVICES,
    MUST,
    "Every request of a confirmed service is answered.",
    rows=("2.13-one-response",),
    reaction="one answer, positive or an abort",
)
UNSOLICITED = Rule(
    "response.unsolicited",
    SERVICES,
    MUST,
    "A server sends nothing that no request asked for.",
    rows=("2.13-no-response",),
    reaction="silence, also after an abort and inside a sub-block of a download",
)
MULTIPLEXER = Rule(
    "response.multiplexer",
    PROTOCOLS,
    MUST,
    "The response to an initiate, and the abort of a transfer, repeat its multiplexer.",
    rows=("2.13-multiplexer", "3.1-abort-multiplexer"),
    open="the multiplexer of an abort that answers a frame without one while no transfer runs",
)
RESERVED = Rule(
    "response.reserved",
    PROTOCOLS,
    MUST,
    "Reserved bits and bytes of a response are sent as 0.",
    rows=("2.13-reserved", "6-confirmation-bytes", "6-reserved-bits"),
)
UNUSED_COUNT = Rule(
    "response.unused-count",
    "7.2.4.3.6",
    MUST,
    "n is 0 unless a response is expedited with its size.",
    rows=("2.13-unused-count",),
)
FILLER = Rule(
    "response.filler",
    PROTOCOLS,
    SHOULD,
    "Bytes of a response that hold no data are 0: nothing else leaks there.",
    rows=("2.13-filler", "6-unused-bytes"),
)
TOGGLE = Rule(
    "response.toggle",
    "7.2.4.3.4",
    MUST,
    "The response to a segment repeats its toggle bit.",
    rows=("2.13-toggle",),
)
SIZE = Rule(
    "upload.size",
    "7.2.4.3.6",
    MUST,
    "An upload delivers as many bytes as it announces.",
    rows=("2.13-size", "6-announced-upload"),
)
BLOCK_SIZE = Rule(
    "block.size",
    "7.2.4.3.9",
    MUST,
    "A sub-block has 1 to 127 segments, and not more than asked for.",
    rows=("2.13-block-size", "8-block-size"),
)
BLOCK_SEQUENCE = Rule(
    "block.sequence",
    "7.2.4.3.14",
    MUST,
    "The segments of a sub-block count from 1 without gaps.",
    rows=("2.13-sequence", "8-sequence-of-last"),
)
UPLOAD_ENDS = Rule(
    "upload.ends",
    "7.2.4.3.7",
    MUST,
    "An upload ends: its last segment, and only that one, is marked.",
    rows=("2.13-last-segment",),
)
BLOCK_CRC = Rule(
    "block.crc",
    "7.2.4.3.16",
    MUST,
    "The CRC covers the data set; where none is used the field is 0.",
    rows=("2.13-crc", "5-valid"),
)
ABORT_CODE = Rule(
    "abort.code",
    "7.2.4.3.17",
    MUST,
    "An abort of the server carries one of the codes of table 22.",
    rows=("2.13-abort-code",),
)
UNUSUAL_FORMS = Rule(
    "response.unusual-forms",
    PROTOCOLS,
    MAY,
    "A size may stay unsaid, segments in the middle may be short, and the last may be empty.",
    rows=("2.13-unusual", "6-short-segments"),
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
    UNUSUAL_FORMS,
)
