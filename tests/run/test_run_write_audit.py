"""Nothing is written but what the user named, and every value is put back: in a whole run."""

import pytest
from run_audit import WRITABLE, asked_to_write, node_like, run, server_like

from conformance.device.safety import IDENTITY
from conformance.run.matrix.states import STATES
from conformance.running import ExitCode
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access

pytest_plugins = ["pytester"]

NAME = Multiplexer(0x1008)
TEXT = Multiplexer(0x2010)
# Of the matrix two states, where most of its frames can be taken for a download.
ONCE = "not test_matrix or matrix.idle or matrix.block-download-between"
# Of the other states each frame with a specifier of downloads, or that a sub-block takes.
WRITING = " or ".join(f"[{begin}" for begin in ("0", "1", "2", "3", "C", "D", "segment"))


def test_a_whole_run(pytester: pytest.Pytester) -> None:
    server = server_like(None)
    begin = server.values()
    result = run(pytester, server, node_like(None, server), "-k", f"{ONCE} or {WRITING}", "-vv")
    assert result.ret == pytest.ExitCode.OK
    states = {state for state in STATES if f"::matrix.{state}[" in result.stdout.str()}
    assert states == set(STATES)
    assert {mux for mux, _ in server.writes} == WRITABLE
    probed = asked_to_write(server) - WRITABLE
    assert probed
    assert {mux.index for mux in probed} <= set(IDENTITY), "the identity is read-only"
    assert server.values() == begin


UNUSUAL = (
    "short-frames-served",
    "text-ends-in-zero",
    "strings-of-20-bytes",
)
# What these have to show needs of the matrix only where many frames are sent without an answer, and
# no transfers of 600 frames and more.
SHORT = (
    "(not test_matrix or block-download-between) "
    "and not 409 and not 177 and not 88 and not 89 and not wraps"
)


@pytest.mark.parametrize("name", UNUSUAL)
def test_a_whole_run_on_an_unusual_device(pytester: pytest.Pytester, name: str) -> None:
    server = server_like(name)
    begin = server.values()
    assert run(pytester, server, node_like(name, server), "-k", SHORT).ret == pytest.ExitCode.OK
    assert {mux for mux, _ in server.writes} <= WRITABLE
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= set(IDENTITY)
    if name == "text-ends-in-zero":
        server.entries[TEXT].value = server.entries[TEXT].value.rstrip(b"\0")
    assert server.values() == begin


CARELESS = {
    "short-request-padded": "frame.short",
    "short-frames-served": "frame.short",
    "answers-extended": "frame.extended",
    "read-only-written-expedited": "download.read-only",
    "read-only-written-segmented": "segmented-download.read-only",
    "abort-commits-download": "segmented-download.client-abort",
    "download-too-few-refused-and-stored": "segmented-download.too-few",
    "new-download-commits-old": "segmented-download.new",
}


@pytest.mark.parametrize(("name", "chosen"), CARELESS.items(), ids=CARELESS)
def test_a_device_that_writes_what_it_should_not(
    pytester: pytest.Pytester, name: str, chosen: str
) -> None:
    """Its values are put back all the same, and no other object is touched."""
    server = server_like(name)
    begin = server.values()
    status = run(pytester, server, node_like(name, server), "-k", chosen).ret
    assert status in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= set(IDENTITY)
    assert server.values() == begin


SENSELESS = (
    "upload-multiplexer-missing",
    "abort-answered-when-idle",
    "upload-n-is-count",
    "upload-always-four-bytes",
)


@pytest.mark.parametrize("name", SENSELESS)
def test_a_device_that_makes_no_sense(pytester: pytest.Pytester, name: str) -> None:
    """Cases fail one after another; what they wrote is put back, as the type of the object is.

    A value that reads too long for its type is either cut or never written.
    """
    server = server_like(name)
    begin = server.values()
    chosen = ("--response-timeout=0.1", "-k", "abort. or test_expedited_download or frame.short")
    status = run(pytester, server, node_like(name, server), *chosen).ret
    assert status in (pytest.ExitCode.TESTS_FAILED, ExitCode.DEVICE_LOST)
    assert server.values() == begin


def test_without_leave_no_value_is_changed(pytester: pytest.Pytester) -> None:
    """What a device has to refuse is tried with the value that it has, in case it does not."""
    server = server_like(None)
    server.entries[NAME].access = Access.RW  # unusual, and not forbidden
    begin = server.values()
    status = run(pytester, server, node_like(None, server), "-k", ONCE, named=()).ret
    assert status == pytest.ExitCode.TESTS_FAILED
    assert {mux.index for mux in asked_to_write(server)} <= set(IDENTITY)
    assert [(mux, value) for mux, value in server.writes if value != begin[mux]] == []


def test_without_leave_a_device_that_is_right_passes(pytester: pytest.Pytester) -> None:
    server = server_like(None)
    right = node_like(None, server)
    assert run(pytester, server, right, "-k", ONCE, named=()).ret == pytest.ExitCode.OK
    assert server.writes == []
