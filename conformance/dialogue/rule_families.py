"""Rules that one and the same defect of a server breaks, so that it is told as one cause.

CiA 301 asks for the same thing of each kind of transfer, and the registry has a rule for each of
these places. A server that gets it wrong in one place of its code gets it wrong in all of them.
"""

from dataclasses import dataclass

from conformance.sdo.kinds import NO_ANSWER, Kind
from conformance.sdo.rules import FILLER, RESERVED, rule_of

# Flaws that a device may have in every answer: they are judged once, for the whole run.
INCIDENTAL = (RESERVED, FILLER)


@dataclass(frozen=True, slots=True)
class Family:
    """Rules, by their ids, that are broken together; ``told_as`` is the one that names the cause.

    ``refused``: by an abort with the wrong code, which stays in the cause. Otherwise by a positive
    answer of any kind, and ``answer`` says how.
    """

    told_as: str
    rules: frozenset[str]
    answer: str = ""

    @property
    def refused(self) -> bool:
        """Whether these are rules on the code of a refusal."""
        return not self.answer

    def name(self, rule_id: str, answer: Kind) -> tuple[str, Kind] | None:
        """Return rule and kind of answer by which a cause of this family is told, if it is one."""
        if rule_id not in self.rules or answer == NO_ANSWER or answer.is_abort != self.refused:
            return None
        return self.told_as, answer if self.refused else Kind(self.answer)


def _family(told_as: str, *others: str, answer: str = "") -> Family:
    names = (told_as, *others)
    return Family(rule_of(told_as).id, frozenset(rule_of(name).id for name in names), answer)


FAMILIES = (
    # What does not belong to a block upload is taken for what is due: in each state a rule.
    _family(
        "block-upload.foreign",
        "block-upload.not-started",
        "block-upload.foreign-before-start",
        "block-upload.over",
        answer="served",
    ),
    _family(
        "download.too-short",
        "segmented-download.number-too-short",
        "segmented-download.number-empty",
    ),
    _family("download.too-long", "segmented-download.number-too-long"),
    _family("download.too-long", "segmented-download.number-too-long", answer="taken"),
    _family("object.sub-index-missing", answer="served"),
    _family("object.limits", answer="taken"),
    # A frame of another service is served in the middle of a transfer.
    _family(
        "segmented-download.upload-segment",
        "segmented-download.block-frames",
        "segmented-download.unknown-specifier",
        answer="served",
    ),
    _family(
        "segmented-upload.download-segment",
        "segmented-upload.block-frames",
        "segmented-upload.unknown-specifier",
        answer="served",
    ),
    _family("block-download.foreign-at-end", answer="served"),
    # What is refused with one code wherever it is out of place.
    _family(
        "specifier.unknown",
        "specifier.out-of-block",
        "segmented-download.upload-segment",
        "segmented-download.block-frames",
        "segmented-download.unknown-specifier",
        "segmented-upload.download-segment",
        "segmented-upload.block-frames",
        "segmented-upload.unknown-specifier",
        "block-download.foreign-at-end",
        "block-upload.not-started",
        "block-upload.foreign-before-start",
        "block-upload.foreign",
        "block-upload.over",
        "block-upload.acknowledged-again",
    ),
    # What no block size can be, wherever it stands.
    _family(
        "block-upload.invalid-block-size",
        "block-upload.acknowledges-block-size",
        "block-upload.threshold-without-block-size",
    ),
    _family("upload.size", answer="another number of bytes"),
    # Sub-index FFh is one that an object may lack.
    _family("object.sub-index-missing", "dictionary.structure"),
    # Zeros, or what an earlier frame has left, stand for bytes that were not sent.
    _family(
        "frame.short",
        "frame.short-download",
        "frame.short-segment",
        "frame.short-block-segment",
        answer="served",
    ),
)


def told_once(rule_id: str, answer: Kind) -> tuple[str, Kind]:
    """Return the rule and the kind of answer by which a breach is told."""
    for family in FAMILIES:
        if named := family.name(rule_id, answer):
            return named
    return rule_id, answer
