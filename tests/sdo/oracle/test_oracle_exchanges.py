"""What the oracle says of single exchanges, by the rule that each is about.

An exchange is written a line a frame: ``>`` the client, ``<`` the server. ``:`` says what the
oracle has to find at the end, by the id of the rule; without it everything was allowed.
"""

from dataclasses import replace

import pytest
from sdo_vectors import mux

from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, DataType
from conformance.sdo.oracle import Awaited, Facts, Knowledge, Oracle, Presence
from conformance.sdo.rules import Violation


def facts(data_type: DataType, value: bytes, access: Access = Access.RW) -> Facts:
    return Facts(
        Presence.PRESENT, access, data_type, value, steady=True, any_value=True, capacity=64
    )


KNOWN = Knowledge.complete(
    {
        mux("1000"): facts(DataType.UNSIGNED32, b"\x91\x01\x0f\0", Access.CONST),
        mux("1008"): facts(DataType.VISIBLE_STRING, b"Tiny Node", Access.CONST),
        mux("2000"): facts(DataType.UNSIGNED32, b"\1\2\3\4"),
        mux("2001"): replace(facts(DataType.UNSIGNED8, b"\1"), low=1, high=9),
        mux("2002"): facts(DataType.UNSIGNED32, b"\1\2\3\4", Access.WO),
        mux("2010"): facts(DataType.VISIBLE_STRING, b"old value"),
    }
)
READ = "> 40 00 10 00 00 00 00 00"
UPLOAD = "> 40 08 10 00 00 00 00 00 \n < 41 08 10 00 09 00 00 00"
DOWNLOAD = "> 21 10 20 00 09 00 00 00 \n < 60 10 20 00 00 00 00 00"
BLOCK_DOWNLOAD = "> C6 10 20 00 0E 00 00 00 \n < A4 10 20 00 04 00 00 00"
BLOCK_SENT = (
    BLOCK_DOWNLOAD
    + "\n > 01 30 31 32 33 34 35 36 \n > 82 37 38 39 3A 3B 3C 3D \n < A2 02 04 00 00 00 00 00"
)
BLOCK_UPLOAD = "> A4 08 10 00 02 00 00 00 \n < C6 08 10 00 09 00 00 00"
BLOCK_RECEIVED = (
    BLOCK_UPLOAD
    + "\n > A3 00 00 00 00 00 00 00 \n < 01 54 69 6E 79 20 4E 6F \n < 82 64 65 00 00 00 00 00"
)
NO_SUCH = "02 00 06"


def judged(exchange: str, oracle: Oracle | None = None) -> list[Violation]:
    oracle = oracle or Oracle(KNOWN)
    found: list[Violation] = []
    before = ""
    for line in filter(None, map(str.strip, exchange.splitlines())):
        direction, frame = line[0], bytes.fromhex(line[1:])
        if direction == "<":
            found += oracle.response(frame)
        else:
            found += oracle.settled() if before == "<" else []
            oracle.request(frame)
        before = direction
    return found + oracle.settled()


