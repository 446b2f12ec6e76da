"""What the table of ``detection`` rests on. The table itself is a program of its own."""

from dataclasses import replace

import pytest
from case_runs import Run, run_cases
from detection import Sieve, files_of, idle_cases, problem_with, scripts

from conformance.faults.catalogue import build_node, faults, find_deviation, unusual
from conformance.faults.registry import Deviation
from conformance.run.verdict import Verdict


def name_of(deviation: Deviation) -> str:
    return deviation.name


def known(name: str) -> Deviation:
    deviation = find_deviation(name)
    assert deviation is not None
    return deviation


@pytest.mark.parametrize("deviation", [*faults(), *unusual()], ids=name_of)
def test_each_says_what_it_does(deviation: Deviation) -> None:
    assert deviation.sentence.endswith(".")
    assert build_node(deviation.name, node_id=5).node_id == 5


def test_reference_server_passes() -> None:
    run = run_cases(None, *scripts())
    assert len(run.verdicts) >= 1000
    assert not run.failed(strict=True), run.output


def test_a_fault_has_to_be_caught_by_the_case_that_it_names() -> None:
    fault = replace(known("upload-toggle-ignored"), caught_by=("segmented-upload.toggle",))
    caught = {"segmented-upload.toggle-first": Verdict.FAIL}
    assert problem_with(fault, Run(fault.name, verdicts=dict(caught))) == ""
    assert problem_with(fault, Run(fault.name)) == "NOT CAUGHT"
    elsewhere = replace(fault, caught_by=("segmented-download.toggle",))
    assert "by no case called" in problem_with(elsewhere, Run(fault.name, verdicts=caught))


def test_each_case_that_a_fault_names_has_to_fail() -> None:
    names = ("segmented-upload.toggle-first", "segmented-upload.toggle-repeated")
    fault = replace(known("upload-toggle-ignored"), caught_by=names)
    caught = dict.fromkeys(names, Verdict.FAIL)
    assert problem_with(fault, Run(fault.name, verdicts=dict(caught))) == ""
    del caught[names[0]]
    assert names[0] in problem_with(fault, Run(fault.name, verdicts=caught))


def test_a_soft_fault_must_not_fail_without_strict() -> None:
    fault = known("answers-remote-with-abort")
    missed = {"frame.remote-ignored": Verdict.NON_STRICT}
    assert problem_with(fault, Run(fault.name, verdicts=dict(missed))) == ""
    failed = missed | {"matrix.idle[remote-0]": Verdict.FAIL}
    assert "fails: matrix.idle" in problem_with(fault, Run(fault.name, verdicts=failed))


def test_an_unusual_server_must_not_fail() -> None:
    server = next(found for found in unusual() if not found.soft)
    missed = {"upload.size[1]": Verdict.NON_STRICT}
    assert problem_with(server, Run(server.name, verdicts={"upload.size[1]": Verdict.PASS})) == ""
    assert "FALSE ALARM" in problem_with(server, Run(server.name, verdicts=dict(missed)))
    soft = replace(server, soft=True)
    assert problem_with(soft, Run(server.name, verdicts=missed)) == ""


def test_a_variant_is_not_called_soft_without_need() -> None:
    """It would hide a false alarm under --strict; only a whole run can tell."""
    server = next(found for found in unusual() if found.soft)
    run = Run(server.name, verdicts={"upload.size[1]": Verdict.PASS})
    assert problem_with(server, run) == ""
    assert "misses no SHOULD" in problem_with(server, run, whole=True)
    run.verdicts["upload.size[1]"] = Verdict.NON_STRICT
    assert problem_with(server, run, whole=True) == ""


def test_a_case_that_no_server_fails_is_named() -> None:
    clean = Run("clean", verdicts={"a": Verdict.PASS, "b": Verdict.PASS})
    assert idle_cases(frozenset({"a"}), clean) == ["b"]


def test_what_can_say_nothing_new_of_a_faulty_server_is_left_out() -> None:
    fault = known("upload-toggle-ignored")
    named, script, field = fault.caught_by[0], "abort.repeated", "matrix.idle[40h]"
    run = Run(fault.name)
    sieve = Sieve(fault, run, frozenset({"abort.repeated", "matrix.idle"}))
    assert all(map(sieve.wants, (named, script, field)))
    run.verdicts["upload.size[1]"] = Verdict.FAIL
    assert not sieve.wants(script), "a script has caught it already"
    assert sieve.wants("abort.unproven"), "no server has failed this case yet"
    assert sieve.wants(field), "the matrix has not caught it yet"
    assert sieve.wants(named), "the case that says why has not caught it yet"
    run.verdicts[named] = Verdict.FAIL
    assert not sieve.wants(named)


@pytest.mark.parametrize("name", [None, "upload-toggle-ignored", "block-download-gap-aborted"])
def test_without_threads_and_time_the_verdicts_are_the_same(name: str | None) -> None:
    files = [*files_of("segmented-upload"), *files_of("block-download")]
    # A thread of a busy machine may take its time; the few that are silent are waited for.
    chosen = ("--sdo-response-timeout=2", "-k", "toggle or lost", *files)
    simulated = run_cases(name, *chosen)
    assert simulated.verdicts == run_cases(name, *chosen, simulated=False).verdicts
    assert len(simulated.verdicts) > 5
