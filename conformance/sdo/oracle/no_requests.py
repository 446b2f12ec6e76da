"""Frames on the COB-ID of the requests that are none: remote frames, and the other identifier.

CiA 301, 7.2.4.3 does not say what becomes of them. To ignore them is what is expected; a server
that refuses a remote frame, or takes the other length of identifier for its own, misses a SHOULD.
"""

from collections.abc import Iterator

from conformance.sdo.can_frame import CanFrame
from conformance.sdo.oracle.answers import DueAbort
from conformance.sdo.oracle.branch import Branch
from conformance.sdo.oracle.states import IDLE
from conformance.sdo.rules import Violation, channels


def hear_no_request(branch: Branch, frame: CanFrame) -> Iterator[Branch]:
    """Yield how a branch may go on with a remote frame, or with one of the other format."""
    yield branch
    if branch.due is not None:
        return
    if frame.remote:
        missed = Violation(
            channels.REMOTE_IGNORED, expected="silence to a remote frame", actual="an abort"
        )
        refusal = DueAbort(channels.REMOTE, findings=(missed,))
        # Whether such an abort ends a transfer is as open as the abort itself.
        for after in (branch.state, IDLE):
            yield refusal.branch(branch.state, after, branch.memory, *branch.freedoms)
        return
    missed = Violation(
        channels.EXTENDED_IGNORED,
        expected="a frame with the other length of identifier to be ignored",
        actual="taken for a request",
    )
    for served in branch.state.receive(frame.data, branch.memory):
        yield served.choosing(*branch.freedoms).noting(missed)
