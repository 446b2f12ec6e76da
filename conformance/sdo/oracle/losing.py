"""Where a server is that broke the protocol, or was not watched, and what it may send there."""

from collections.abc import Iterable
from dataclasses import replace

from conformance.sdo.decoding import ANSWERS, decode_request, decode_response
from conformance.sdo.frames import BlockDownloadInitiate, BlockUploadInitiate
from conformance.sdo.oracle.answers import BLOCK_UPLOAD
from conformance.sdo.oracle.block_download import SubBlock
from conformance.sdo.oracle.branch import Branch
from conformance.sdo.oracle.lost import LOST, WATCHED, Lost

BLOCK_INITIATES = (BlockDownloadInitiate, BlockUploadInitiate)
BLOCKS = frozenset((SubBlock.name, BLOCK_UPLOAD))


def lost_from(branches: Iterable[Branch], sent: Iterable[bytes]) -> Lost:
    """Return the state of a server that breaks the protocol, from where it was.

    ``sent`` are the requests since its response before.
    """
    known = list(branches)
    frames = (*sent, *(frame for branch in known for frame in branch.backlog))
    begun = any(isinstance(decode_request(frame), BLOCK_INITIATES) for frame in frames)
    return LOST if begun or any(map(_in_blocks, known)) else WATCHED


def _in_blocks(branch: Branch) -> bool:
    """Say whether a block transfer may be running."""
    state = branch.state
    return state.name in BLOCKS or (isinstance(state, Lost) and not state.watched)


def bears(branch: Branch, data: bytes, *, fits: bool, near: bool) -> bool:
    """Say whether a server that is lost may have sent a response that fits elsewhere, or nowhere.

    Not where it is the answer due: it has been found then. Nor where it is nearly that.
    """
    state = branch.state
    if not isinstance(state, Lost) or (branch.due is not None and not state.asked):
        return False
    return state.owed > 0 or not (fits or near or not state.bears(data))


def bearing(branch: Branch) -> Branch:
    """Return a branch that is lost when one of the answers that it may owe has come."""
    state = branch.state
    if isinstance(state, Lost) and state.owed:
        return replace(branch, state=replace(state, owed=state.owed - 1))
    return rested(branch)


def rested(branch: Branch) -> Branch:
    """Return what a branch is when nothing is on its way any more."""
    state = branch.state
    if not isinstance(state, Lost):
        return branch
    return replace(branch, state=WATCHED if state.watched else LOST, due=None)


def is_fence(sent: list[bytes], crossing: set[bytes], response: bytes) -> bool:
    """Say whether a response proves that all requests before its own are done with.

    A server takes them in order. ``sent`` are the requests since the response before, ``crossing``
    those of which answers may still be on their way.
    """
    if len(sent) != 1 or sent[0] in crossing:
        return False
    request, answer = decode_request(sent[0]), decode_response(response)
    kinds = ANSWERS.get(type(request), ())
    mux = getattr(request, "mux", None)
    return isinstance(answer, kinds) and mux is not None and getattr(answer, "mux", None) == mux
