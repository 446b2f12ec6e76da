"""An SDO channel: which frames are responses, what becomes of the others, how long it takes."""

from collections.abc import Iterator

import pytest
from bus_fakes import ANSWER, READ, Bench, message

from conformance.bus.channel import MOST_OVERHEARD, Channel
from conformance.bus.errors import SecondClient
from conformance.bus.messages import to_message
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import ChannelIds, CobId
from conformance.sdo.frames import Abort, UploadInitiate, UploadSegment
from conformance.sdo.layout import Multiplexer
from conformance.sdo.nmt import NmtCommand, NmtMessage

RESPONSE = CanFrame(0x585, ANSWER)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    bench = Bench(monkeypatch)
    yield bench
    bench.link.close()


def test_default_identifiers(bench: Bench) -> None:
    assert (bench.channel.request_id, bench.channel.response_id) == (0x605, 0x585)


def test_requests_go_out_on_600h_plus_node_id(bench: Bench) -> None:
    bench.channel.send(UploadInitiate(Multiplexer(0x1000)))
    bench.channel.send(b"\x40\x00")
    bench.channel.abort(Multiplexer(0x1008), 0x08000000)
    bench.channel.send_frame(CanFrame(0x123, b"\x01"))
    assert [(sent.arbitration_id, sent.data.hex()) for sent in bench.bus.sent] == [
        (0x605, "4000100000000000"),
        (0x605, "4000"),
        (0x605, "8008100000000008"),
        (0x123, "01"),
    ]
    assert not any(sent.is_extended_id for sent in bench.bus.sent)


@pytest.mark.parametrize(
    "response",
    [
        RESPONSE,
        CanFrame(0x585, ANSWER[:7]),
        CanFrame(0x585),
        CanFrame(0x585, ANSWER, extended=True),
        CanFrame(0x585, ANSWER, fd=True),
    ],
    ids=["plain", "DLC-7", "DLC-0", "29-bit", "FD"],
)
def test_what_the_device_sends_is_returned_in_whatever_shape(
    bench: Bench, response: CanFrame
) -> None:
    """In another format it is known by the answer that it holds."""
    bench.channel.send(READ)
    bench.bus.incoming.append(to_message(response))
    assert bench.channel.receive() == response
    assert not bench.channel.overheard


STRANGE = (
    CanFrame(0x585, bytes(8), extended=True),
    CanFrame(0x585, ANSWER[:3] + b"\x01" + ANSWER[4:], extended=True),  # of another object
    CanFrame(0x585, remote=True, length=8),
    CanFrame(0x585, bytes(12), fd=True),
)


def test_what_another_node_sends_with_the_number_of_the_device_is_not_its_answer(
    bench: Bench,
) -> None:
    bench.channel.send(READ)
    bench.bus.incoming.extend(map(to_message, (*STRANGE, RESPONSE, STRANGE[0])))
    assert bench.channel.receive() == RESPONSE
    assert bench.channel.receive() is None
    assert list(bench.channel.overheard) == [*STRANGE, STRANGE[0]]
    assert bench.channel.strangers.lines() == [
        "another node sends 29-bit frames with the CAN-ID of the device's responses: "
        "00000585#0000000000000000 and 2 more",
        "another node sends 11-bit remote frames with the CAN-ID of the device's responses: 585#R8",
        "another node sends 11-bit CAN FD frames with the CAN-ID of the device's responses: "
        "585##0000000000000000000000000",
    ]


def test_a_segment_of_another_format_is_the_answer_to_a_request_of_that_format(
    bench: Bench,
) -> None:
    """It names no object; a frame of another node may well begin as it does."""
    segment = to_message(CanFrame(0x585, b"\x00" + b"ABCDEFG", extended=True))
    asked = UploadSegment(0).encode()
    for frame, answers in (
        (CanFrame(0x605, asked), []),
        (CanFrame(0x605, asked, extended=True), [segment]),
    ):
        bench.channel.send_frame(frame)
        bench.bus.incoming.append(segment)
        assert [to_message(found).data for found in received(bench)] == [
            answer.data for answer in answers
        ]


def received(bench: Bench) -> list[CanFrame]:
    return list(iter(bench.channel.receive, None))


# Aborts on the identifier of the requests