ALLOWED = {
    "response.not-refused read": f"{READ} \n < 43 00 10 00 91 01 0F 00",
    "response.not-refused read in segments": f"{READ} \n < 41 00 10 00 04 00 00 00",
    "response.not-refused read without count": f"{READ} \n < 42 00 10 00 91 01 0F 00",
    "object.missing-refused": "> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 00 00 02 06",
    "object.sub-index-missing": "> 40 00 10 01 00 00 00 00 \n < 80 00 10 01 11 00 09 06",
    "object.write-only": "> 40 02 20 00 00 00 00 00 \n < 80 02 20 00 01 00 01 06",
    "object.read-only": "> 23 00 10 00 91 01 0F 00 \n < 80 00 10 00 02 00 01 06",
    "specifier.unknown": "> E0 00 10 00 00 00 00 00 \n < 80 12 34 56 01 00 04 05",
    "segmented-download.without-initiate silence": "> 00 00 00 00 00 00 00 00",
    "segmented-download.without-initiate abort": (
        "> 00 00 00 00 00 00 00 00 \n < 80 00 00 00 01 00 04 05"
    ),
    "abort.not-answered": "> 80 00 10 00 00 00 00 08",
    "specifier.sub-command silence": "> A6 08 10 00 7F 00 00 00",
    "specifier.sub-command abort": "> C7 10 20 00 0E 00 00 00 \n < 80 10 20 00 01 00 04 05",
    "upload.request-reserved-bits accepted": (
        "> 41 00 10 00 00 00 00 00 \n < 43 00 10 00 91 01 0F 00"
    ),
    "upload.request-reserved-bits refused": (
        "> 41 00 10 00 00 00 00 00 \n < 80 00 10 00 01 00 04 05"
    ),
    "download.too-long": "> 23 01 20 00 01 02 03 04 \n < 80 01 20 00 12 00 07 06",
    "download.too-short generic": "> 2F 00 20 00 01 00 00 00 \n < 80 00 20 00 10 00 07 06",
    "segmented-download.number-too-long at once": (
        "> 21 01 20 00 05 00 00 00 \n < 80 01 20 00 12 00 07 06"
    ),
    "segmented-download.number-too-long later": (
        "> 21 01 20 00 02 00 00 00 \n < 60 01 20 00 00 00 00 00 \n "
        "> 0B 01 02 00 00 00 00 00 \n < 80 01 20 00 12 00 07 06"
    ),
    "object.limits": "> 2F 01 20 00 0A 00 00 00 \n < 80 01 20 00 31 00 09 06",
    "block-upload.invalid-block-size": "> A0 00 10 00 80 00 00 00 \n < 80 00 10 00 02 00 04 05",
    "block.unsupported": "> A0 00 10 00 7F 00 00 00 \n < 80 00 10 00 01 00 04 05",
    "block-upload.switch": "> A0 00 10 00 7F 04 00 00 \n < 43 00 10 00 91 01 0F 00",
    "segmented-download.toggle abort": (
        f"{DOWNLOAD} \n > 10 41 42 43 44 45 46 47 \n < 80 10 20 00 00 00 03 05"
    ),
    "segmented-download.toggle silence": f"{DOWNLOAD} \n > 10 41 42 43 44 45 46 47",
    "segmented-download.too-many": (
        f"{DOWNLOAD} \n > 00 41 42 43 44 45 46 47 \n < 20 00 00 00 00 00 00 00 \n "
        "> 19 41 42 43 00 00 00 00 \n < 80 10 20 00 12 00 07 06"
    ),
    "segmented-download.block-frames": (
        f"{DOWNLOAD} \n > A2 00 00 00 00 00 00 00 \n < 80 10 20 00 01 00 04 05"
    ),
    "segmented-download.client-abort": f"{DOWNLOAD} \n > 80 10 20 00 00 00 00 08",
    "server.new-initiate-served served": f"{DOWNLOAD} \n {READ} \n < 43 00 10 00 91 01 0F 00",
    "segmented-upload.segments": (
        f"{UPLOAD} \n > 60 00 00 00 00 00 00 00 \n < 00 54 69 6E 79 20 4E 6F \n "
        "> 70 00 00 00 00 00 00 00 \n < 1B 64 65 00 00 00 00 00"
    ),
    "segmented-upload.toggle": (
        f"{UPLOAD} \n > 70 00 00 00 00 00 00 00 \n < 80 08 10 00 00 00 03 05"
    ),
    "block-download.gap not before its time-out": f"{BLOCK_DOWNLOAD} \n > 82 30 31 32 33 34 35 36",
    "block-download.gap late segment taken": (
        f"{BLOCK_DOWNLOAD} \n > 02 30 31 32 33 34 35 36 \n > 01 30 31 32 33 34 35 36 \n "
        "> 83 30 31 32 33 34 35 36 \n < A2 01 04 00 00 00 00 00"
    ),
    "block-download.gap late segment discarded": (
        f"{BLOCK_DOWNLOAD} \n > 02 30 31 32 33 34 35 36 \n > 01 30 31 32 33 34 35 36 \n "
        "> 83 30 31 32 33 34 35 36 \n < A2 00 04 00 00 00 00 00"
    ),
    "block-download.gap late segment refused": (
        f"{BLOCK_DOWNLOAD} \n > 02 30 31 32 33 34 35 36 \n > 01 30 31 32 33 34 35 36 \n "
        "< 80 10 20 00 03 00 04 05"
    ),
    "block-download.gap at once": (
        f"{BLOCK_DOWNLOAD} \n > 02 30 31 32 33 34 35 36 \n < A2 00 04 00 00 00 00 00"
    ),
    "block-download.gap at the end": (
        f"{BLOCK_DOWNLOAD} \n > 02 30 31 32 33 34 35 36 \n > 03 30 31 32 33 34 35 36 \n "
        "> 04 30 31 32 33 34 35 36 \n < A2 00 04 00 00 00 00 00"
    ),
    "block-download.abort-in-sub-block": f"{BLOCK_DOWNLOAD} \n > 80 10 20 00 00 00 00 08",
    "block-download.stored": (
        f"{BLOCK_SENT} \n > C1 D2 A8 00 00 00 00 00 \n < A1 00 00 00 00 00 00 00"
    ),
    "block-download.crc": f"{BLOCK_SENT} \n > C1 D3 A8 00 00 00 00 00 \n < 80 10 20 00 04 00 04 05",
    "block-download.last-again again": (
        f"{BLOCK_SENT} \n > 82 37 38 39 3A 3B 3C 3D \n < A2 02 04 00 00 00 00 00"
    ),
    "block-upload.not-started": (
        f"{BLOCK_UPLOAD} \n > A2 00 02 00 00 00 00 00 \n < 80 08 10 00 01 00 04 05"
    ),
    "block-upload.acknowledged": (
        f"{BLOCK_RECEIVED} \n > A2 01 02 00 00 00 00 00 \n < 81 64 65 00 00 00 00 00"
    ),
    "block-upload.acknowledges-too-many": (
        f"{BLOCK_RECEIVED} \n > A2 03 02 00 00 00 00 00 \n < 80 08 10 00 03 00 04 05"
    ),
    "block-upload.acknowledges-block-size": (
        f"{BLOCK_RECEIVED} \n > A2 02 00 00 00 00 00 00 \n < 80 08 10 00 02 00 04 05"
    ),
    "block-upload.over": (
        f"{BLOCK_RECEIVED} \n > A2 02 02 00 00 00 00 00 \n < D5 50 40 00 00 00 00 00 \n "
        "> A1 00 00 00 00 00 00 00"
    ),
    "frame.short silence": "> 40 00 10 00",
    "frame.short served": "> 40 00 10 00 \n < 43 00 10 00 91 01 0F 00",
    "request.behind-another": (
        f"{READ} \n > 40 08 10 00 00 00 00 00 \n < 43 00 10 00 91 01 0F 00 \n "
        "< 41 08 10 00 09 00 00 00"
    ),
}
LONG_SUB_BLOCK = "> C4 10 20 00 00 00 00 00 \n < A4 10 20 00 7F 00 00 00 \n" + " \n ".join(
    f"> {number:02X} 41 42 43 44 45 46 47" for number in range(1, 21)
)
NOT_ALLOWED = {
    "long sub-block: unknown code": (
        f"{LONG_SUB_BLOCK} \n < 80 10 20 00 99 99 99 99",
        "abort.code",
    ),
    "long sub-block: foreign multiplexer": (
        f"{LONG_SUB_BLOCK} \n < 80 12 34 00 12 00 07 06",
        "response.multiplexer",
    ),
    "long sub-block: reserved bits": (
        f"{LONG_SUB_BLOCK} \n < 91 10 20 00 12 00 07 06",
        "response.reserved",
    ),
    "response.not-refused unanswered": (READ, "response.answered"),
    "response.not-refused refused": (
        f"{READ} \n < 80 00 10 00 00 00 02 06",
        "response.not-refused",
    ),
    "response.not-refused value": (f"{READ} \n < 43 00 10 00 92 01 0F 00", "response.not-refused"),
    "response.multiplexer": (f"{READ} \n < 43 01 10 00 91 01 0F 00", "response.multiplexer"),
    "response.unsolicited": (
        f"{READ} \n < 43 00 10 00 91 01 0F 00 \n < 43 00 10 00 91 01 0F 00",
        "response.unsolicited",
    ),
    "response.frame": (f"{READ} \n < 43 00 10 00 91 01 0F", "response.frame"),
    "object.missing-refused served": (
        "> 40 FF 1F 00 00 00 00 00 \n < 43 FF 1F 00 00 00 00 00",
        "object.missing-refused",
    ),
    "object.read-only code": (
        "> 23 00 10 00 91 01 0F 00 \n < 80 00 10 00 01 00 01 06",
        "object.read-only",
    ),
    "specifier.unknown silence": ("> E0 00 10 00 00 00 00 00", "response.answered"),
    "segmented-download.without-initiate served": (
        "> 00 00 00 00 00 00 00 00 \n < 20 00 00 00 00 00 00 00",
        "segmented-download.without-initiate",
    ),
    "segmented-upload.without-initiate served": (
        "> 60 00 00 00 00 00 00 00 \n < 01 54 69 6E 79 20 4E 6F",
        "segmented-upload.without-initiate",
    ),
    "specifier.out-of-block served": (
        "> A2 02 04 00 00 00 00 00 \n < 01 54 69 6E 79 20 4E 6F",
        "specifier.out-of-block",
    ),
    "specifier.sub-command served as an upload": (
        "> A6 08 10 00 7F 00 00 00 \n < C6 08 10 00 09 00 00 00",
        "specifier.sub-command",
    ),
    "specifier.sub-command served as a download": (
        "> C7 10 20 00 0E 00 00 00 \n < A4 10 20 00 04 00 00 00",
        "specifier.sub-command",
    ),
    "specifier.sub-command code": (
        "> A6 08 10 00 7F 00 00 00 \n < 80 08 10 00 02 00 04 05",
        "specifier.sub-command",
    ),
    "abort.not-answered answered": (
        "> 80 00 10 00 00 00 00 08 \n < 80 00 10 00 00 00 00 08",
        "abort.not-answered",
    ),
    "download.too-long code": (
        "> 23 01 20 00 01 02 03 04 \n < 80 01 20 00 13 00 07 06",
        "download.too-long",
    ),
    "object.limits stored": (
        "> 2F 01 20 00 0A 00 00 00 \n < 60 01 20 00 00 00 00 00",
        "object.limits",
    ),
    "block-upload.no-switch": (
        "> A0 00 10 00 7F 00 00 00 \n < 43 00 10 00 91 01 0F 00",
        "response.not-refused",
    ),
    "segmented-download.toggle confirmed": (
        f"{DOWNLOAD} \n > 10 41 42 43 44 45 46 47 \n < 30 00 00 00 00 00 00 00",
        "segmented-download.toggle",
    ),
    "segmented-download.upload-segment ignored": (
        f"{DOWNLOAD} \n > 60 00 00 00 00 00 00 00",
        "response.answered",
    ),
    "segmented-download.unknown-specifier ignored": (
        f"{DOWNLOAD} \n > E0 00 00 00 00 00 00 00",
        "response.answered",
    ),
    "segmented-download.block-frames ignored": (
        f"{DOWNLOAD} \n > A2 00 00 00 00 00 00 00",
        "response.answered",
    ),
    "segmented-upload.download-segment ignored": (
        f"{UPLOAD} \n > 00 41 42 43 44 45 46 47",
        "response.answered",
    ),
    "segmented-upload.unknown-specifier ignored": (
        f"{UPLOAD} \n > E0 00 00 00 00 00 00 00",
        "response.answered",
    ),
    "segmented-download.too-few confirmed": (
        f"{DOWNLOAD} \n > 01 41 42 43 44 45 46 47 \n < 20 00 00 00 00 00 00 00",
        "segmented-download.too-few",
    ),
    "server.new-initiate-served silence": (f"{DOWNLOAD} \n {READ}", "response.answered"),
    "segmented-upload.toggle served": (
        f"{UPLOAD} \n > 70 00 00 00 00 00 00 00 \n < 10 54 69 6E 79 20 4E 6F",
        "segmented-upload.toggle",
    ),
    "segmented-upload.segments toggle": (
        f"{UPLOAD} \n > 60 00 00 00 00 00 00 00 \n < 10 54 69 6E 79 20 4E 6F",
        "response.toggle",
    ),
    "segmented-upload.segments last early": (
        f"{UPLOAD} \n > 60 00 00 00 00 00 00 00 \n < 01 54 69 6E 79 20 4E 6F",
        "upload.size",
    ),
    "block-download.full-sub-block answered": (
        f"{BLOCK_DOWNLOAD} \n > 01 30 31 32 33 34 35 36 \n < A2 01 04 00 00 00 00 00",
        "block-download.full-sub-block",
    ),
    "block-download.gap beyond": (
        f"{BLOCK_DOWNLOAD} \n > 82 30 31 32 33 34 35 36 \n < A2 02 04 00 00 00 00 00",
        "block.acknowledgement",
    ),
    "block.size": (
        "> C4 10 20 00 00 00 00 00 \n < A4 10 20 00 80 00 00 00",
        "block.size",
    ),
    "block-download.crc confirmed": (
        f"{BLOCK_SENT} \n > C1 D3 A8 00 00 00 00 00 \n < A1 00 00 00 00 00 00 00",
        "block-download.crc",
    ),
    "block-download.foreign-at-end ignored": (
        f"{BLOCK_SENT} \n > 60 00 00 00 00 00 00 00",
        "response.answered",
    ),
    "block-upload.first-sub-block number": (
        f"{BLOCK_UPLOAD} \n > A3 00 00 00 00 00 00 00 \n < 02 54 69 6E 79 20 4E 6F",
        "block.sequence",
    ),
    "block-upload.first-sub-block incomplete": (
        f"{BLOCK_UPLOAD} \n > A3 00 00 00 00 00 00 00 \n < 01 54 69 6E 79 20 4E 6F",
        "block-upload.first-sub-block",
    ),
    "block-upload.acknowledged skipped": (
        f"{BLOCK_RECEIVED} \n > A2 01 02 00 00 00 00 00 \n < D5 50 40 00 00 00 00 00",
        "block.sequence",
    ),
    "block-upload.end CRC": (
        f"{BLOCK_RECEIVED} \n > A2 02 02 00 00 00 00 00 \n < D5 00 00 00 00 00 00 00",
        "block.crc",
    ),
    "block-upload.over answered": (
        f"{BLOCK_RECEIVED} \n > A2 02 02 00 00 00 00 00 \n < D5 50 40 00 00 00 00 00 \n"
        "> A1 00 00 00 00 00 00 00 \n < A1 00 00 00 00 00 00 00",
        "block-upload.over",
    ),
    "frame.short from bytes not sent": (
        "> 23 00 20 00 01 02 \n < 60 00 20 00 00 00 00 00",
        "frame.short",
    ),
    "abort.precise-code": (
        "> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 00 00 00 08",
        "abort.precise-code",
    ),
    "server.new-initiate-served refused": (
        f"{DOWNLOAD} \n {READ} \n < 80 00 10 00 22 00 00 08",
        "server.new-initiate-served",
    ),
    "private code": ("> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 01 00 00 09", "abort.code"),
    "filler": (
        "> 40 01 20 00 00 00 00 00 \n < 4F 01 20 00 01 00 00 FF",
        "response.filler",
    ),
}


