"""Devices that leave the suite waiting: each comes to its end, and is told as what it is."""

import pytest
from support.run_bench import (
    BASELINE,
    HASTY,
    NODE_ID,
    READ,
    RULE,
    Scripted,
    discovered,
    undiscovered,
)

from conformance.beginning.discovery import discover
from conformance.bus.errors import DeviceLost
from conformance.bus.pace import PROVEN, SHORTEST, TOO_MANY
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.case_record import CaseRecord
from conformance.dialogue.causes import Causes
from conformance.dialogue.dialogue import Dialogue
from conformance.faults.catalogue import build_node
from conformance.faults.faulty.expedited_upload import DiesAtOnce
from conformance.run.case_run import begin_case
from conformance.run.verdict import Afterwards
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import DataType
from conformance.sdo.rules import Violation

MANY = [KnownObject(Multiplexer(0x3000 + number), DataType.UNSIGNED8) for number in range(200)]
SERVED = b"\x4f\x00\x30\x00" + bytes(4)


def test_a_device_that_dies_while_it_is_read_is_asked_no_more() -> None:
    node = Scripted(lambda data: [BASELINE] if len(node.requests) < 3 else [])
    lost = pytest.raises(DeviceLost, match=r"after: upload initiate 3000h:00\. What is wrong: it")
    with undiscovered(node, timeout=HASTY, objects=MANY) as bench, lost:
        discover(bench.channel, bench.device)
    assert len(node.requests) <= 10


def test_a_device_that_is_brought_back_is_read_on_and_the_loss_is_told() -> None:
    """It is the read of one object that it does not survive."""

    def answer(data: bytes) -> list[bytes]:
        if data[:4] == b"\x40\x01\x30\x00":
            gone.append(data)
        served = b"\x4f" + data[1:4] + bytes(4)
        return [] if gone or data[:1] != b"\x40" else [BASELINE if data == READ else served]

    gone: list[bytes] = []
    causes = Causes()
    with undiscovered(Scripted(answer), timeout=HASTY, objects=MANY[:4]) as bench:

        def bring_back() -> bool:
            gone.clear()
            return True

        discover(bench.channel, bench.device, causes, brings_back=bring_back)
        assert [known.mux in bench.device.values for known in MANY[:4]] == [True, False, True, True]
    assert [cause.rule_id for cause, _ in causes.aside()] == ["server.idle-afterwards"]


def test_a_device_that_drops_requests_is_not_read_to_its_end() -> None:
    """Each read of an object is one that is dropped, and so is the fence behind it."""

    def answer(data: bytes) -> list[bytes]:
        if data != READ:
            return [SERVED] if data[:1] == b"\x40" else []
        reads.append(data)
        return [BASELINE] if len(reads) % 3 else []

    reads: list[bytes] = []
    node = Scripted(answer)
    with undiscovered(node, timeout=HASTY, objects=MANY) as bench:
        sdo = Dialogue(bench.channel, bench.device, CaseRecord(RULE), 1)
        while not bench.channel.pace.unsound:
            sdo.upload(MANY[0])
            sdo.fence()
    assert len(reads) < 4 * TOO_MANY


def test_silences_that_were_proven_are_waited_out_no_more() -> None:
    node = Scripted(lambda data: [BASELINE] if data == READ else [])
    with undiscovered(node, timeout=2 * SHORTEST) as bench:
        bench.channel.pace.silences = PROVEN - 1
        sdo = Dialogue(bench.channel, bench.device, CaseRecord(RULE), 1)
        for waited in (500, 250):
            with pytest.raises(Violation, match=f"nothing within {waited} ms"):
                sdo.upload(MANY[0])
            sdo.end_transfer()
            sdo.fence()


def test_a_device_that_dies_in_the_survey_is_lost() -> None:
    node = build_node("dies-at-once", NODE_ID)
    assert isinstance(node, DiesAtOnce)
    node.left = 1000
    with discovered(node, timeout=HASTY) as bench:
        session, node.left = bench.session(), 20
        with pytest.raises(DeviceLost):
            session.survey()
        assert session.lost


def test_a_device_that_dies_while_values_are_put_back_is_asked_no_more() -> None:
    node = build_node("dies-at-once", NODE_ID)
    assert isinstance(node, DiesAtOnce)
    node.left = 1000
    with discovered(node, timeout=HASTY) as bench:
        session = bench.session()
        run = begin_case(session, "upload.size", "upload", RULE)
        for known in Roles(bench.device).all_writable():
            if known.length is not None:
                run.sdo.write_number(known)
        run.sdo.fence()
        assert len(run.sdo.record.written) > 3
        node.left = 1  # the read of 1000h that ends the case
        result = run.conclude(None)
    assert (session.lost, result.afterwards) == (True, Afterwards.LOST)
    assert set(session.restorer.unrestored) == run.sdo.record.written
    assert node.left > -10
