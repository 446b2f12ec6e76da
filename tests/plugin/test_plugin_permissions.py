"""Nothing of NMT or 12xxh without permission, and runs on another channel than the default one."""

import shutil
from pathlib import Path

import pytest
from plugin_runs import NODE_ID, Watched, hosted, run, the_report

from conformance.faults.catalogue import build_node

pytest_plugins = ["pytester"]

PLC = Path(__file__).parents[1] / "eds" / "files" / "plc.dcf"
NETWORK = "test_channel or test_nmt"


class Communicating(Watched):
    """Picks out NMT commands and what would write to communication objects."""

    @property
    def commands(self) -> list[bytes]:
        return [frame.data for frame in self.frames if frame.can_id == 0]

    @property
    def writes(self) -> set[int]:
        written = {
            int.from_bytes(frame.data[1:3], "little")
            for frame in self.frames
            if frame.can_id == 0x600 + NODE_ID and frame.data[0] >> 5 == 1
        }
        return {index for index in written if index < 0x2000}


def cases(pytester: pytest.Pytester, *options: str) -> tuple[pytest.RunResult, Communicating]:
    """Run the cases on channels and NMT against a device that is not the built-in one."""
    watched = Communicating(build_node(None, NODE_ID))
    objects = (
        "--sdo-object=2004=unsigned32",
        "--sdo-object=2010=visible_string",
        "--sdo-object=2011=domain",
    )
    with hosted(watched) as bus:
        device = (f"--node-id={NODE_ID}", *bus, *objects)
        return run(pytester, *device, "-k", NETWORK, *options), watched


def test_without_permission(pytester: pytest.Pytester) -> None:
    """Reading is allowed, and each case that needs more says what to add."""
    result, watched = cases(pytester)
    counts = result.parseoutcomes()
    assert result.ret == 0
    assert counts["passed"] < 10 < counts["skipped"]
    assert watched.commands == []
    assert watched.writes == set()
    text = result.stdout.str()
    assert "needs permission to send NMT commands to the device: add --sdo-allow=nmt" in text
    assert "add --sdo-allow=sdo-parameters" in text


@pytest.mark.parametrize(
    ("name", "other", "indices"),
    [("nmt", "sdo-parameters", {0x1017}), ("sdo-parameters", "nmt", {0x1200, 0x1201, 0x1202})],
)
def test_one_permission(
    pytester: pytest.Pytester, name: str, other: str, indices: set[int]
) -> None:
    result, watched = cases(pytester, f"--sdo-allow={name}")
    assert result.ret == 0
    assert bool(watched.commands) is (name == "nmt")
    assert {data[1] for data in watched.commands} <= {NODE_ID}
    assert watched.writes == indices
    text = result.stdout.str()
    assert f"add --sdo-allow={other}" in text
    assert f"add --sdo-allow={name}\n" not in text


def test_all_permissions(pytester: pytest.Pytester) -> None:
    permissions = (
        *("nmt", "sdo-parameters", "store-parameters"),
        *("other-nodes", "read-only-probes"),
    )
    result, watched = cases(pytester, *(f"--sdo-allow={name}" for name in permissions))
    assert result.ret == 0
    assert "skipped" not in result.parseoutcomes()
    assert not any(channel.record.is_valid for channel in watched.node.channels[1:])
    assert watched.node.state.serves_sdo
    assert watched.node.heartbeat_time.value == bytes(2)
    assert watched.node.power_on == watched.node.defaults, "what was stored is stored again"


SHORT_IDS, LONG_IDS = ("40060000", "C0050000"), ("050BFF38", "050CFF38")


@pytest.mark.parametrize(
    ("option", "request_id", "values"),
    [
        ("640:5C0", "640", SHORT_IDS),
        ("18FF0B05:18FF0C05", "18FF0B05", LONG_IDS),
        ("plc.dcf:1280", "640", SHORT_IDS),
        ("plc.dcf:1283", "18FF0B05", LONG_IDS),
    ],
)
def test_another_channel(
    pytester: pytest.Pytester, option: str, request_id: str, values: tuple[str, str]
) -> None:
    """The whole of the cases on a channel that was configured before; it stays as it is."""
    shutil.copy(PLC, pytester.path)
    node = build_node(None, NODE_ID)
    for sub_index, value in enumerate(values, 1):
        node.channels[1].record.entries[sub_index].value = bytes.fromhex(value)
    objects = (
        "--sdo-object=2004=unsigned32",
        "--sdo-object=2010=visible_string",
        "--sdo-object=2011=domain",
    )
    with hosted(node) as bus:
        result = run(
            pytester,
            *(f"--node-id={NODE_ID}", *bus, *objects, f"--sdo-channel={option}"),
            *("--sdo-allow=sdo-parameters", "-k", "test_expedited or test_frame or test_channel"),
        )
    assert result.ret == 0, result.stdout.str()
    assert result.parseoutcomes()["passed"] > 50
    assert node.channels[1].record.is_valid
    assert not node.channels[2].record.is_valid
    log = (the_report(pytester) / "bus.log").read_text()
    assert f" {request_id}#4000100000000000" in log