@pytest.mark.parametrize("name", ALLOWED)
def test_allowed(name: str) -> None:
    assert judged(ALLOWED[name]) == []


@pytest.mark.parametrize("name", NOT_ALLOWED)
def test_not_allowed(name: str) -> None:
    exchange, rule = NOT_ALLOWED[name]
    assert [violation.rule.id for violation in judged(exchange)] == [rule]


def test_a_refusal_of_what_may_exist_is_not_about_what_is_missing() -> None:
    refused = "> 40 00 30 00 00 00 00 00 \n < 80 00 30 00 00 00 03 05"
    assert [found.rule.id for found in judged(refused, Oracle())] == ["response.not-refused"]


def test_awaited_follows_what_is_due() -> None:
    oracle = Oracle(KNOWN)
    awaited = [oracle.awaited]
    oracle.request(bytes.fromhex("4000100000000000"))
    awaited.append(oracle.awaited)
    assert oracle.response(bytes.fromhex("4300100091010F00")) == []
    awaited.append(oracle.awaited)
    oracle.request(bytes(8))
    awaited.append(oracle.awaited)
    assert awaited == [Awaited.NOTHING, Awaited.ANSWER, Awaited.NOTHING, Awaited.MAYBE]


def test_values_follow_downloads() -> None:
    oracle = Oracle(KNOWN)
    assert oracle.may_hold(mux("2000")) == frozenset({b"\1\2\3\4"})
    assert judged("> 23 00 20 00 05 06 07 08 \n < 60 00 20 00 00 00 00 00", oracle) == []
    assert oracle.may_hold(mux("2000")) == frozenset({b"\5\6\7\x08"})
    read_old = "> 40 00 20 00 00 00 00 00 \n < 43 00 20 00 01 02 03 04"
    assert [found.rule.id for found in judged(read_old, oracle)] == ["response.not-refused"]


