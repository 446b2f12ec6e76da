"""What all cases of a run saw on the way, judged at its end."""

from conformance.device.device import Device
from conformance.dialogue.cause_of import NOT_ZERO
from conformance.dialogue.dialogue import Dialogue
from conformance.run.case import must, should
from conformance.run.session import Incident, WholeRun
from conformance.sdo.kinds import Kind
from conformance.sdo.rules import FILLER, MULTIPLEXER, RESERVED, Cause
from conformance.sdo.seen import said

BEHIND_THEIR_CASES = Kind("answers behind their cases")


def judge(sdo: Dialogue, incidents: list[Incident], expected: str, cause: Kind) -> None:
    """Fail with the first of the incidents and their number; ``cause`` is what they all are."""
    if incidents:
        first = incidents[0]
        raise sdo.breach(
            expected,
            said("{} exceptions", len(incidents)).remarking(
                f"; the first ({first.case_id}): {first.violation.actual}"
            ),
            told_as=Cause(first.violation.rule.id, *cause),
        )


@must("run.reserved", "response.reserved")
def test_reserved(sdo: Dialogue, whole_run: WholeRun) -> None:
    """In no response of the whole run a reserved bit or byte was other than 0."""
    found = [incident for incident in whole_run.incidents if incident.violation.rule is RESERVED]
    judge(sdo, found, "reserved bits and bytes are 0", NOT_ZERO)


@should("run.filler", "response.filler")
def test_filler(sdo: Dialogue, whole_run: WholeRun) -> None:
    """In no response of the whole run a byte without data was other than 0."""
    found = [incident for incident in whole_run.incidents if incident.violation.rule is FILLER]
    judge(sdo, found, "bytes without data are 0", NOT_ZERO)


@must("run.no-late-response", "response.unsolicited")
def test_no_late_response(sdo: Dialogue, whole_run: WholeRun) -> None:
    """No response came after its case was over."""
    judge(sdo, whole_run.late, "no response between the cases", BEHIND_THEIR_CASES)


@must("run.outside-the-cases", "response.unsolicited")
def test_outside_the_cases(sdo: Dialogue, whole_run: WholeRun) -> None:
    """Each defect that the suite met outside the cases has failed a case as well."""
    aside = [standing for _, standing in whole_run.causes.aside()]
    # An abort that names another object says less than why there was one.
    aside.sort(key=lambda standing: standing.violation.rule is MULTIPLEXER)
    for standing in aside:
        standing.aside = False
        sdo.record.own.add(standing.violation)
    for met in dict.fromkeys((found.violation.rule.id, found.first_case) for found in aside):
        sdo.info("{} was broken at {}".format(*met))
    if aside:
        sdo.record.minor += [standing.violation for standing in aside[1:]]
        raise aside[0].violation


@must("run.constants", "object.constant")
def test_constants(sdo: Dialogue, device: Device) -> None:
    """At the end of the run the identity and the other constants read as at its beginning."""
    for mux in device.briefly_read():
        if device.is_constant(mux):
            sdo.upload(mux)
