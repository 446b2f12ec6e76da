"""What goes wrong in the middle of a segmented download (CiA 301, 7.2.4.3.4 and 7.2.4.3.17)."""

from collections.abc import Callable
from dataclasses import replace

from conformance.device.device import (
    IDENTITY_COUNT,
    THREE_SEGMENTS,
    TWO_SEGMENTS,
    VENDOR_ID,
)
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.model_cases.server_states import (
    SEGMENTED_DOWNLOAD_FIRST,
    SEGMENTED_DOWNLOAD_LAST,
    SEGMENTED_DOWNLOAD_MIDDLE,
    SEGMENTED_DOWNLOADS,
    State,
    by_name,
)
from conformance.model_cases.variations import FOREIGN_IN_DOWNLOAD
from conformance.run.case import may, must
from conformance.run.risks import risk_of_request
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import (
    Abort,
    DownloadInitiate,
    DownloadSegment,
    UploadInitiate,
)
from conformance.sdo.layout import Multiplexer
from conformance.sdo.rules import accepted
from conformance.sdo.rules.freedoms import FOREIGN_MULTIPLEXER
from conformance.sdo.rules.segmented_download import ABORT_RESERVED_BITS, TOGGLE
from conformance.sdo.seen import Received, other_data

SIZE = 21
IGNORED = "a segment with the wrong toggle bit gets no answer, and the download goes on"


def stored(room: Room, text: KnownObject, least: int) -> int:
    """Store a value of three full segments, or of as many bytes as there is room for."""
    return len(room.prepare(text, SIZE, least))


def is_refused_alone(
    sdo: Dialogue, text: KnownObject, state: State[DownloadSegment], size: int
) -> bool:
    """Send a segment with the wrong toggle bit and wait: say whether it is refused as that.

    Where another one follows at once, a server with one place for an answer tells of that only.
    """
    due = state.reach(sdo, text, size)
    sdo.send(DownloadSegment.with_data(b"#######", toggle=1 - due.toggle))
    answer = sdo.wait(sdo.wire.waits.soon)
    if not isinstance(answer, Abort) or answer.code not in TOGGLE.codes:
        return False
    sdo.checks.abort(answer, text.mux)
    return True


@must("segmented-download.toggle", state=SEGMENTED_DOWNLOADS)
def test_toggle(
    sdo: Dialogue, room: Room, text: KnownObject, state: State[DownloadSegment]
) -> None:
    """A segment whose toggle bit did not alternate is refused or ignored, and never stored.

    The right segment follows at once, so that a server that ignored the wrong one shows it.
    """
    size = stored(room, text, state.least)
    with sdo.unchanged(text):
        due = state.reach(sdo, text, size)
        right = due.toggle
        sdo.send(DownloadSegment.with_data(b"#######", toggle=1 - right))
        sdo.send(replace(due, last=False))
        answer = sdo.receive()
        if isinstance(answer, Abort):
            if answer.code not in TOGGLE.codes:
                sdo.expect_over()
                if not is_refused_alone(sdo, text, state, size):
                    raise sdo.breach("abort 05030000h, or no answer", Received(answer))
                return
            sdo.checks.abort(answer, text.mux)
            sdo.expect_over()
            return
        expected = f"no answer to the wrong segment, {0x20 | right << 4:02X}h to the right one"
        if answer.encode()[0] & 0x10 != right << 4:
            raise sdo.breach(expected, Received(answer))
        sdo.checks.download_segment(answer, text.mux, right)
        sdo.info(IGNORED)
    sdo.expect_nothing()


@must("segmented-download.number-toggle", "segmented-download.toggle")
def test_number_toggle(sdo: Dialogue, number: KnownObject) -> None:
    """A number in one segment, whose toggle bit is 1, is refused or ignored, and never stored."""
    with sdo.unchanged(number) as value:
        sdo.initiate_download(number, len(value))
        other = bytes([value[0] ^ 1]) + value[1:]
        sdo.send(DownloadSegment.with_data(other, toggle=1, last=True))
        answer = sdo.reaction()
        if answer is None:
            sdo.info(IGNORED)
        elif isinstance(answer, Abort) and answer.code in TOGGLE.codes:
            sdo.checks.abort(answer, number.mux)
        else:
            raise sdo.breach("abort 05030000h, or no answer", Received(answer))