REFUSED = CanFrame(0x605, Abort(Multiplexer(0x1000), 0x08000000).encode())
OTHER_READ = UploadInitiate(Multiplexer(0x1018, 1))
OTHER_ANSWER = CanFrame(0x585, bytes.fromhex("4318100100000C5D"))


def test_an_abort_on_the_identifier_of_the_requests_is_the_device_s_where_no_other_answers(
    bench: Bench,
) -> None:
    bench.channel.send(READ)
    bench.bus.incoming.append(to_message(REFUSED))
    assert received(bench) == [REFUSED]
    bench.channel.send(READ)
    bench.bus.incoming.append(to_message(REFUSED))
    before = bench.clock.now
    assert bench.channel.receive() == REFUSED
    assert bench.clock.now == before  # the second is no more in doubt


def test_it_is_the_device_s_as_well_where_what_was_asked_next_is_answered(bench: Bench) -> None:
    bench.channel.send(READ)
    bench.channel.send(OTHER_READ)
    bench.bus.incoming.extend(map(to_message, (REFUSED, OTHER_ANSWER)))
    assert received(bench) == [REFUSED, OTHER_ANSWER]


def test_it_is_the_device_s_answer_to_an_abort(bench: Bench) -> None:
    bench.channel.abort(Multiplexer(0x1000), 0x08000000)
    bench.channel.send(READ)
    bench.bus.incoming.extend(map(to_message, (REFUSED, RESPONSE)))
    assert received(bench) == [REFUSED, RESPONSE]


@pytest.mark.parametrize(
    "frames",
    [
        (REFUSED, RESPONSE),
        (CanFrame(0x605, Abort(Multiplexer(0x2000), 0x08000000).encode()),),
        (REFUSED, CanFrame(0x605, READ)),
    ],
    ids=["the-device-answers", "of-another-object", "a-client-s-request-behind-it"],
)
def test_it_is_a_second_client_s(bench: Bench, frames: tuple[CanFrame, ...]) -> None:
    bench.channel.send(OTHER_READ)
    bench.channel.send(READ)
    bench.bus.incoming.extend(map(to_message, frames))
    with pytest.raises(SecondClient):
        bench.channel.receive()


def test_other_frames_are_overheard(bench: Bench) -> None:
    foreign = [
        CanFrame(0x586, ANSWER),
        CanFrame(0x604, READ),
        CanFrame(0x185, b"\x01"),
        CanFrame(0x605, READ, extended=True),
    ]
    bench.bus.incoming.extend(
        message(frame.can_id, frame.data, extended=frame.extended) for frame in foreign
    )
    bench.bus.incoming.append(message(0x585, ANSWER))
    assert bench.channel.receive() == RESPONSE
    assert list(bench.channel.overheard) == foreign


def test_only_the_latest_are_kept(bench: Bench) -> None:
    bench.bus.incoming.extend(
        message(0x185, number.to_bytes(2, "big")) for number in range(MOST_OVERHEARD + 1)
    )
    assert bench.channel.receive() is None
    assert len(bench.channel.overheard) == MOST_OVERHEARD
    assert bench.channel.overheard[0].data == b"\x00\x01"


def test_a_second_client(bench: Bench) -> None:
    bench.bus.incoming.append(message(0x605, b"", remote=True))  # asks the device for nothing
    for look in (bench.channel.receive, bench.channel.waiting):
        bench.bus.incoming.append(message(0x605, READ))
        with pytest.raises(SecondClient, match="Another node sends SDO requests on 605h"):
            look()


def test_what_has_arrived_is_still_received(bench: Bench) -> None:
    assert not bench.channel.waiting()
    bench.bus.incoming.extend([message(0x585, ANSWER), message(0x705, b"\x05")])
    for _ in range(3):
        assert list(bench.channel.waiting()) == [RESPONSE]
    assert bench.channel.receive() == RESPONSE


