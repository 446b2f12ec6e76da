"""Every fault is caught by a case whose id says why. The whole table: see ``detection``."""

import pytest
from detection import TIMEOUT_OF_FAULTS, run_cases, timing_of

from conformance.faults.catalogue import build_node, faults, unusual
from conformance.faults.registry import Deviation


def name_of(deviation: Deviation) -> str:
    return deviation.name


def test_there_are_enough_of_them() -> None:
    assert len(faults()) >= 30
    assert len(unusual()) >= 8


@pytest.mark.parametrize("deviation", [*faults(), *unusual()], ids=name_of)
def test_each_says_what_it_does(deviation: Deviation) -> None:
    assert deviation.sentence.endswith(".")
    assert build_node(deviation.name, node_id=5).node_id == 5


@pytest.mark.parametrize("deviation", faults(), ids=name_of)
def test_fault_is_caught(deviation: Deviation) -> None:
    # What is judged at the end of a run needs cases before it.
    chosen = [] if deviation.caught_by.startswith("run.") else ["-k", deviation.caught_by]
    timing = [f"--response-timeout={TIMEOUT_OF_FAULTS}", *timing_of(deviation)]
    run = run_cases(deviation.name, *timing, *chosen)
    failed = run.failed(strict=deviation.soft)
    assert any(case_id.startswith(deviation.caught_by) for case_id in failed), run.output


def test_reference_server_passes() -> None:
    run = run_cases(None)
    assert len(run.verdicts) >= 80
    assert not run.failed(strict=True), run.output


@pytest.mark.parametrize("deviation", [found for found in unusual() if found.soft], ids=name_of)
def test_soft_variant_misses_a_should(deviation: Deviation) -> None:
    """A variant that is called soft without need would hide a false alarm under --strict."""
    run = run_cases(deviation.name)
    assert run.failed(strict=True)
    assert not run.failed(), run.output
