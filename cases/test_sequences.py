"""Transfers one after another: nothing of one shows in the next (CiA 301, 7.2.4.2)."""

from conformance.device.device import IDENTITY_COUNT, VENDOR_ID, Device
from conformance.device.effort import SHORT_VALUE
from conformance.device.known_objects import KnownObject
from conformance.device.not_testable import NotTestable
from conformance.dialogue.changing import changes_by_itself
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.missing_objects import missing_object
from conformance.run.case import may, must
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.frames import Abort, UploadInitiate
from conformance.sdo.objects import DataType
from conformance.sdo.rules import MISSING_REFUSED
from conformance.sdo.seen import said

# Kind, size: expedited, segmented with the size indicated, segmented without.
KINDS = {
    "expedited-4": (False, True, 4),
    "expedited-2": (False, True, 2),
    "sized-20": (True, True, 20),
    "sized-7": (True, True, 7),
    "unsized-21": (True, False, 21),
    "unsized-3": (True, False, 3),
}
PAIRS = {
    f"{first}-then-{second}": (KINDS[first], KINDS[second]) for first in KINDS for second in KINDS
}
Kind = tuple[bool, bool, int]


def fitting(room: Room, known: KnownObject, kinds: tuple[Kind, ...]) -> list[Kind]:
    """Return kinds of downloads with sizes that the object takes: asked before any of them."""
    return [
        (segmented, sized, room.fit(known, size) if segmented else size)
        for segmented, sized, size in kinds
    ]


@must("sequence.downloads", "server.idle-afterwards", pair=PAIRS)
def test_downloads(
    sdo: Dialogue, room: Room, variable: KnownObject, pair: tuple[Kind, Kind]
) -> None:
    """One download after another to the same object: it holds the second and nothing else."""
    for segmented, sized, size in fitting(room, variable, pair):
        data = sdo.payload(size)
        room.store(variable, data, segmented=segmented, sized=sized, exactly=True)
        sdo.expect_value(variable, data)


@must("sequence.downloads-unread", "server.idle-afterwards", pair=PAIRS)
def test_downloads_unread(
    sdo: Dialogue, room: Room, variable: KnownObject, pair: tuple[Kind, Kind]
) -> None:
    """Two downloads without a read between them: the object holds the second."""
    data = b""
    for segmented, sized, size in fitting(room, variable, pair):
        data = sdo.payload(size)
        room.store(variable, data, segmented=segmented, sized=sized, exactly=True)
    sdo.expect_value(variable, data)


@must("sequence.uploads", "server.idle-afterwards", "object.constant")
def test_uploads(sdo: Dialogue, device: Device) -> None:
    """Uploads of known objects in turn, long and short: each reads as at the beginning."""
    steady = device.briefly_read()
    due = {mux: sdo.upload(mux) for mux in sdo.device.permits.effort.sampled(steady)}
    for mux in list(reversed(due)):
        again = (mux, mux) if len(due[mux]) <= SHORT_VALUE else (mux,)
        for other in (IDENTITY_COUNT, *again):
            found = sdo.upload(other)
            if found != due.setdefault(other, found) and not changes_by_itself(sdo, other):
                raise sdo.breach(f"{other} reads {due[other].hex(' ')}", said("{}", found.hex(" ")))


@must("sequence.upload-then-download", "server.idle-afterwards", size=[3, 7, 20])
def test_upload_then_download(sdo: Dialogue, room: Room, variable: KnownObject, size: int) -> None:
    """A download right after an upload of the same object stores its own bytes."""
    data = sdo.payload(room.fit(variable, size))
    room.prepare(variable, 17)
    sdo.upload(variable)
    room.store(variable, data)
    sdo.expect_value(variable, data)


@must(
    "sequence.abandoned-download",
    "server.nothing-afterwards",
    sized={"sized": True, "unsized": False},
)
def test_abandoned_download(sdo: Dialogue, room: Room, text: KnownObject, sized: bool) -> None:
    """Segments of a download that was aborted do not turn up in the next one."""
    data = sdo.payload(room.fit(text, 9))
    size = len(room.prepare(text, 21, least=8))
    sdo.initiate_download(text, size if sized else None)
    for number in range(min(2, (size - 1) // 7)):
        sdo.download_segment(sdo.payload(7), toggle=number)
    sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
    room.store(text, data, segmented=True, sized=sized, exactly=True)
    sdo.expect_value(text, data)


@must("sequence.abandoned-upload", "server.nothing-afterwards", "segmented-upload.client-abort")
def test_abandoned_upload(sdo: Dialogue, room: Room) -> None:
    """An upload that was aborted starts again from the first byte."""
    known, data = room.long_object()
    sdo.start_segmented_upload(known)
    sdo.upload_segment(toggle=0)
    sdo.upload_segment(toggle=1)
    sdo.send(Abort(known.mux, AbortCode.TIMED_OUT))
    sdo.expect_value(known, data)


@must("sequence.sized-aborted-then-unsized", "server.nothing-afterwards")
def test_sized_aborted_then_unsized(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """The size of a download that was aborted is not held against the next one."""
    shorter = room.fit(text, 5)
    data = sdo.payload(len(room.prepare(text, 20)))
    if shorter == len(data):
        raise NotTestable(f"{text} takes values of {shorter} bytes only: name one that takes more")
    sdo.initiate_download(text, shorter)
    sdo.send(Abort(text.mux, AbortCode.TIMED_OUT))
    room.store(text, data, segmented=True, sized=False, exactly=True)
    sdo.expect_value(text, data)


@must("sequence.refused-then-served", "server.nothing-afterwards")
def test_refused_then_served(sdo: Dialogue, room: Room, text: KnownObject) -> None:
    """A refused request leaves no trace in the transfer that follows."""
    missing = missing_object(sdo)
    data = room.prepare(text, 16)
    sdo.send(UploadInitiate(missing))
    sdo.expect_abort(*MISSING_REFUSED.codes, of=missing)
    sdo.expect_value(text, data)
    sdo.upload(VENDOR_ID)


@may("sequence.aborted-domain", "server.partial-domain")
def test_aborted_domain(sdo: Dialogue, room: Room, variable: KnownObject) -> None:
    """Whatever an aborted download leaves in a domain can be read, and the next one replaces it.

    That it has left anything is a breach of a SHOULD, as of a string.
    """
    before = room.prepare(variable, 21, least=8)
    sdo.initiate_download(variable, len(before))
    sdo.download_segment(sdo.payload(7), toggle=0)
    sdo.send(Abort(variable.mux, AbortCode.GENERAL_ERROR))
    if variable.data_type is DataType.DOMAIN:
        sdo.expect_kept(variable, before)
    else:
        sdo.upload(variable)
    data = sdo.payload(len(before))
    room.store(variable, data)
    sdo.expect_value(variable, data)
