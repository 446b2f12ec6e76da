"""What holds between transfers, and after one has ended by whatever means."""

from conformance.sdo.rules.model import MAY, MUST, SHOULD, Rule

SERVICES = "7.2.4.2"
ABORT = "7.2.4.3.17"
ACCESS = "7.4.5"

IDLE_AFTERWARDS = Rule(
    "server.idle-afterwards",
    SERVICES,
    MUST,
    "After a transfer has ended in any way, the server is idle and serves the next one.",
    reaction="the next request is served, and nothing more comes of the old transfer",
)
CONSTANT = Rule(
    "object.constant",
    ACCESS,
    MUST,
    "A constant reads the same from the beginning of a run to its end.",
)
NO_REBOOT = Rule(
    "server.no-reboot",
    "7.3.2.2.1",
    MUST,
    "No SDO request makes a device start again.",
    untestable="Every case watches for the boot-up message; no request should bring it about.",
)
FIRST_REQUEST = Rule(
    "server.first-request",
    "7.3.2.2.1",
    MUST,
    "A device that has sent its boot-up message answers the first request, by nothing else.",
    untestable="It is judged where the suite starts the device's program, before the first case.",
)
SUBSTITUTE = Rule(
    "abort.precise-code",
    ABORT,
    SHOULD,
    "An abort names the reason; 08000000h (general error) is for what no other code covers.",
    open="the general error is tolerated where the official test accepts it",
)
PART_WRITTEN = Rule(
    "server.part-written",
    ABORT,
    SHOULD,
    "Of a download that was aborted nothing is in a string or domain either.",
    reaction="the object reads as before",
)

AFTERMATH_RULES = (
    IDLE_AFTERWARDS,
    Rule(
        "server.next-request",
        "7.2.4.3.15",
        MUST,
        "A request right behind the end confirmation of a block upload is served.",
        reaction="served",
    ),
    PART_WRITTEN,
    Rule(
        "server.value-kept",
        ABORT,
        MUST,
        "A download that was aborted, by whichever side, leaves the object with its value.",
        reaction="the object reads as before",
        open="what of a string or domain was written before the abort",
    ),
    Rule(
        "server.partial-domain",
        ABORT,
        MAY,
        "A domain may hold anything after a download that was aborted; the server lives on.",
        reaction="any content",
        open="the content",
    ),
    Rule(
        "server.nothing-afterwards",
        ABORT,
        MUST,
        "Nothing is sent for a transfer that was aborted, and none of its data turns up again.",
        reaction="silence",
    ),
    Rule(
        "abort.order-of-checks",
        ABORT,
        MAY,
        "Of two reasons to refuse an initiate a server may name either.",
        reaction="abort with the code of either reason",
        open="the order",
        untestable="Every order is right: a case sends requests with one error only.",
    ),
    SUBSTITUTE,
    CONSTANT,
    NO_REBOOT,
    FIRST_REQUEST,
)