def test_what_has_arrived_is_taken_as_long_as_it_is_wanted(bench: Bench) -> None:
    """No more than is asked for, without waiting, and what is not wanted stays where it is."""
    segments = [bytes((number, *bytes(7))) for number in (1, 2, 3, 0x80)]
    bench.bus.incoming.append(message(0x185, b"\x01"))
    bench.bus.incoming.extend(message(0x585, segment) for segment in segments)
    begin = bench.clock.now
    assert bench.channel.take_arrived(1, lambda frame: frame.data[0] < 0x80) == []  # another's
    first = bench.channel.take_arrived(1, lambda frame: frame.data[0] < 0x80)
    others = bench.channel.take_arrived(9, lambda frame: frame.data[0] < 0x80)
    assert [frame.data for frame in (*first, *others)] == segments[:3]
    assert bench.channel.receive() == CanFrame(0x585, segments[3])
    assert bench.channel.take_arrived(9, lambda frame: True) == []
    assert bench.clock.now - begin < 0.01


def test_what_has_arrived_before_an_abort_is_taken_before_it(bench: Bench) -> None:
    """The abort is on the identifier of the requests: it does not answer for what came before."""
    segments = [bytes((number, *bytes(7))) for number in (1, 2, 3)]
    bench.channel.send(READ)
    for segment in segments:
        bench.bus.incoming.append(message(0x585, segment))
    bench.bus.incoming.append(to_message(REFUSED))
    found = bench.channel.take_arrived(9, lambda frame: True)
    assert [frame.data for frame in found] == segments
    assert bench.channel.receive() == REFUSED


def test_what_has_arrived_tells_when_its_first_and_its_last_did(bench: Bench) -> None:
    for number in (1, 2):
        bench.bus.incoming.append(message(0x585, bytes((number, *bytes(7)))))
        bench.clock.now += 1
        bench.channel.waiting()
    bench.channel.take_arrived(2, lambda frame: True)
    assert (bench.channel.waited_since, bench.channel.arrived) == (1001.0, 1002.0)


def test_a_second_client_between_what_has_arrived(bench: Bench) -> None:
    bench.bus.incoming.append(message(0x605, READ))
    with pytest.raises(SecondClient):
        bench.channel.take_arrived(1, lambda frame: True)


# Boot-up


def test_boot_up(bench: Bench) -> None:
    bench.bus.incoming.extend([message(0x705, b"\x00"), message(0x585, ANSWER)])
    assert bench.channel.receive() == RESPONSE
    assert bench.channel.boot_ups == 1
    assert list(bench.channel.overheard) == [CanFrame(0x705, b"\x00")]


@pytest.mark.parametrize(
    "frame",
    [
        CanFrame(0x705, b"\x05"),
        CanFrame(0x705, b"\x7f"),
        CanFrame(0x705, b""),
        CanFrame(0x705, b"\x00\x00"),
        CanFrame(0x706, b"\x00"),
        CanFrame(0x705, b"\x00", extended=True),
    ],
    ids=["operational", "pre-operational", "empty", "two-bytes", "other-node", "29-bit"],
)
def test_no_boot_up(bench: Bench, frame: CanFrame) -> None:
    bench.bus.incoming.append(message(frame.can_id, frame.data, extended=frame.extended))
    assert bench.channel.receive() is None
    assert bench.channel.boot_ups == 0


# Heartbeats


def test_heartbeats_wait_until_they_are_asked_for(bench: Bench) -> None:
    bench.bus.incoming.extend(
        [
            message(0x705, b"\x7f"),
            message(0x706, b"\x05"),
            message(0x705, b"\x05", extended=True),
            message(0x705, b"\x05\x05"),
            message(0x585, ANSWER),
            message(0x705, b"\x00"),
        ]
    )
    assert bench.channel.receive() == RESPONSE
    assert bench.channel.receive_error_control() == CanFrame(0x705, b"\x7f")
    assert bench.channel.receive_error_control() == CanFrame(0x705, b"\x00")
    assert bench.channel.receive_error_control() is None


def test_what_came_before_an_nmt_command_tells_nothing_of_it(bench: Bench) -> None:
    bench.bus.incoming.extend([message(0x705, b"\x7f"), message(0x585, ANSWER)])
    bench.channel.receive()
    bench.channel.send_nmt(NmtMessage(NmtCommand.STOP, 5))
    assert bench.bus.sent[-1].arbitration_id == 0
    assert bench.bus.sent[-1].data == b"\x02\x05"
    bench.bus.incoming.append(message(0x705, b"\x04"))
    assert bench.channel.receive_error_control() == CanFrame(0x705, b"\x04")


# Two channels on one link

