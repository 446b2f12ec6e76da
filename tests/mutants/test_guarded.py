"""A guarded fault is right until its guard holds, and then wrong as it is in the catalogue."""

import pytest
from drawn import drawn
from showing import FIRST, READ, REQUEST, SECOND, START, Duet, is_guardable
from support.oracle_objects import NODE_ID, TEXT, VENDOR_ID
from support.oracle_sequences import Script, Silence, frame, stored

from conformance.faults.catalogue import UnknownServer, build_node, find_deviation
from conformance.faults.guards import guards
from conformance.model_cases.conversations.conversation import Service, Transfer
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.frames import Abort, BlockUploadInitiate, UploadInitiate, UploadSegment
from conformance.sdo.layout import Multiplexer

NUMBER = Transfer(Service.UPLOAD, Multiplexer(0x2004))
BLOCKS = Transfer(Service.BLOCK_UPLOAD, TEXT, block_sizes=(2,))
UNSIZED = Transfer(Service.DOWNLOAD, TEXT, 20, sized=False)
MISSING = Transfer(Service.UPLOAD, Multiplexer(0x2FFF))
CLIENT_ABORT = frame(Abort(TEXT, AbortCode.GENERAL_ERROR))
# Scripts in which a guard never holds, and steps behind which it does. Every answer is wrong then.
SHOWN: dict[str, tuple[Script, Script]] = {
    "operational": ((NUMBER,), (START, NUMBER)),
    "further-channel": (
        (NUMBER,),
        (FIRST, SECOND, CanFrame(REQUEST, UploadInitiate(VENDOR_ID).encode())),
    ),
    "unsigned32": ((Transfer(Service.UPLOAD, TEXT),), (NUMBER,)),
    "2010h": ((NUMBER,), (Transfer(Service.UPLOAD, TEXT),)),
    "sub-index": ((NUMBER,), (READ,)),
    "last-sub-index": (
        (READ, NUMBER),
        (Transfer(Service.UPLOAD, Multiplexer(0x1018, 4)),),
    ),
    "beyond-127": ((stored(127),), (stored(140),)),
    "second-sub-block": ((stored(30), NUMBER), (BLOCKS,)),
    "third-sub-block": ((stored(14), BLOCKS), (stored(30), BLOCKS)),
    "unsized": ((stored(20), NUMBER), (UNSIZED,)),
    "behind-client-abort": ((NUMBER, CLIENT_ABORT), (NUMBER,)),
    "behind-server-abort": ((NUMBER, MISSING), (NUMBER,)),
    "behind-time-out": ((stored(20), frame(UploadInitiate(TEXT)), Silence.TIME_OUT), (NUMBER,)),
    "behind-other-service": ((NUMBER, NUMBER), (frame(BlockUploadInitiate(TEXT, 127)),)),
    "behind-stray-segment": ((NUMBER, frame(UploadSegment(0))), (NUMBER,)),
    "from-101th-transfer": ([NUMBER] * 100, (NUMBER,)),
    "refused": ((NUMBER, stored(9)), (MISSING,)),
}


@pytest.mark.parametrize("name", SHOWN)
def test_a_fault_shows_while_its_guard_holds(name: str) -> None:
    played = duet(f"answers-twice@{name}")
    before, then = SHOWN[name]
    assert not played.play(before)
    assert played.play(then)


def test_each_guard_is_tried_but_for_further_types_objects_and_places() -> None:
    assert {guards()[name].factor for name in SHOWN} == {each.factor for each in guards().values()}


def test_methods_of_a_server_are_switched_too() -> None:
    reading = frame(UploadInitiate(TEXT)), frame(UploadSegment(1))
    played = duet("upload-toggle-ignored@operational")
    assert not played.play((stored(20), *reading, CLIENT_ABORT))
    assert played.play((START, *reading))


def test_a_fault_beyond_the_methods_is_found() -> None:
    assert is_guardable("upload-toggle-ignored")
    assert not is_guardable("vendor-id-0")


def test_what_was_drawn_is_there() -> None:
    for name in drawn():
        fault = find_deviation(name)
        assert fault is not None
        assert fault.is_fault
        assert fault.sentence.count(". Only ") == 1


@pytest.mark.parametrize("name", ["upload-toggle-ignored@operatonal", "none@operational"])
def test_an_unknown_name(name: str) -> None:
    with pytest.raises(UnknownServer):
        find_deviation(name)


def duet(name: str) -> Duet:
    return Duet(build_node(name, NODE_ID), build_node(None, NODE_ID), further=False)
