"""An adapter that loses, repeats or swaps frames fails no device, and no run is green by it."""

from unittest.mock import patch

import can
import pytest
from case_runs import run_cases
from lossy import LossyBus, run_lossy

from conformance.faults.registry import assemble
from conformance.plugin.exit_code import ExitCode
from conformance.reference.dictionary import reference_device
from conformance.reference.node import Node
from conformance.reference.server import Server
from conformance.reference.simulated_bus import SimulatedBus
from conformance.run.verdict import Verdict
from conformance.sdo.objects import Entry

SOME = ("-k", "segmented_upload and size and not foreign")


def test_what_does_not_fail_again_is_told_and_fails_no_device() -> None:
    told = []
    for seed in (1, 5, 7):
        run, mishaps = run_lossy(300, seed, *SOME)
        assert mishaps
        assert run.failed(strict=True) == []
        assert Verdict.PASS in run.verdicts.values()
        told.append((run.exit_code, run.output))
    # Some mishaps spoil nothing, and some come before the first case.
    assert any(
        status == ExitCode.BENCH_ERROR
        and "the case failed once, but not when it was repeated" in output
        and "the interface counted no lost frames" in output
        for status, output in told
    )


def test_what_a_mishap_has_spoilt_is_no_fact_about_the_device() -> None:
    """With these seeds a string was said to take no value, when it was asked for that once."""
    for seed in (3, 8):
        run, mishaps = run_lossy(300, seed, *SOME)
        assert mishaps
        assert "takes no value" not in run.output
        assert Verdict.PASS in run.verdicts.values()


def test_nothing_is_said_where_nothing_was_lost() -> None:
    run, mishaps = run_lossy(10**9, 1, *SOME)
    assert (mishaps, run.exit_code, run.failed(strict=True)) == (0, 0, [])
    assert "bench:" not in run.output


@pytest.mark.parametrize(
    ("fault", "caught_by"),
    [
        ("identity-count-wrong", "upload.identity"),
        ("upload-offset-8-bit", "segmented-upload.size[257]"),
    ],
)
def test_a_fault_is_found_all_the_same(fault: str, caught_by: str) -> None:
    run, _ = run_lossy(1000, 1, "-k", caught_by.partition("[")[0], fault=fault)
    assert any(case.startswith(caught_by) for case in run.failed())


class StoresWrongOnce(Server):
    """Stores another byte than it confirms, once."""

    stored = 0

    def store(self, entry: Entry, data: bytes) -> None:
        StoresWrongOnce.stored += 1
        super().store(entry, data[:-1] + b"!" if StoresWrongOnce.stored == 40 else data)


def test_wrong_data_behind_a_confirmation_is_no_lost_frame() -> None:
    def opened(node_ids: list[int], *_: object, **__: object) -> can.BusABC:
        node_id = node_ids[0]
        node = assemble(Node, StoresWrongOnce, node_id, reference_device(node_id), None)
        return LossyBus(SimulatedBus([node]), 10**9, 1)

    with patch("conformance.plugin.bench_opening.simulated_bus", opened):
        run = run_cases(None, "-k", "segmented-download.size or block-download.size")
    assert len(run.failed()) == 1
    assert "failed once, but not when" not in run.output


class Remembers(Server):
    """Does not answer the first read of 1018h:01 behind a request that begins with A6h or C7h."""

    met = False

    def receive(self, frame: bytes) -> list[bytes]:
        if frame[:1] in (b"\xa6", b"\xc7"):
            self.met = True
        elif self.met and frame[:4] == bytes.fromhex("40181001"):
            self.met = False
            return []
        return super().receive(frame)


def test_what_depends_on_the_case_before_is_no_lost_frame() -> None:
    def opened(node_ids: list[int], *_: object, **__: object) -> can.BusABC:
        node_id = node_ids[0]
        node = assemble(Node, Remembers, node_id, reference_device(node_id), None)
        return LossyBus(SimulatedBus([node]), 10**9, 1)

    with patch("conformance.plugin.bench_opening.simulated_bus", opened):
        run = run_cases(None, "-k", "sub-command or upload.identity")
    assert run.failed() == ["upload.identity"]
    assert "fails behind specifier.sub-command" in run.output
    assert "lost frames" not in run.output
