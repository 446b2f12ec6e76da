"""Nothing is written but what the user named, and every value is put back: in a whole run."""

import pytest
from run_audit import ALSO_WRITABLE, WRITABLE, asked_to_write, node_like, run, server_like
from support.run_bench import NODE_ID, Recording

from conformance.device.safety import IDENTITY
from conformance.model_cases.server_states import STATES
from conformance.plugin.exit_code import ExitCode
from conformance.reference.built_in_device import reference_entries
from conformance.reference.node import Node
from conformance.reference.server import BlockDownload, Server
from conformance.sdo.abort_codes import AbortCode
from conformance.sdo.can_frame import CanFrame
from conformance.sdo.cob_id import REQUEST_BASE
from conformance.sdo.decoding import decode_request
from conformance.sdo.frames import BlockDownloadInitiate, BlockSegment, DownloadInitiate
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Access, Refusal

pytest_plugins = ["pytester"]

NAME = Multiplexer(0x1008)
PROBES = "--sdo-allow=read-only-probes"
# What is read-only by the standard, and there without an EDS.
PROBED = {*IDENTITY, 0x1001}
TEXT = Multiplexer(0x2010)
DOMAIN = Multiplexer(0x2011)
# Of the matrix two states, where most of its frames can be taken for a download.
ONCE = "not test_matrix or matrix.idle or matrix.block-download-between"
# Of the other states each frame that may begin or end a download, or that a sub-block takes.
WRITING = " or ".join(f"[{begin}" for begin in ("2", "3", "C", "D", "segment"))
# Transfers of 600 frames and more show no more than shorter ones.
LONG = ("409", "177", "88", "89", "beyond")
NOT_LONG = " and ".join(f"not {word}" for word in LONG)


def test_a_whole_run(pytester: pytest.Pytester) -> None:
    server = server_like(None)
    begin = server.values()
    chosen = f"({ONCE} or {WRITING}) and {NOT_LONG}"
    result = run(pytester, server, node_like(None, server), "-k", chosen, "-vv", PROBES)
    assert result.ret == pytest.ExitCode.OK
    states = {state for state in STATES if f"::matrix.{state}[" in result.stdout.str()}
    assert states == set(STATES)
    assert {mux for mux, _ in server.writes} == WRITABLE
    probed = asked_to_write(server) - WRITABLE
    assert probed
    assert {mux.index for mux in probed} <= PROBED, "these are read-only"
    assert server.values() == begin


UNUSUAL = (
    "short-frames-served",
    "text-ends-in-zero",
    "strings-of-20-bytes",
)
# What these have to show needs of the matrix only where many frames are sent without an answer, and
# nothing beyond downloads. What random conversations do to values shows on the reference server.
BEYOND_DOWNLOADS = (
    "test_random",
    "upload",
    "od.",
    "nmt.",
    "channel",
    "communication",
    "independence",
    "storage",
    "vanished",
)
SHORT = f"(not test_matrix or block-download-between) and {NOT_LONG} and " + " and ".join(
    f"not {word}" for word in BEYOND_DOWNLOADS
)


@pytest.mark.parametrize("name", UNUSUAL)
def test_a_whole_run_on_an_unusual_device(pytester: pytest.Pytester, name: str) -> None:
    server = server_like(name)
    begin = server.values()
    assert (
        run(pytester, server, node_like(name, server), "-k", SHORT, PROBES).ret
        == pytest.ExitCode.OK
    )
    assert {mux for mux, _ in server.writes} <= WRITABLE
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= PROBED
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
    status = run(pytester, server, node_like(name, server), "-k", chosen, PROBES).ret
    assert status in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    assert {mux.index for mux in asked_to_write(server) - WRITABLE} <= PROBED
    assert server.values() == begin


class AbortsInside(Server):
    """Aborts each block download inside its first sub-block, and is idle from then on.

    Its abort, and what it answers to the segments that it takes for requests, is late: many more
    are on their way.
    """

    at = 20
    late = 1
    held_back: list[bytes] = []  # noqa: RUF012
    still = 0

    def take_block_segment(self, transfer: BlockDownload, request: BlockSegment) -> None:
        """Give up, but not at once."""
        if request.sequence == self.at:
            self.still = self.late
            raise Refusal(AbortCode.LOCAL_CONTROL)
        super().take_block_segment(transfer, request)

    def receive(self, frame: bytes) -> list[bytes]:
        """Answer late what came behind."""
        answers = self.held_back + super().receive(frame)
        self.still -= 1
        self.held_back = answers if self.still > 0 else []
        return [] if self.still > 0 else answers