@must("segmented-download.toggle-ignored-data", "segmented-download.toggle")
def test_toggle_ignored_data(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """A server that ignores a repeated segment does not store it twice."""
    size = stored(room, text, THREE_SEGMENTS)
    data = sdo.payload(size)
    sdo.initiate_download(text, size)
    sdo.download_segment(data[:7], toggle=0)
    sdo.send(DownloadSegment.with_data(data[:7], toggle=0))
    sdo.send(DownloadSegment.with_data(data[7:14], toggle=1))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        # With another code it may be about the segment behind, and name no object.
        sdo.checks.abort(answer, text.mux if answer.code in TOGGLE.codes else None)
        sdo.expect_over()
        return
    if not answer.encode()[0] & 0x10:
        raise sdo.breach("no answer to the repeated segment", Received(answer))
    sdo.checks.download_segment(answer, text.mux, 1)
    sdo.info(IGNORED)
    sdo.download_segments(data, first=2)
    sdo.expect_value(text, data)


@must(
    "segmented-download.toggle-afterwards",
    "segmented-download.confirmed",
    "server.idle-afterwards",
    state=by_name(SEGMENTED_DOWNLOAD_MIDDLE, SEGMENTED_DOWNLOAD_LAST),
)
def test_toggle_afterwards(
    sdo: Dialogue, room: Room, text: KnownObject, state: State[DownloadSegment]
) -> None:
    """Wherever a transfer ended, the next one begins with t = 0."""
    size = stored(room, text, state.least)
    state.reach(sdo, text, size)
    sdo.send(Abort(text.mux, AbortCode.GENERAL_ERROR))
    sdo.initiate_download(text, size)
    sdo.download_segment(sdo.payload(7), toggle=0)


@must(
    "segmented-download.foreign",
    "segmented-download.upload-segment",
    "segmented-download.unknown-specifier",
    "segmented-download.block-frames",
    risk=risk_of_request,
    request=FOREIGN_IN_DOWNLOAD,
)
def test_foreign(sdo: Dialogue, room: Room, text: KnownObject, request: bytes) -> None:
    """A request of another service before the first segment ends the download with 05040001h."""
    _foreign(sdo, room, text, request, SEGMENTED_DOWNLOAD_FIRST)


@must(
    "segmented-download.foreign-later",
    "segmented-download.upload-segment",
    "segmented-download.unknown-specifier",
    "segmented-download.block-frames",
    risk=risk_of_request,
    request=FOREIGN_IN_DOWNLOAD,
)
def test_foreign_later(sdo: Dialogue, room: Room, text: KnownObject, request: bytes) -> None:
    """A request of another service between segments ends the download with 05040001h."""
    _foreign(sdo, room, text, request, SEGMENTED_DOWNLOAD_MIDDLE)


def _foreign(
    sdo: Dialogue, room: Room, text: KnownObject, request: bytes, state: State[DownloadSegment]
) -> None:
    size = stored(room, text, state.least)
    with sdo.unchanged(text):
        due = state.reach(sdo, text, size)
        sdo.send(request)
        sdo.expect_abort(*accepted.NOT_VALID, of=text)
        sdo.expect_dead(due)


@must(
    "segmented-download.restart",
    "segmented-download.new-initiate",
    "server.new-initiate-served",
    state=SEGMENTED_DOWNLOADS,
)
def test_restart(
    sdo: Dialogue, room: Room, text: KnownObject, state: State[DownloadSegment]
) -> None:
    """The same initiate again starts a new download, or is refused and ends the transfer."""
    data = sdo.payload(room.fit(text, 9))
    state.reach(sdo, text, stored(room, text, state.least))
    request = DownloadInitiate.with_size(text.mux, len(data))
    answer = sdo.expect_restart_or_abort(request, text, text)
    if answer is not None:
        with sdo.one_transfer():
            sdo.checks.download_initiate(answer, text.mux)
            sdo.download_segments(data)
            sdo.expect_value(text, data)


@must(
    "segmented-download.new-upload",
    "segmented-download.new-initiate",
    "server.new-initiate-served",
    state=SEGMENTED_DOWNLOADS,
)
def test_new_upload(
    sdo: Dialogue, room: Room, text: KnownObject, number: KnownObject, state: State[DownloadSegment]
) -> None:
    """An upload in mid-download is served with its data or refused; the download is over.

    The rest of the download must not end up in the object that was read, either.
    """
    due = sdo.upload(number)
    size = stored(room, text, state.least)
    with sdo.unchanged(text):
        rest = state.reach(sdo, text, size)
        answer = sdo.expect_restart_or_abort(UploadInitiate(number.mux), text, number)
        with sdo.one_transfer():
            if answer is not None:
                response = sdo.checks.upload_initiate(answer, number.mux)
                found = sdo.finish_upload(number, response)
                if found != due:
                    raise sdo.breach(
                        f"{number} reads {due.hex()}", other_data(f"it reads {found.hex()}")
                    )
            sdo.expect_dead(rest)
            sdo.expect_value(number, due)


@must(
    "segmented-download.new-download",
    "segmented-download.new-initiate",
    "server.new-initiate-served",
    state=SEGMENTED_DOWNLOADS,
)
def test_new_download(
    sdo: Dialogue, room: Room, text: KnownObject, number: KnownObject, state: State[DownloadSegment]
) -> None:
    """A download of another object in mid-download is served or refused; the old one is over."""
    value = sdo.upload(number)
    size = stored(room, text, state.least)
    with sdo.unchanged(text):
        state.reach(sdo, text, size)
        request = DownloadInitiate.with_size(number.mux, len(value))
        answer = sdo.expect_restart_or_abort(request, text, number)
        with sdo.one_transfer():
            if answer is not None:
                sdo.checks.download_initiate(answer, number.mux)
                sdo.download_segments(value)
            sdo.expect_value(number, value)


@must(
    "segmented-download.client-abort",
    "server.value-kept",
    "server.part-written",
    state=SEGMENTED_DOWNLOADS,
)
def test_client_abort(
    sdo: Dialogue, room: Room, text: KnownObject, state: State[DownloadSegment]
) -> None:
    """An abort of the client is not answered, ends the download, and nothing is stored."""
    size = stored(room, text, state.least)
    with sdo.unchanged(text):
        state.reach(sdo, text, size)
        sdo.send(Abort(text.mux, AbortCode.GENERAL_ERROR))
        sdo.expect_nothing()


@must(
    "segmented-download.client-abort-unsized",
    "segmented-download.client-abort",
    "server.value-kept",
    "server.part-written",
)
def test_client_abort_unsized(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """A download without a size that is aborted before its first segment leaves the value."""
    stored(room, text, 1)
    with sdo.unchanged(text):
        sdo.initiate_download(text)
        sdo.send(Abort(text.mux, AbortCode.GENERAL_ERROR))
        sdo.expect_nothing()


def _abort(sdo: Dialogue, known: KnownObject) -> None:
    del known  # it is the object of the transfer that runs
    sdo.end_transfer()


def _upload(sdo: Dialogue, known: KnownObject) -> None:
    del known
    sdo.attempt(sdo.client.upload(VENDOR_ID.mux))


def _download(sdo: Dialogue, known: KnownObject) -> None:
    roles = Roles(sdo.device)
    roles.two_writable()
    other = next(one.mux for one in roles.all_writable() if one.mux != known.mux)
    sdo.attempt(sdo.client.download(other, sdo.device.values[other]))


ENDINGS = {"client-abort": _abort, "new-upload": _upload, "new-download": _download}


@must("segmented-download.number-kept", "server.value-kept", ending=ENDINGS)
def test_number_kept(
    sdo: Dialogue, roles: Roles, ending: Callable[[Dialogue, KnownObject], None]
) -> None:
    """A number keeps its value where its download ends before the last segment."""
    known = roles.longest_number()
    with sdo.unchanged(known) as value:
        data = bytes(byte ^ 1 for byte in value)
        sdo.initiate_download(known, len(data))
        sdo.send(DownloadSegment.with_data(data[:7], toggle=0))
        answer = sdo.receive()
        if not isinstance(answer, Abort):
            sdo.checks.download_segment(answer, known.mux, 0)
            ending(sdo, known)


@must(
    "segmented-download.client-abort-then-segment",
    "segmented-download.client-abort",
    "time-out.client",
    "server.value-kept",
    state=SEGMENTED_DOWNLOADS,
)
def test_client_abort_then_segment(
    sdo: Dialogue, room: Room, text: KnownObject, state: State[DownloadSegment]
) -> None:
    """The segment that was due is not taken right behind an abort, and nothing is stored."""
    size = stored(room, text, state.least)
    with sdo.unchanged(text):
        rest = state.reach(sdo, text, size)
        sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
        sdo.expect_dead(rest)


@may(
    "segmented-download.foreign-abort",
    "abort.foreign-multiplexer",
    mux={"other-object": Multiplexer(0x1018, 1), "none": Multiplexer(0, 0)},
)
def test_foreign_abort(sdo: Dialogue, room: Room, text: KnownObject, mux: Multiplexer) -> None:
    """An abort of another object ends the download or is ignored; it is not answered.

    05040001h is accepted: a server may take it for a request that has no place there.
    """
    size = stored(room, text, TWO_SEGMENTS)
    with sdo.unchanged(text):
        SEGMENTED_DOWNLOAD_MIDDLE.reach(sdo, text, size)
        sdo.send(Abort(mux, AbortCode.GENERAL_ERROR))
        sdo.line.open = text.mux  # the server may have ignored it
        sdo.expect_silence_or_abort(*FOREIGN_MULTIPLEXER.codes)


@may("segmented-download.abort-reserved-bits", "request.reserved-bits", bits=[0x01, 0x10, 0x1F])
def test_abort_reserved_bits(sdo: Dialogue, room: Room, text: KnownObject, bits: int) -> None:
    """81h to 9Fh is an abort with reserved bits, or no valid request; never a segment."""
    size = stored(room, text, TWO_SEGMENTS)
    with sdo.unchanged(text):
        SEGMENTED_DOWNLOAD_MIDDLE.reach(sdo, text, size)
        sdo.send(Abort(text.mux, AbortCode.GENERAL_ERROR, bits))
        sdo.line.open = text.mux  # the server may have ignored it
        sdo.expect_silence_or_abort(*ABORT_RESERVED_BITS.codes)


@may("segmented-download.after-the-last", "request.out-of-transfer")
def test_after_the_last(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """After the last segment another one is refused or ignored, and changes nothing."""
    for toggle in (0, 1):
        data = room.prepare(text, SIZE)
        sdo.expect_dead(DownloadSegment.with_data(sdo.payload(7), toggle=toggle, last=True))
        sdo.expect_value(text, data)


@may(
    "segmented-download.without-initiate",
    "request.out-of-transfer",
    "abort.any-multiplexer",
    last={"middle": False, "last": True},
)
def test_without_initiate(sdo: Dialogue, last: bool) -> None:
    """A segment without a download is refused or ignored."""
    for toggle in (0, 1):
        for data in (b"ABCDEFG", b""):
            sdo.upload(IDENTITY_COUNT)
            sdo.expect_dead(DownloadSegment.with_data(data, toggle=toggle, last=last))
