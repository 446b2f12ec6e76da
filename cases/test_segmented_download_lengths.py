"""Downloads in segments with a wrong length, indicated or not (CiA 301, 7.2.4.3.3 and .4)."""

from conformance.device.device import VENDOR_ID
from conformance.device.known_objects import KnownObject
from conformance.device.object_roles import Roles
from conformance.dialogue.dialogue import Dialogue
from conformance.dialogue.lengths_by_writing import Room
from conformance.dialogue.wrong_lengths import refusing
from conformance.run.case import may, must
from conformance.sdo.frames import Abort, DownloadInitiate
from conformance.sdo.rules.download_initiates import (
    NUMBER_EMPTY,
    NUMBER_TOO_LONG,
    NUMBER_TOO_SHORT,
)
from conformance.sdo.rules.segmented_download import TOO_FEW, TOO_MANY


@must(
    "segmented-download.too-many",
    "download.size-error-moment",
    lengths={"7-7-1": (7, 7, 1), "7-6": (7, 6)},
)
def test_too_many(sdo: Dialogue, room: Room, text: KnownObject, lengths: tuple[int, ...]) -> None:
    """More bytes than announced are refused, at the latest with the last, and nothing is stored."""
    announced = room.fit(text, 8)
    room.prepare(text, sum(lengths))
    sent = announced + sum(lengths) - 8
    if sent % 7 == 0:
        sent += 1  # a full last segment has n = 0, which may mean that nothing is stated
    with sdo.unchanged(text):
        data = sdo.payload(sent)
        sdo.expect_download_refused(text, data, *TOO_MANY.codes, size=announced)


@must(
    "segmented-download.too-few",
    "download.size-error-moment",
    sizes={"10-of-14": (10, 14), "7-of-8": (7, 8)},
)
def test_too_few(sdo: Dialogue, room: Room, text: KnownObject, sizes: tuple[int, int]) -> None:
    """Fewer bytes than announced are refused, and nothing is stored."""
    sent, wanted = sizes
    announced = len(room.prepare(text, wanted, least=2))
    with sdo.unchanged(text):
        data = sdo.payload(max(announced - wanted + sent, 1))
        sdo.expect_download_refused(text, data, *TOO_FEW.codes, size=announced)


@must("segmented-download.number-too-long", "abort.length-code", length=[1, 2, 4, 5, 6, 7, 8])
def test_number_too_long(sdo: Dialogue, roles: Roles, length: int) -> None:
    """A size that is too large for a number is refused, at the latest with the last segment."""
    known = roles.number(length)
    with refusing(sdo, known) as other:
        data = other.longer(length + 1)
        sdo.expect_download_refused(known, data, *NUMBER_TOO_LONG.codes, size=length + 1)


@must(
    "segmented-download.number-too-long-not-indicated",
    "segmented-download.number-too-long",
    "abort.length-code",
    length=[1, 2, 4, 5, 6, 7, 8],
)
def test_number_too_long_not_indicated(sdo: Dialogue, roles: Roles, length: int) -> None:
    """More bytes than a number has are refused though no size was indicated."""
    known = roles.number(length)
    with refusing(sdo, known) as other:
        data = other.longer(length + 1)
        sdo.expect_download_refused(known, data, *NUMBER_TOO_LONG.codes, size=None)


@must("segmented-download.number-too-short", "abort.length-code", length=[2, 4, 5, 6, 7, 8])
def test_number_too_short(sdo: Dialogue, roles: Roles, length: int) -> None:
    """A size that is too small for a number is refused, at the latest with the last segment."""
    known = roles.number(length)
    with refusing(sdo, known) as other:
        data = other.shorter(length - 1)
        sdo.expect_download_refused(known, data, *NUMBER_TOO_SHORT.codes, size=length - 1)


@must(
    "segmented-download.number-too-short-not-indicated",
    "segmented-download.number-too-short",
    "abort.length-code",
    length=[2, 4, 5, 6, 7, 8],
)
def test_number_too_short_not_indicated(sdo: Dialogue, roles: Roles, length: int) -> None:
    """Fewer bytes than a number has are refused though no size was indicated."""
    known = roles.number(length)
    with refusing(sdo, known) as other:
        data = other.shorter(length - 1)
        sdo.expect_download_refused(known, data, *NUMBER_TOO_SHORT.codes, size=None)


@must("segmented-download.number-empty", "abort.length-code", length=[1, 4])
def test_number_empty(sdo: Dialogue, roles: Roles, length: int) -> None:
    """No number has 0 bytes."""
    known = roles.number(length)
    with sdo.unchanged(known):
        sdo.expect_download_refused(known, b"", *NUMBER_EMPTY.codes, size=0)


@may("segmented-download.huge-size", "download.huge-size", size=[0xFFFFFFFF, 0x80000000])
def test_huge_size(sdo: Dialogue, variable: KnownObject, size: int) -> None:
    """A size beyond any memory is accepted for the time being, or refused; the server lives on."""
    sdo.send(DownloadInitiate.with_size(variable.mux, size))
    answer = sdo.receive()
    if isinstance(answer, Abort):
        sdo.checks.abort(answer, variable.mux)
    else:
        sdo.checks.download_initiate(answer, variable.mux)
    sdo.end_transfer()
    sdo.upload(VENDOR_ID)