LONG = ChannelIds(CobId(0x18FF_0681, True), CobId(0x18FF_06A1, True))


def test_a_channel_of_its_own_identifiers(bench: Bench) -> None:
    other = Channel(bench.link, 5, 0.5, LONG)
    other.send(READ)
    assert (bench.bus.sent[-1].arbitration_id, bench.bus.sent[-1].is_extended_id) == (
        0x18FF_0681,
        True,
    )
    bench.bus.incoming.append(message(0x18FF_06A1, ANSWER, extended=True))
    assert other.receive() == CanFrame(0x18FF_06A1, ANSWER, extended=True)


def test_frames_of_another_channel_wait_for_it_in_order(bench: Bench) -> None:
    other = Channel(bench.link, 5, 0.5, ChannelIds(CobId(0x681), CobId(0x6A1)))
    bench.bus.incoming.extend(
        [message(0x6A1, bytes((number,)) * 8) for number in range(3)] + [message(0x585, ANSWER)]
    )
    assert bench.channel.receive() == RESPONSE
    assert [other.receive(0) for _ in range(4)] == [
        *(CanFrame(0x6A1, bytes((number,)) * 8) for number in range(3)),
        None,
    ]
    bench.bus.incoming.extend([message(0x585, ANSWER), message(0x6A1, ANSWER)])
    assert other.receive() == CanFrame(0x6A1, ANSWER)
    assert bench.channel.receive() == RESPONSE


def test_a_closed_channel_takes_nothing_more(bench: Bench) -> None:
    other = Channel(bench.link, 5, 0.5, LONG)
    other.close()
    bench.bus.incoming.append(message(0x18FF_06A1, ANSWER, extended=True))
    assert bench.channel.receive() is None
    assert other.receive(0) is None


def test_a_second_client_concerns_the_channel_that_it_uses(bench: Bench) -> None:
    other = Channel(bench.link, 5, 0.5, LONG)
    bench.bus.incoming.extend([message(0x605, READ), message(0x18FF_06A1, ANSWER, extended=True)])
    assert other.receive() is not None
    bench.bus.incoming.append(message(0x18FF_0681, READ, extended=True))
    with pytest.raises(SecondClient, match="requests on 18FF0681h"):
        other.receive()


# Time


def test_silence_takes_the_response_time_out(bench: Bench) -> None:
    assert bench.channel.receive() is None
    assert bench.clock.now == pytest.approx(1000.5, abs=0.01)


def test_another_time_out(bench: Bench) -> None:
    assert bench.channel.receive(2.0) is None
    assert bench.clock.now == pytest.approx(1002.0, abs=0.01)


@pytest.mark.parametrize("can_id", [0x185, 0x586, 0x705])
def test_foreign_traffic_does_not_put_the_deadline_off(bench: Bench, can_id: int) -> None:
    bench.bus.receipt_takes = 0.0001
    bench.bus.source = lambda: message(can_id, b"\x01")
    assert bench.channel.receive() is None
    assert 1000.5 <= bench.clock.now < 1001.0


def test_foreign_traffic_that_is_filtered_does_not_put_the_deadline_off(bench: Bench) -> None:
    bench.link.watch([5])
    bench.bus.receipt_takes = 0.0001
    bench.bus.source = lambda: message(0x123, b"\x01")
    assert bench.channel.receive() is None
    assert 1000.5 <= bench.clock.now < 1001.0


def test_a_response_within_foreign_traffic(bench: Bench) -> None:
    bench.bus.receipt_takes = 0.0001
    bench.bus.incoming.extend([message(0x185, b"\x01")] * 1000)
    bench.bus.incoming.append(message(0x585, ANSWER))
    assert bench.channel.receive() == RESPONSE


@pytest.mark.parametrize("can_id", [0x185, 0x123], ids=["overheard", "filtered"])
def test_with_no_time_at_all_what_has_arrived_is_found(bench: Bench, can_id: int) -> None:
    """Also behind other frames, and on buses whose filters python-can applies itself."""
    bench.link.watch([5])
    bench.bus.incoming.extend([message(can_id, b"\x01"), message(0x585, ANSWER)])
    assert bench.channel.receive(0) == RESPONSE
    assert bench.channel.receive(0) is None
    assert bench.clock.now < 1000.1
