"""Default values: loaded by the suite where that is permitted, or by the user."""

from pathlib import Path

import pytest
from plugin_runs import NODE_ID, Watched, hosted, run, self_test

from conformance.faults.catalogue import build_node
from conformance.reference import dictionary
from conformance.reference.built_in_device import reference_entries
from conformance.reference.built_in_eds import eds_of
from conformance.reference.node import Node
from conformance.sdo.layout import Multiplexer
from conformance.sdo.objects import Entry

pytest_plugins = ["pytester"]

NUMBER, TEXT = Multiplexer(0x2004), Multiplexer(0x2010)
DEFAULTS = "od.load-defaults or od.default-of-parameter"
LOAD = bytes.fromhex("231110016C6F6164")
ALL = ("load-defaults", "nmt", "store-parameters", "sdo-parameters")


class Loaded(Watched):
    """Counts what came that loads defaults."""

    @property
    def loads(self) -> int:
        """How often "load" was written."""
        return sum(frame.data == LOAD for frame in self.frames)

    @property
    def commands(self) -> int:
        """How many NMT commands there were."""
        return sum(frame.can_id == 0 for frame in self.frames)

    def values(self) -> dict[Multiplexer, bytes]:
        return {mux: entry.value for mux, entry in self.node.objects.items()}


def described(folder: Path, node: Node, *objects: str) -> str:
    """Write the EDS of a node and a description; return the option."""
    (folder / "device.eds").write_text(eds_of(node), encoding="utf-8")
    lines = ['eds = "device.eds"', "[objects]", 'writable = "all-rw"', *objects]
    (folder / "device.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return "--sdo-device=device.toml"


def cases(
    pytester: pytest.Pytester, name: str, *options: str, objects: tuple[str, ...] = ()
) -> tuple[pytest.RunResult, Loaded]:
    watched = Loaded(build_node(name, NODE_ID))
    device = described(pytester.path, watched.node, *objects)
    with hosted(watched) as bus:
        chosen = (f"--node-id={NODE_ID}", device, *bus, "-k", DEFAULTS, *options)
        return run(pytester, *chosen), watched


def allowed(*names: str) -> tuple[str, ...]:
    return tuple(f"--sdo-allow={name}" for name in names)


def test_the_suite_loads_them_once_and_puts_back_what_was_there(
    pytester: pytest.Pytester,
) -> None:
    result, watched = cases(pytester, "parameters-stored", *allowed(*ALL))
    assert result.ret == pytest.ExitCode.OK, result.stdout.str()
    assert "skipped" not in result.parseoutcomes()
    assert watched.loads == 1
    assert watched.commands == 2
    assert watched.node.objects.find(NUMBER).value == b"\4\3\2\1"
    assert [value for entry, _, value in watched.node.power_on] == list(watched.values().values())
    result.stdout.no_fnmatch_line("not restored:*")


def test_what_is_not_loaded_fails(pytester: pytest.Pytester) -> None:
    result, watched = cases(pytester, "load-defaults-ignored", *allowed(*ALL), "-v")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(
        [
            "od.default-of-parameter[[]2004h:00]: FAIL *",
            "  expected: 2004h:00 reads 4 bytes: 11 22 33 44 after the defaults were loaded",
            "  actual: 4 bytes: 04 03 02 01",
        ]
    )
    assert watched.node.objects.find(NUMBER).value == b"\4\3\2\1"


@pytest.mark.parametrize("lacking", ["load-defaults", "nmt", "store-parameters"])
def test_what_to_permit_is_said(pytester: pytest.Pytester, lacking: str) -> None:
    names = [name for name in ALL if name != lacking]
    result, watched = cases(pytester, "parameters-stored", *allowed(*names))
    assert result.ret == pytest.ExitCode.OK
    assert set(result.parseoutcomes()) == {"skipped", "deselected"}
    result.stdout.fnmatch_lines([f"not testable (* cases): *add --sdo-allow={lacking}; or load *"])
    assert watched.loads == 0
    assert watched.node.objects.find(NUMBER).value == b"\4\3\2\1"


def test_the_user_has_loaded_them(pytester: pytest.Pytester) -> None:
    """No permission is needed, and nothing is written."""
    objects = ("at-defaults = true",)
    result, watched = cases(pytester, "no-serial-number", objects=objects)
    assert result.ret == pytest.ExitCode.OK
    assert result.parseoutcomes()["passed"] > 20
    assert watched.commands == 0
    configured, _ = cases(pytester, "parameters-stored", "-v", objects=objects)
    assert configured.ret == pytest.ExitCode.TESTS_FAILED
    configured.stdout.fnmatch_lines(["od.default-of-parameter[[]2004h:00]: FAIL *"])


def test_a_default_with_spaces_around_it(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An EDS cannot hold them."""

    def entries(node_id: int) -> dict[Multiplexer, Entry]:
        found = reference_entries(node_id)
        found[TEXT].value = b"  a text "
        return found

    monkeypatch.setattr(dictionary, "reference_entries", entries)
    result = self_test(pytester, "--sdo-simulated", "-k", "od.default-of-parameter and 2010h")
    result.assert_outcomes(passed=1)
