"""Where a server listens and answers: SDO channels, their parameters, and the NMT states."""

from conformance.sdo.abort_codes import APPLICATION_STATE, AbortCode
from conformance.sdo.rules import accepted
from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

PARAMETER = "7.5.2.33"
SERVICES = "7.2.4.2"
ABORT = "7.2.4.3.17"
CONNECTION_SET = "7.3.3"
RESTRICTED = "7.3.5"
NMT = "7.3.2.2"
RESET = "7.3.2.2.1"

REQUEST_IDENTIFIER = Rule(
    "channel.request-identifier",
    CONNECTION_SET,
    MUST,
    "A server takes requests on the COB-ID of its channel and on no other.",
    reaction="silence to requests for another node",
)
REMOTE = Rule(
    "channel.remote",
    "7.2.4.3",
    MAY,
    "A remote frame on the COB-ID of the requests carries none: nothing is served for it.",
    reaction="silence, or an abort",
    codes=accepted.ANY,
    open="the reaction to a remote frame",
)
REMOTE_IGNORED = Rule(
    "channel.remote-ignored",
    "7.2.4.3",
    SHOULD,
    "A remote frame on the COB-ID of the requests is ignored.",
    reaction="silence",
)
EXTENDED_IGNORED = Rule(
    "channel.extended-ignored",
    "7.2.4.3",
    SHOULD,
    "A frame with the other length of identifier is not for the channel and is ignored.",
    reaction="silence",
)
NMT_INITIALISING = Rule(
    "nmt.initialising",
    NMT,
    MUST,
    "A device that is starting up answers nothing before its boot-up message.",
    reaction="silence",
)
NMT_STOPPED = Rule(
    "nmt.stopped",
    NMT,
    MUST,
    "In Stopped no request is answered, not even by an abort.",
    reaction="silence",
)
NMT_INTERRUPTED = Rule(
    "nmt.interrupted",
    NMT,
    MAY,
    "A transfer may end in any way when the node stops; afterwards the server serves again.",
    reaction="silence, or one abort",
    codes=(
        AbortCode.CONNECTION_NOT_AVAILABLE,
        *APPLICATION_STATE,
        AbortCode.TIMED_OUT,
        AbortCode.GENERAL_ERROR,
    ),
    open="what becomes of the transfer",
)

DEFAULT_READ_ONLY = Rule(
    "channel.default-read-only",
    PARAMETER,
    MUST,
    "The default channel can be neither moved nor switched off: 1200h refuses every write.",
    reaction="abort, nothing changes",
    codes=accepted.READ_ONLY,
)
MISSING = Rule(
    "channel.missing",
    ABORT,
    MUST,
    "The parameter of a server channel that the device lacks does not exist.",
    reaction="abort",
    codes=(AbortCode.OBJECT_MISSING,),
)
VALID_KEEPS_IDENTIFIER = Rule(
    "channel.valid-keeps-identifier",
    PARAMETER,
    MUST,
    "A COB-ID changes only while it is marked not valid, and a channel serves while both are.",
    reaction="abort",
    codes=(*accepted.IN_USE, AbortCode.GENERAL_ERROR),
    open="the code",
)
SAME_IDENTIFIER = Rule(
    "channel.same-identifier",
    PARAMETER,
    MAY,
    "A valid COB-ID may take the value that it has, or refuse it.",
    reaction="served, or abort",
    codes=(*accepted.IN_USE, AbortCode.GENERAL_ERROR),
)
EXTENDED_IDENTIFIER = Rule(
    "channel.extended-identifier",
    PARAMETER,
    MUST,
    "A device without 29-bit identifiers refuses a COB-ID that asks for one.",
    reaction="abort",
    codes=accepted.WRONG_VALUE,
    open="whether the device supports 29-bit identifiers",
)
IDENTIFIER_BITS = Rule(
    "channel.identifier-bits",
    PARAMETER,
    MUST,
    "Bits 28 to 11 of a COB-ID are 0 when its identifier has 11 bits.",
    reaction="abort",
    codes=accepted.WRONG_VALUE,
)
RESTRICTED_IDENTIFIER = Rule(
    "channel.restricted-identifier",
    RESTRICTED,
    MUST,
    "No channel takes one of the CAN-IDs that are kept for other services.",
    reaction="abort",
    codes=accepted.WRONG_VALUE,
)
CLIENT_NODE_ID = Rule(
    "channel.client-node-id",
    PARAMETER,
    MUST,
    "The node-ID of a channel's client is 1 to 127.",
    reaction="abort",
    codes=accepted.OUT_OF_LIMITS,
    open="whether the entry is there",
)
INDEPENDENT = Rule(
    "channel.independent",
    SERVICES,
    MUST,
    "A second channel takes nothing from the default one: their transfers may interleave.",
    reaction="both served",
)
ENTRY_COUNT = Rule(
    "channel.entry-count",
    PARAMETER,
    MUST,
    "A channel's parameter counts 2 or 3 entries, and the count cannot be written.",
    reaction="02h, or 03h with the client's node-ID; abort of a download",
    codes=accepted.READ_ONLY,
)

CHANNEL_RULES = (
    REQUEST_IDENTIFIER,
    REMOTE,
    REMOTE_IGNORED,
    EXTENDED_IGNORED,
    Rule(
        "channel.default-parameter",
        PARAMETER,
        MUST,
        "1200h counts 2 entries, and they hold the two COB-IDs that the node-ID gives.",
        reaction="02h, 600h + node-ID, 580h + node-ID",
        open="whether 1200h is there while the device has the default channel only",
    ),
    DEFAULT_READ_ONLY,
    MISSING,
    VALID_KEEPS_IDENTIFIER,
    SAME_IDENTIFIER,
    EXTENDED_IDENTIFIER,
    IDENTIFIER_BITS,
    RESTRICTED_IDENTIFIER,
    Rule(
        "channel.dynamic-bit",
        PARAMETER,
        MAY,
        "Bit 30 of a COB-ID may be set, as dynamically assigned, or be refused as reserved.",
        reaction="served, or abort",
        codes=accepted.WRONG_VALUE,
    ),
    CLIENT_NODE_ID,
    ENTRY_COUNT,
    INDEPENDENT,
    Rule(
        "channel.after-reset",
        RESET,
        MUST,
        "After a reset of the communication a channel is as it is after power-on.",
        reaction="the defaults or the stored values",
    ),
    Rule(
        "channel.client-parameter",
        "7.5.2.34",
        MAY,
        "1280h to 12FFh describe the channels in which the device is the client.",
        reaction="served, or abort",
        codes=(AbortCode.OBJECT_MISSING,),
        open="whether there are any",
    ),
    Rule(
        "object.mandatory",
        "7.5.2",
        MUST,
        "Every device has 1000h, 1001h and 1018h.",
        reaction="served",
        open="1200h: a device with the default channel only may lack it",
    ),
    NMT_INITIALISING,
    Rule(
        "nmt.pre-operational",
        NMT,
        MUST,
        "The server serves in Pre-operational.",
        reaction="served",
    ),
    Rule(
        "nmt.operational",
        NMT,
        MUST,
        "The server serves in Operational.",
        reaction="served",
    ),
    NMT_STOPPED,
    NMT_INTERRUPTED,
    Rule(
        "nmt.reset-restores",
        RESET,
        MUST,
        "A reset of the communication gives 1000h to 1FFFh their power-on values.",
        open="what they are: the defaults, or what is stored, on command or by the device itself",
    ),
    Rule(
        "nmt.reset-keeps-application",
        RESET,
        MUST,
        "A reset of the communication leaves objects from 2000h on as they are.",
    ),
)
