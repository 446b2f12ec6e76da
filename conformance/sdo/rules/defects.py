"""Defects by name: each breaks several rules, and has one cause whatever rule shows it.

The rule of a cause is the one that the defect is about.
"""

from conformance.sdo.frames import BlockSegment, UploadInitiateResponse
from conformance.sdo.kinds import OTHER_DATA, kind_of
from conformance.sdo.rules import (
    ANSWERED,
    IDLE_AFTERWARDS,
    NOT_REFUSED,
    RESTART,
    UNSOLICITED,
    Cause,
    rule_of,
)
from conformance.sdo.rules.block_upload import ENDS, FIRST_SUB_BLOCK, FOREIGN
from conformance.sdo.rules.channels import INDEPENDENT, NMT_INITIALISING
from conformance.sdo.rules.idle import ABORT_NOT_ANSWERED, OUT_OF_BLOCK
from conformance.sdo.rules.segmented_upload import SEGMENTS
from conformance.sdo.rules.sizes import TYPE_LENGTH, VARIABLE_LENGTH
from conformance.sdo.rules.upload_initiates import NO_SWITCH

# Answers that come late, twice or unasked

IS_BEHIND = Cause(ANSWERED.id, "answers are one request behind")
FIRST_TWICE = Cause(UNSOLICITED.id, "the first answers of a run come twice")
ANSWERS_TWICE = Cause(UNSOLICITED.id, "every answer comes twice")
GAVE_UP = Cause(UNSOLICITED.id, "abort 05040000h though no transfer is due to end")
REFUSED_LATE = Cause(UNSOLICITED.id, "an abort behind the confirmation of a download")
ABORT_ANSWERED = Cause(ABORT_NOT_ANSWERED.id, "an answer")
STREAMS = Cause(OUT_OF_BLOCK.id, "segments are sent by and by")

# Transfers that do not end, or disturb each other

GOES_ON = Cause(
    rule_of("server.nothing-afterwards").id, "a transfer goes on that the server has aborted"
)
OLD_GOES_ON = Cause(RESTART.id, "the transfer that was running goes on")
# Within a sub-block a frame is a segment, but for an abort: a server that overlooks that is gone.
DEAF = Cause(IDLE_AFTERWARDS.id, "deaf behind a block download that was aborted")
DISTURBED = Cause(INDEPENDENT.id, "a transfer on one channel disturbs that on another")

# Downloads that store nothing

NOT_STORED = Cause(NOT_REFUSED.id, "a download that is confirmed and not stored")
NUMBER_NOT_STORED = Cause(NOT_REFUSED.id, "a download to a number that is confirmed and not stored")
EXPEDITED_NOT_STORED = Cause(
    NOT_REFUSED.id, "an expedited download that is confirmed and not stored"
)
EMPTY_NOT_STORED = Cause(NOT_REFUSED.id, "a download of no data that is confirmed and not stored")

# Values

VALUES_WRONG = Cause(NOT_REFUSED.id, "values that do not read as they were written")
CHANGED_UNASKED = Cause(IDLE_AFTERWARDS.id, "a value changes behind what is no download")
LENGTH_OF_ANOTHER = Cause(TYPE_LENGTH.id, "values read with more or fewer bytes than they have")
LONGER_THAN_TAKEN = Cause(VARIABLE_LENGTH.id, "values read longer than may be written")
END_MISSING = Cause(SEGMENTS.id, "the end of a value is left out")
STRUCTURE = Cause(rule_of("dictionary.structure").id, *OTHER_DATA)
# A sub-index that an object lacks is served, FFh among others.
SERVED = Cause(rule_of("object.sub-index-missing").id, "served")

# Block uploads

# A block upload is answered with an ordinary one, where its client has not allowed that.
SWITCHED = Cause(NO_SWITCH.id, *kind_of(UploadInitiateResponse))
IN_BLOCKS = Cause(FIRST_SUB_BLOCK.id, *OTHER_DATA)
BEHIND_LAST = Cause(ENDS.id, *kind_of(BlockSegment))
WRONG_COUNT = Cause(ENDS.id, "n is not the number of unused bytes")
FOREIGN_SERVED = Cause(FOREIGN.id, "served")

# Network management

BOOTED_AS_HEARTBEAT = Cause(NMT_INITIALISING.id, "a boot-up message with 7Fh instead of 00h")
# Whatever state is to be seen in them.
NO_HEARTBEATS = Cause(rule_of("nmt.pre-operational").id, "no heartbeats")
