"""All rules, chapter by chapter, and how to find one by its id."""

from dataclasses import dataclass
from difflib import get_close_matches

from conformance.sdo.rules.after_transfer import AFTERMATH_RULES
from conformance.sdo.rules.block_details import BLOCK_DETAIL_RULES, CRC_RULES
from conformance.sdo.rules.block_download import BLOCK_DOWNLOAD_RULES
from conformance.sdo.rules.block_upload import BLOCK_UPLOAD_RULES
from conformance.sdo.rules.channels import CHANNEL_RULES
from conformance.sdo.rules.communication import COMMUNICATION_RULES
from conformance.sdo.rules.communication_values import COMMUNICATION_VALUE_RULES
from conformance.sdo.rules.download_initiates import DOWNLOAD_INITIATE_RULES
from conformance.sdo.rules.freedoms import FREEDOM_RULES
from conformance.sdo.rules.idle import IDLE_RULES
from conformance.sdo.rules.model import Rule
from conformance.sdo.rules.object_dictionary import OBJECT_DICTIONARY_RULES
from conformance.sdo.rules.pdos import PDO_RULES
from conformance.sdo.rules.responses import RESPONSE_RULES
from conformance.sdo.rules.segmented_download import SEGMENTED_DOWNLOAD_RULES
from conformance.sdo.rules.segmented_upload import SEGMENTED_UPLOAD_RULES
from conformance.sdo.rules.short_requests import SHORT_REQUEST_RULES
from conformance.sdo.rules.sizes import SIZE_RULES
from conformance.sdo.rules.timing import TIMING_RULES
from conformance.sdo.rules.upload_initiates import UPLOAD_INITIATE_RULES


@dataclass(frozen=True, slots=True)
class Chapter:
    """Rules on one subject."""

    title: str
    rules: tuple[Rule, ...]


class UnknownRule(LookupError):
    """No rule has this id."""


CHAPTERS = (
    Chapter("every response", RESPONSE_RULES),
    Chapter("channels and NMT states", CHANNEL_RULES),
    Chapter("idle server", IDLE_RULES),
    Chapter("download initiates", DOWNLOAD_INITIATE_RULES),
    Chapter("upload initiates", UPLOAD_INITIATE_RULES),
    Chapter("segmented download", SEGMENTED_DOWNLOAD_RULES),
    Chapter("segmented upload", SEGMENTED_UPLOAD_RULES),
    Chapter("block download", BLOCK_DOWNLOAD_RULES),
    Chapter("block upload", BLOCK_UPLOAD_RULES),
    Chapter("short requests", SHORT_REQUEST_RULES),
    Chapter("after a transfer", AFTERMATH_RULES),
    Chapter("CRC", CRC_RULES),
    Chapter("segments of a block", BLOCK_DETAIL_RULES),
    Chapter("sizes", SIZE_RULES),
    Chapter("time-outs", TIMING_RULES),
    Chapter("object dictionary", OBJECT_DICTIONARY_RULES),
    Chapter("objects of the communication", COMMUNICATION_RULES),
    Chapter("values of the communication", COMMUNICATION_VALUE_RULES),
    Chapter("PDOs", PDO_RULES),
    Chapter("freedoms", FREEDOM_RULES),
)
RULES = tuple(rule for chapter in CHAPTERS for rule in chapter.rules)

RULES_BY_ID = {rule.id: rule for rule in RULES}


def rule_of(id_: str) -> Rule:
    """Return the rule with this id; raises UnknownRule, which names the nearest.

    >>> rule_of("segmented-download.toggle").clause
    '7.2.4.3.4'
    """
    try:
        return RULES_BY_ID[id_]
    except KeyError:
        near = get_close_matches(id_, RULES_BY_ID, n=1, cutoff=0.0)[0]
        raise UnknownRule(f"no rule is called {id_!r}; the nearest is {near!r}") from None
