"""Cases that the oracle judges, on a channel that is not the default one of the device."""

import pytest
from plugin_runs import NODE_ID, hosted, run

from conformance.faults.catalogue import build_node

pytest_plugins = ["pytester"]

CHANNELS = {
    "640:5C0": ("40060000", "C0050000"),
    "18FF0B05:18FF0C05": ("050BFF38", "050CFF38"),
}
OBJECTS = ("--sdo-object=2010=visible_string", "--sdo-object=2011=domain")
# Of the matrix, frames of a wrong length are there, remote ones, and those with another identifier.
JUDGED = "matrix.segmented-upload-last or random.interrupted or pairs.superseded[block-upload-end"


def judge(
    pytester: pytest.Pytester, name: str | None, option: str, chosen: str
) -> pytest.RunResult:
    node = build_node(name, NODE_ID)
    for sub_index, value in enumerate(CHANNELS[option], 1):
        node.channels[1].record.entries[sub_index].value = bytes.fromhex(value)
    with hosted(node) as bus:
        device = (f"--node-id={NODE_ID}", *bus, *OBJECTS, f"--sdo-channel={option}")
        allowed = ("--sdo-allow=other-nodes", "--sdo-allow=read-only-probes")
        thorough = ("--sdo-thorough", "--sdo-examples=5")
        return run(pytester, *device, *allowed, *thorough, "-k", chosen)


@pytest.mark.parametrize("option", CHANNELS)
def test_a_right_server_passes(pytester: pytest.Pytester, option: str) -> None:
    result = judge(pytester, None, option, JUDGED)
    assert result.ret == pytest.ExitCode.OK, result.stdout.str()
    assert result.parseoutcomes()["passed"] > 60
    # Where the identifiers of the channel have 29 bits, no frame has the same with 11.
    assert result.parseoutcomes().get("skipped", 0) == (3 if option.startswith("18FF") else 0)


def test_a_faulty_server_fails(pytester: pytest.Pytester) -> None:
    result = judge(pytester, "upload-toggle-ignored", "640:5C0", "matrix.segmented-upload-last[70h")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*broken rule: segmented-upload.toggle: *"])