# Values of 64 segments and more, which the abort crosses, and all others.
IN_MID_BURST = {
    1: "test_block_download or random.block or random.any-frames",
    40: "block-download.size[448] or block-download.size[672] or block-download.size[1777]",
}


@pytest.mark.parametrize(("late", "chosen"), IN_MID_BURST.items(), ids=str)
def test_a_device_that_aborts_in_mid_burst(
    pytester: pytest.Pytester, late: int, chosen: str
) -> None:
    """What is on its way then are requests to it: none writes what was not named."""
    audited: type[Recording] = type("Audited", (Recording, AbortsInside), {"late": late})
    server = audited(reference_entries(NODE_ID) | ALSO_WRITABLE)
    begin = server.values()
    status = run(
        pytester,
        server,
        Node(NODE_ID, server),
        *("--sdo-response-timeout=0.2", "--sdo-object=2011=domain", PROBES, "-k", chosen),
    ).ret
    assert status == pytest.ExitCode.TESTS_FAILED
    taken = [frame for frame in server.requests if frame[:2] in (b"\x22\x7e", b"\x22\x7c")]
    assert taken or late == 1, "segments have reached it that look like initiates"
    elsewhere = asked_to_write(server) - WRITABLE - {DOMAIN}
    assert {mux.index for mux in elsewhere} <= PROBED
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
    chosen = (
        "--sdo-response-timeout=0.1",
        "-k",
        "abort. or test_expedited_download or frame.short",
    )
    status = run(pytester, server, node_like(name, server), *chosen).ret
    assert status in (pytest.ExitCode.TESTS_FAILED, ExitCode.DEVICE_LOST)
    assert server.values() == begin


def test_without_leave_no_value_is_changed(pytester: pytest.Pytester) -> None:
    """What a device has to refuse is tried with the value that it has, in case it does not."""
    server = server_like(None)
    server.entries[NAME].access = Access.RW  # unusual, and not forbidden
    begin = server.values()
    node = node_like(None, server)
    status = run(pytester, server, node, PROBES, "-k", ONCE, named=()).ret
    assert status == pytest.ExitCode.TESTS_FAILED
    assert {mux.index for mux in asked_to_write(server)} <= PROBED
    assert [(mux, value) for mux, value in server.writes if value != begin[mux]] == []


def test_without_leave_a_device_that_is_right_passes(pytester: pytest.Pytester) -> None:
    """No download is begun at all, and no other node is asked anything."""
    server = server_like(None)
    right = Overhearing(server)
    result = run(
        pytester, server, right, "-vv", "-k", f"({ONCE} or test_random) and not beyond", named=()
    )
    assert result.ret == pytest.ExitCode.OK
    lacking = ["*--sdo-allow=read-only-probes*", "*--sdo-allow=other-nodes*"]
    result.stdout.fnmatch_lines_random(lacking)
    assert server.writes == []
    downloads = (DownloadInitiate, BlockDownloadInitiate)
    begun = [decode_request(frame.ljust(8, b"\0")) for frame in server.requests]
    assert [request for request in begun if isinstance(request, downloads)] == []
    assert right.others == []


def test_other_nodes_are_asked_with_permission(pytester: pytest.Pytester) -> None:
    server = server_like(None)
    right = Overhearing(server)
    chosen = ("--sdo-allow=other-nodes", "-k", "frame.other-node")
    assert run(pytester, server, right, *chosen, named=()).ret == pytest.ExitCode.OK
    assert right.others


class Overhearing(Node):
    """Keeps the requests to other nodes."""

    def __init__(self, server: Recording) -> None:
        super().__init__(NODE_ID, server)
        self.others: list[CanFrame] = []

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        asks = frame.can_id & ~0x7F == REQUEST_BASE and not frame.extended
        if asks and frame.can_id != REQUEST_BASE + NODE_ID:
            self.others.append(frame)
        return super().receive(frame)