def test_an_ambiguous_frame_leaves_two_values() -> None:
    oracle = Oracle(KNOWN)
    # Whether the short frame was served, only its confirmation would say.
    oracle.request(bytes.fromhex("2F0120000200"))
    assert oracle.may_hold(mux("2001")) == frozenset({b"\1", b"\2"})
    assert oracle.settled() == []
    assert oracle.may_hold(mux("2001")) == frozenset({b"\1"})


def test_a_time_out_may_be_reported_after_silence_only() -> None:
    timed_out = "< 80 10 20 00 00 00 04 05"
    assert [found.rule.id for found in judged(f"{DOWNLOAD} \n {timed_out}")]
    oracle = Oracle(KNOWN)
    judged(DOWNLOAD, oracle)
    assert oracle.silence() == []
    assert judged(timed_out, oracle) == []
    assert oracle.idle


def test_after_a_breach_the_next_transfer_is_judged_again() -> None:
    oracle = Oracle(KNOWN)
    assert judged(f"{READ} \n < 60 00 10 00 00 00 00 00", oracle)
    assert oracle.lost
    assert judged(f"{READ} \n < 43 00 10 00 91 01 0F 00", oracle) == []
    assert not oracle.lost
    assert judged(f"{READ} \n < 43 01 10 00 91 01 0F 00", oracle)


def test_the_profile_names_choices() -> None:
    oracle = Oracle(KNOWN)
    judged(ALLOWED["block-download.gap at once"], oracle)
    assert oracle.profile["acknowledges a gap"] == {"at once"}
    assert oracle.profile["block size of a download"] == {"4"}
    assert "acknowledges a gap: at once" in oracle.profile.lines()


def test_of_unknown_objects_only_the_protocol_is_judged() -> None:
    oracle = Oracle()
    assert oracle.may_hold(Multiplexer(0x2000)) is None
    assert judged("> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 00 00 02 06", oracle) == []
    assert judged("> 40 FF 1F 00 00 00 00 00 \n < 43 FF 1F 00 00 00 00 00", oracle) == []
    assert judged("> 40 FF 1F 00 00 00 00 00 \n < 80 FF 1F 00 00 00 03 05", oracle)
