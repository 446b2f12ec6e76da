"""The verdicts do not depend on what else goes on: foreign traffic, a slow device, a late one."""

import threading
from collections.abc import Iterator
from itertools import cycle

import pytest
from plugin_runs import NODE_ID, hosted, parsed, run

from conformance.faults.catalogue import build_node
from conformance.reference.host import HostedNode
from conformance.run.case_files import CASES
from conformance.sdo.can_frame import CanFrame

pytest_plugins = ["pytester"]

NODE = f"--node-id={NODE_ID}"
WRITABLE = (
    *(f"--sdo-object=200{length}=unsigned{8 * length}" for length in (1, 2, 3, 4, 8)),
    *(
        "--sdo-object=2010=visible_string",
        "--sdo-object=2011=domain",
        "--sdo-object=2020=unsigned32,wo",
    ),
)
OTHER = 9
# Transfers of many segments show nothing more here, and cost most of the time.
LARGE = ("409", "177", "88", "89", "672", "448", "490", "126", "127", "beyond")
GENERATED = [f"--ignore={CASES / name}.py" for name in ("test_matrix", "test_random")]
BEYOND = ("vanished", "sequence", "od.", "nmt.", "channel", "storage")
SHORT = " and ".join(f"not {word}" for word in (*BEYOND, *LARGE))
TRAFFIC = (
    CanFrame(0x080, b""),  # SYNC
    CanFrame(0x080 + NODE_ID, bytes.fromhex("0000010000000000")),  # EMCY, of the device as well
    CanFrame(0x080 + OTHER, bytes.fromhex("3081110000000000")),
    CanFrame(0x100, bytes.fromhex("112233445566")),  # TIME
    CanFrame(0x180 + NODE_ID, bytes.fromhex("4300100091010F00")),  # PDOs
    CanFrame(0x280 + OTHER, bytes(8)),
    CanFrame(0x600 + OTHER, bytes.fromhex("4000100000000000")),  # SDO of another node
    CanFrame(0x580 + OTHER, bytes.fromhex("4300100092010F00")),
    CanFrame(0x600 + OTHER, bytes.fromhex("2F01200011000000")),
    CanFrame(0x580 + OTHER, bytes.fromhex("6001200000000000")),
    CanFrame(0x700 + NODE_ID, b"\x05"),  # heartbeats
    CanFrame(0x700 + OTHER, b"\x7f"),
    CanFrame(0x000, bytes((0x01, OTHER))),  # NMT
    CanFrame(0x18FEF100, bytes(8), extended=True),
    CanFrame(0x580 + NODE_ID, bytes.fromhex("43001000FFFFFFFF")[::-1], extended=True),
    CanFrame(0x580 + NODE_ID, remote=True, length=8),
    CanFrame(0x600 + NODE_ID, remote=True, length=8),
    CanFrame(0x580 + NODE_ID, bytes(12), fd=True),
)
BURST = 4


class Crowd(HostedNode):
    """The rest of a busy bus: sends a burst for every frame of the device's channel."""

    def __init__(self) -> None:
        self.traffic = cycle(TRAFFIC)
        self.sent = 0

    def start(self) -> list[CanFrame]:
        return list(TRAFFIC)

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        if frame.can_id not in (0x600 + NODE_ID, 0x580 + NODE_ID):
            return []
        self.sent += BURST
        return [next(self.traffic) for _ in range(BURST)]


class Patient(HostedNode):
    """A device that takes its time for each answer, or for some."""

    def __init__(self, node: HostedNode, pauses: Iterator[float]) -> None:
        self.node = node
        self.pauses = pauses
        self.never = threading.Event()

    def start(self) -> list[CanFrame]:
        return self.node.start()

    def receive(self, frame: CanFrame) -> list[CanFrame]:
        answers = self.node.receive(frame)
        pause = next(self.pauses) if answers else 0
        if pause:
            self.never.wait(pause)
        return answers


def verdicts(
    pytester: pytest.Pytester, *nodes: HostedNode, chosen: str, timeout: float = 1.0
) -> dict[str, tuple[str, str]]:
    """Run cases; return the verdict of each and how it left the device."""
    with hosted(*nodes) as bus:
        options = (f"--sdo-response-timeout={timeout}", "--junitxml=all.xml", "-k", chosen)
        run(pytester, NODE, *bus, *WRITABLE, *GENERATED, *options)
    found = {}
    for case in parsed(pytester.path / "all.xml").iter("testcase"):
        told = {p.attrib["name"]: p.attrib["value"] for p in case.iter("property")}
        found[told["id"]] = (told["verdict"], told.get("afterwards", ""))
    return found


def device(fault: str | None = None) -> HostedNode:
    return build_node(fault, NODE_ID)


def test_foreign_traffic(pytester: pytest.Pytester) -> None:
    quiet = verdicts(pytester, device(), chosen=SHORT)
    crowd = Crowd()
    assert verdicts(pytester, device(), crowd, chosen=SHORT) == quiet
    assert len(quiet) > 300
    seen = {verdict for verdict, _ in quiet.values()}
    assert seen <= {"pass", "info", "not testable", "unimplemented"}
    assert crowd.sent > 10_000


FAULTY = {
    "upload-toggle-ignored": "segmented-upload",
    "unknown-specifier-halts": "specifier",
    "answers-late": "abort",
    "download-too-long-accepted": "long",
    "identity-count-wrong": "upload.identity",
}


@pytest.mark.parametrize("fault", FAULTY)
def test_foreign_traffic_hides_no_fault(pytester: pytest.Pytester, fault: str) -> None:
    chosen = f"({FAULTY[fault]} or test_whole_run) and ({SHORT})"
    quiet = verdicts(pytester, device(fault), chosen=chosen, timeout=0.3)
    assert verdicts(pytester, device(fault), Crowd(), chosen=chosen, timeout=0.3) == quiet
    assert {verdict for verdict, _ in quiet.values()} >= {"fail"}


FEW = "test_abort or upload.identity or specifier.unknown or test_whole_run"


@pytest.mark.parametrize(
    ("pauses", "timeout"),
    [((0.03,), 1.0), ((0.0, 0.0, 0.0, 0.0, 0.0, 0.25), 0.5)],
    ids=["slow", "late-now-and-then"],
)
def test_a_device_that_takes_its_time(
    pytester: pytest.Pytester, pauses: tuple[float, ...], timeout: float
) -> None:
    chosen = f"({FEW}) and ({SHORT})"
    quick = verdicts(pytester, device(), chosen=chosen)
    assert len(quick) > 20
    slow = Patient(device(), cycle(pauses))
    assert verdicts(pytester, slow, chosen=chosen, timeout=timeout) == quick
