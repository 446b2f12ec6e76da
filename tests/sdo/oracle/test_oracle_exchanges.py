"""What the oracle says of single exchanges, by the rule that each is about.

An exchange that is not allowed stands with the id of the rule that it breaks.
"""

import pytest
from oracle_notation import (
    BLOCK_DOWNLOAD,
    BLOCK_RECEIVED,
    BLOCK_SENT,
    BLOCK_UPLOAD,
    DOWNLOAD,
    KNOWN,
    READ,
    UPLOAD,
    judged,
)

from conformance.sdo.oracle import Oracle

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
    "block-upload.early-acknowledgement starts over": (
        f"{BLOCK_UPLOAD} \n > A3 00 00 00 00 00 00 00 \n > A2 00 02 00 00 00 00 00 \n "
        "< 01 54 69 6E 79 20 4E 6F \n < 01 54 69 6E 79 20 4E 6F \n < 82 64 65 00 00 00 00 00"
    ),
    "block-upload.client-abort inside, a segment on its way": (
        f"{BLOCK_UPLOAD} \n > A3 00 00 00 00 00 00 00 \n > 80 08 10 00 00 00 00 08 \n {READ} \n "
        "< 01 54 69 6E 79 20 4E 6F \n < 82 64 65 00 00 00 00 00 \n < 43 00 10 00 91 01 0F 00"
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
SENT_LOSSY = (
    f"{BLOCK_DOWNLOAD} \n > 01 30 31 32 33 34 35 36 \n > 82 37 38 39 3A 3B 3C 3D \n "
    "< A2 {} 04 00 00 00 00 00"
)
NOT_ALLOWED = {
    "a segment lost, and taken when it is sent again": (
        SENT_LOSSY.format("01") + " \n > 81 37 38 39 3A 3B 3C 3D \n < A2 01 04 00 00 00 00 00 \n "
        "> C1 D2 A8 00 00 00 00 00 \n < A1 00 00 00 00 00 00 00",
        "block-download.whole-sub-block",
    ),
    "nothing taken of a sub-block": (SENT_LOSSY.format("00"), "block-download.whole-sub-block"),
    "a loss shown at once": (
        f"{BLOCK_DOWNLOAD} \n > 01 30 31 32 33 34 35 36 \n > 02 30 31 32 33 34 35 36 \n "
        "> 03 30 31 32 33 34 35 36 \n < A2 01 04 00 00 00 00 00",
        "block-download.whole-sub-block",
    ),
    "more acknowledged than came in sequence": (
        f"{BLOCK_DOWNLOAD} \n > 01 30 31 32 33 34 35 36 \n > 83 37 38 39 3A 3B 3C 3D \n "
        "< A2 03 04 00 00 00 00 00",
        "block.acknowledgement",
    ),
    "numbers that go on behind a loss": (
        f"{BLOCK_RECEIVED} \n > A2 01 02 00 00 00 00 00 \n < 82 64 65 00 00 00 00 00",
        "block-upload.retransmission-numbering",
    ),
    "the end of a block download confirmed again": (
        f"{BLOCK_SENT} \n > C1 D2 A8 00 00 00 00 00 \n < A1 00 00 00 00 00 00 00 \n "
        "> C1 D2 A8 00 00 00 00 00 \n < A1 00 00 00 00 00 00 00",
        "specifier.out-of-block",
    ),
    "a start behind an abort served": (
        f"{BLOCK_UPLOAD} \n > 80 08 10 00 00 00 00 08 \n > A3 00 00 00 00 00 00 00 \n "
        "< 01 54 69 6E 79 20 4E 6F",
        "specifier.out-of-block",
    ),
    "segments behind the answer that follows an abort": (
        f"{BLOCK_UPLOAD} \n > A3 00 00 00 00 00 00 00 \n > 80 08 10 00 00 00 00 08 \n {READ} \n "
        "< 01 54 69 6E 79 20 4E 6F \n < 43 00 10 00 91 01 0F 00 \n < 82 64 65 00 00 00 00 00",
        "response.unsolicited",
    ),
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
        "response.specifier",
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


READING = "> 40 00 30 00 00 00 00 00"
WRITING = "> 23 00 30 00 01 02 03 04"


@pytest.mark.parametrize("request_", [READING, WRITING])
@pytest.mark.parametrize(
    ("code", "of"),
    [
        ("01 00 01 06", READING),
        ("02 00 01 06", WRITING),
        ("41 00 04 06", WRITING),
        ("42 00 04 06", WRITING),
        ("30 00 09 06", WRITING),
        ("31 00 09 06", WRITING),
        ("32 00 09 06", WRITING),
        ("00 00 02 06", None),
        ("22 00 00 08", None),
    ],
)
def test_an_object_of_which_nothing_is_known_is_refused_by_a_code_of_the_service(
    request_: str, code: str, of: str | None
) -> None:
    found = judged(f"{request_} \n < 80 00 30 00 {code}", Oracle())
    other = of not in (None, request_)
    assert [violation.rule.id for violation in found] == ["abort.other-service"] * other


@pytest.mark.parametrize(
    ("begun", "request_", "accusations"),
    [
        (UPLOAD, "> 60 00 00 00 00 00 00 00", ["00 00 03 05", "01 00 04 05", "30 00 09 06"]),
        (DOWNLOAD, "> 00 41 42 43 44 45 46 47", ["00 00 03 05", "02 00 04 05", "01 00 01 06"]),
        (BLOCK_UPLOAD, "> A3 00 00 00 00 00 00 00", ["02 00 04 05", "03 00 04 05"]),
    ],
)
def test_an_abort_that_accuses_a_right_client_is_no_end_of_its_own(
    begun: str, request_: str, accusations: list[str]
) -> None:
    object_ = begun.split()[2:5]
    for code, is_its_own in [*((code, False) for code in accusations), ("22 00 00 08", True)]:
        oracle = Oracle(KNOWN)
        abort = f"< 80 {' '.join(object_)} {code}"
        for line in (*begun.splitlines(), request_):
            frame = bytes.fromhex(line.strip()[1:])
            oracle.response(frame) if "<" in line else oracle.request(frame)
        found = oracle.response(bytes.fromhex(abort[1:]))
        assert len(found) == 1
        assert (oracle.ended is not None) == is_its_own, code
