"""The abort codes that the oracle accepts are those of the rules, or fewer.

A rule may be one on several moments, and the oracle knows at which of them it is.
"""

from collections import defaultdict

import pytest
from support.oracle_lockstep import Lockstep, known_entries, reference_node
from support.oracle_objects import NODE_ID
from support.oracle_rejections import all_scripts

from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.oracle import Oracle
from conformance.sdo.oracle.answers import DueAbort
from conformance.sdo.rules import RULES_BY_ID
from conformance.sdo.rules.accepted import IMPRECISE

# One in 11 of the generated scripts is played, with what is known of the objects and without.
STRIDE = 11
Codes = set[AbortCode]
ELSEWHERE: dict[str, Codes] = {
    # Of the entries of 1003h, which are none of those that are read here.
    "object.no-data": {AbortCode.GENERAL_ERROR},
    # Where the CRC is looked at first, by the rule on the CRC.
    "block-download.number-length": {AbortCode.CRC_ERROR},
    "block-download.too-few": {AbortCode.CRC_ERROR},
    "block-download.too-many": {AbortCode.CRC_ERROR},
    # An n that is too large is judged by the rule on too few bytes.
    "block-download.unused-too-many": {AbortCode.CRC_ERROR, AbortCode.LENGTH_TOO_LOW},
}
"""What a rule accepts, and the oracle not by that rule."""


@pytest.fixture(scope="module")
def refusals() -> dict[str, list[DueAbort]]:
    """Return the refusals that the oracle holds possible, by the id of their rule."""
    found = defaultdict(list)
    words = DueAbort.words

    def recording(self: DueAbort) -> str:
        found[self.rule.id].append(self)
        return words(self)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(DueAbort, "words", recording)
        for script in all_scripts()[::STRIDE]:
            for knowledge in (True, False):
                node = reference_node()
                known = known_entries(node, roomy=False) if knowledge else None
                lockstep = Lockstep(node, Oracle(known, NODE_ID))
                lockstep.play(script)
    return found


def test_an_abort_is_right_by_what_its_rule_says(refusals: dict[str, list[DueAbort]]) -> None:
    assert len(refusals) > 30
    for id_, found in refusals.items():
        right = {code for refusal in found for code in refusal.codes}
        assert right == set(RULES_BY_ID[id_].codes) - ELSEWHERE.get(id_, set()), id_


def test_what_is_tolerated_the_rule_tolerates(refusals: dict[str, list[DueAbort]]) -> None:
    """At the end of a block download it may be the frame that is said to be wrong."""
    for id_, found in refusals.items():
        tolerated = {code for refusal in found for code in refusal.tolerated}
        assert tolerated <= {*RULES_BY_ID[id_].tolerated, *IMPRECISE}, id_


def test_each_of_them_accepts_some_code(refusals: dict[str, list[DueAbort]]) -> None:
    assert all(
        refusal.codes or refusal.tolerated for found in refusals.values() for refusal in found
    )
